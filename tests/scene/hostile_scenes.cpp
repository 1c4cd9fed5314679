// SPDX-License-Identifier: Apache-2.0
#include "tests/scene/scenes.h"

namespace kiln::test {

namespace {

const char* const kHead = R"({"asset":{"version":"2.0"},)";

std::string many(const std::string& piece, std::size_t count) {
    std::string text;
    for (std::size_t i = 0; i < count; ++i) text += piece;
    return text;
}

std::string with_binary_change(std::size_t at, char value) {
    std::string bytes = glb_of(scene_of("{}"), "data");
    bytes[at] = value;
    return bytes;
}

std::string pbr(const std::string& members) {
    return scene_of(R"({"pbrMetallicRoughness":{)" + members + "}}");
}

std::string extension(const std::string& name, const std::string& members) {
    return scene_of(R"({"extensions":{"KHR_materials_)" + name + R"(":{)" + members + "}}}");
}

/// A texture of a data: URI or a view.
std::string textured(const std::string& image, const std::string& rest = "") {
    return scene_of(R"({"pbrMetallicRoughness":{"metallicRoughnessTexture":{"index":0}}})",
                    R"("textures":[{"source":0}],"images":[)" + image + "]," + rest);
}

void add_texts(std::vector<HostileScene>& all) {
    const auto malformed = [&](const char* name, std::string bytes, const char* pointer = "") {
        all.push_back({name, std::move(bytes), "malformed", pointer});
    };
    malformed("nothing", "");
    malformed("a word", "glTF!");
    malformed("an open object", "{\"asset\":", "/asset");
    malformed("no UTF-8", "{\"asset\":\"\xFF\xFE\"}", "/asset");
    malformed("a byte order mark", "\xEF\xBB\xBF{}");
    malformed("a NUL byte", std::string("{\"asset\":\0{}}", 13));
    malformed("two documents", scene_of("{}") + scene_of("{}"));
    malformed("a name twice", R"({"asset":{"version":"2.0"},"asset":{}})", "/asset");
    malformed("a number no double holds", R"({"asset":{"version":"2.0"},"scene":1e999})", "/scene");
    const std::string deep = [] {
        std::string pointer;
        for (int i = 0; i < 32; ++i) pointer += "/0";
        return pointer;
    }();
    malformed("nested 100000 deep", std::string(100000, '['), deep.c_str());
    malformed("extras nested deep",
              scene_of(R"({"extras":)" + std::string(40, '[') + std::string(40, ']') + "}"),
              ("/materials/0/extras" + deep.substr(0, 2 * 29)).c_str());
    malformed("two million values", "[" + many("0,", 2000000) + "0]", "/1499999");
    malformed("more bytes than a scene has", std::string((32u << 20) + 1, ' '));
    malformed("an XML document", "<?xml version=\"1.0\"?><COLLADA/>");
    malformed("a PNG", png_of(1, 1, {0, 0, 0, 0}));
}

void add_containers(std::vector<HostileScene>& all) {
    const auto malformed = [&](const char* name, std::string bytes) {
        all.push_back({name, std::move(bytes), "malformed", ""});
    };
    const std::string good = glb_of(scene_of("{}"), "data");
    malformed("glb: the magic alone", "glTF");
    malformed("glb: a header alone", good.substr(0, 12));
    malformed("glb: cut in the JSON", good.substr(0, 40));
    malformed("glb: cut by a byte", good.substr(0, good.size() - 1));
    malformed("glb: a byte too many", good + "x");
    malformed("glb: a chunk after the end", good + std::string("\0\0\0\0XYZW", 8));
    malformed("glb: version 1", with_binary_change(4, 1));
    malformed("glb: a length of 4 GB", with_binary_change(11, '\xFF'));
    malformed("glb: a chunk of 4 GB", with_binary_change(15, '\xFF'));
    malformed("glb: the first chunk is binary", with_binary_change(16, 'B'));
    malformed("glb: JSON twice",
              glb_of(scene_of("{}"), "").substr(0, 4) + std::string("\2\0\0\0\x2C\0\0\0", 8) +
                  many(std::string("\4\0\0\0JSON{}  ", 12), 2) + std::string(8, 'x'));
    malformed("glb: the JSON is none", glb_of("hello", ""));
    malformed("glb: empty JSON", glb_of("", ""));
    all.push_back(
        {"glb: a list of materials", glb_of(R"({"materials":[]})", ""), "invalid_scene", "/asset"});
}

void add_structure(std::vector<HostileScene>& all) {
    const auto invalid = [&](const char* name, std::string bytes, const char* pointer) {
        all.push_back({name, std::move(bytes), "invalid_scene", pointer});
    };
    const auto rest = [](const std::string& members) { return kHead + members + "}"; };
    invalid("an array", "[]", "");
    invalid("null", "null", "");
    invalid("neither glTF nor a list", "{}", "/materials");
    invalid("an asset without version", R"({"asset":{}})", "/asset/version");
    invalid("glTF 1", R"({"asset":{"version":"1.0"}})", "/asset/version");
    invalid("a version that is a number", R"({"asset":{"version":2.0}})", "/asset/version");
    invalid("a version to come", R"({"asset":{"version":"2.0","minVersion":"2.9"}})",
            "/asset/minVersion");
    invalid("an asset that is a list", R"({"asset":[]})", "/asset");
    invalid("scenes are an object", rest(R"("scenes":{})"), "/scenes");
    invalid("a scene that is a number", rest(R"("scenes":[7])"), "/scenes/0");
    invalid("the default scene is missing", rest(R"("scene":3,"scenes":[{}])"), "/scene");
    invalid("scene −1", rest(R"("scene":-1,"scenes":[{}])"), "/scene");
    invalid("scene 0.5", rest(R"("scene":0.5,"scenes":[{}])"), "/scene");
    invalid("scene 2^64", rest(R"("scene":18446744073709551616,"scenes":[{}])"), "/scene");
    invalid("a root that is missing", rest(R"("scenes":[{"nodes":[5]}])"), "/scenes/0/nodes/0");
    invalid("roots are a word", rest(R"("scenes":[{"nodes":"all"}])"), "/scenes/0/nodes");
    invalid("a node is its own child",
            rest(R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[0]}])"), "/nodes/0");
    invalid("two nodes in a loop",
            rest(R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"children":[0]}])"),
            "/nodes/0");
    invalid("a node with two parents",
            rest(R"("scenes":[{"nodes":[0,1]}],"nodes":[{"children":[1]},{}])"), "/nodes/1");
    invalid("a child that is missing",
            rest(R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[9]}])"), "/nodes/0/children/0");
    invalid("a mesh that is missing", rest(R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":1}])"),
            "/nodes/0/mesh");
    invalid("a mesh without primitives",
            rest(R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{}])"),
            "/meshes/0/primitives");
    invalid("primitives are a number",
            rest(R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":1}])"),
            "/meshes/0/primitives");
    invalid("a material that is missing",
            rest(R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
                 R"("meshes":[{"primitives":[{"material":0}]}])"),
            "/meshes/0/primitives/0/material");
    invalid("a material that is a word", scene_of("\"gold\""), "/materials/0");
}

void add_bounds(std::vector<HostileScene>& all) {
    const auto invalid = [&](const char* name, std::string bytes, const char* pointer) {
        all.push_back({name, std::move(bytes), "invalid_scene", pointer});
    };
    const auto rest = [](const std::string& members) { return kHead + members + "}"; };
    invalid("more nodes than may be",
            rest(R"("scenes":[{}],"nodes":[)" + many("{},", 200000) + "{}]"), "/nodes");
    invalid("used materials beyond the bound",
            rest(R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)" +
                 [] {
                     std::string list;
                     for (int i = 0; i < 4097; ++i)
                         list += (i ? "," : "") + (R"({"material":)" + std::to_string(i) + "}");
                     return list;
                 }() +
                 R"(]}],"materials":[)" + many("{},", 4096) + "{}]"),
            "/materials/4096");
    invalid("extensionsRequired is a word", rest(R"("extensionsRequired":"all")"),
            "/extensionsRequired");
    invalid("a required extension that is a number", rest(R"("extensionsRequired":[1])"),
            "/extensionsRequired/0");
    invalid("animations are a number", rest(R"("animations":1)"), "/animations");
    invalid("an animation's pointer is a list",
            rest(R"("animations":[{"channels":[{"target":{"extensions":{)"
                 R"("KHR_animation_pointer":{"pointer":[]}}}}]}])"),
            "/animations/0/channels/0/target/extensions/KHR_animation_pointer/pointer");
    invalid("a mapping to no material",
            rest(R"("extensions":{"KHR_materials_variants":{"variants":[{"name":"a"}]}},)"
                 R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)"
                 R"({"extensions":{"KHR_materials_variants":{"mappings":[)"
                 R"({"material":3,"variants":[0]}]}}}]}])"),
            "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings/0/material");
}

void add_materials(std::vector<HostileScene>& all) {
    const auto invalid = [&](const char* name, std::string bytes, const std::string& pointer) {
        all.push_back({name, std::move(bytes), "invalid_scene", "/materials/0/" + pointer});
    };
    const std::string base = "pbrMetallicRoughness/", more = "extensions/KHR_materials_";
    invalid("pbr is a list", scene_of(R"({"pbrMetallicRoughness":[]})"), "pbrMetallicRoughness");
    invalid("roughness 2", pbr(R"("roughnessFactor":2)"), base + "roughnessFactor");
    invalid("roughness −1", pbr(R"("roughnessFactor":-1)"), base + "roughnessFactor");
    invalid("roughness is true", pbr(R"("roughnessFactor":true)"), base + "roughnessFactor");
    invalid("metallic is null", pbr(R"("metallicFactor":null)"), base + "metallicFactor");
    invalid("metallic 1e300", pbr(R"("metallicFactor":1e300)"), base + "metallicFactor");
    invalid("a colour of three", pbr(R"("baseColorFactor":[1,1,1])"), base + "baseColorFactor");
    invalid("a colour of words", pbr(R"("baseColorFactor":["a","b","c","d"])"),
            base + "baseColorFactor/0");
    invalid("a colour above 1", pbr(R"("baseColorFactor":[1,9,1,1])"), base + "baseColorFactor/1");
    invalid("ior 0.5", extension("ior", R"("ior":0.5)"), more + "ior/ior");
    invalid("ior 2^32 + 1", extension("ior", R"("ior":4294967297)"), more + "ior/ior");
    invalid("ior −2", extension("ior", R"("ior":-2)"), more + "ior/ior");
    invalid("sheen of a word", extension("sheen", R"("sheenColorFactor":"red")"),
            more + "sheen/sheenColorFactor");
    invalid("clear coat 7", extension("clearcoat", R"("clearcoatFactor":7)"),
            more + "clearcoat/clearcoatFactor");
    invalid("transmission of a list",
            scene_of(R"({"pbrMetallicRoughness":{"metallicFactor":0},"extensions":{)"
                     R"("KHR_materials_transmission":{"transmissionFactor":[1]}}})"),
            more + "transmission/transmissionFactor");
    invalid("specular colour below 0", extension("specular", R"("specularColorFactor":[-1,0,0])"),
            more + "specular/specularColorFactor/0");
    invalid("an extension that is null", scene_of(R"({"extensions":{"KHR_materials_unlit":null}})"),
            more + "unlit");
    invalid("extensions are a list", scene_of(R"({"extensions":[]})"), "extensions");
    invalid("a name that is a number", scene_of(R"({"name":7})"), "name");
    invalid("a texture without index", pbr(R"("metallicRoughnessTexture":{})"),
            base + "metallicRoughnessTexture/index");
    invalid("a texture that is missing", pbr(R"("metallicRoughnessTexture":{"index":4})"),
            base + "metallicRoughnessTexture/index");
}

void add_images(std::vector<HostileScene>& all) {
    const auto invalid = [&](const char* name, std::string bytes, const char* pointer) {
        all.push_back({name, std::move(bytes), "invalid_scene", pointer});
    };
    // Read, with every value that the texture could have: nothing is wrong but the image.
    const auto unread = [&](const char* name, std::string bytes) {
        all.push_back({name, std::move(bytes), "", ""});
    };
    const auto view = [](const std::string& members, const std::string& buffers) {
        return textured(R"({"bufferView":0})",
                        R"("bufferViews":[{)" + members + R"(}],"buffers":[)" + buffers + "],");
    };
    const auto data = [](const std::string& bytes) {
        return textured(R"({"uri":"data:image/png;base64,)" + base64(bytes) + "\"}");
    };
    const std::string buffer =
        R"({"byteLength":4,"uri":"data:application/octet-stream;base64,AAAAAA=="})";
    invalid("an image that is missing",
            scene_of(R"({"pbrMetallicRoughness":{"metallicRoughnessTexture":{"index":0}}})",
                     R"("textures":[{"source":2}],)"),
            "/textures/0/source");
    invalid("a view that is missing", textured(R"({"bufferView":9})"), "/images/0/bufferView");
    invalid("a view without length", view(R"("buffer":0)", buffer), "/bufferViews/0/byteLength");
    invalid("a view past the end", view(R"("buffer":0,"byteLength":5)", buffer), "/bufferViews/0");
    invalid("a view that starts past the end",
            view(R"("buffer":0,"byteOffset":5,"byteLength":0)", buffer), "/bufferViews/0");
    invalid("offset and length wrap around",
            view(R"("buffer":0,"byteOffset":4,"byteLength":9007199254740991)", buffer),
            "/bufferViews/0");
    invalid("a length that no double holds",
            view(R"("buffer":0,"byteLength":18446744073709551615)", buffer),
            "/bufferViews/0/byteLength");
    invalid("a length of −1", view(R"("buffer":0,"byteLength":-1)", buffer),
            "/bufferViews/0/byteLength");
    invalid("a uri that is a list", textured(R"({"uri":[]})"), "/images/0/uri");
    unread("a path out of the folder", textured(R"({"uri":"../../../etc/passwd"})"));
    unread("an absolute file", textured(R"({"uri":"file:///etc/passwd"})"));
    unread("another machine", textured(R"({"uri":"http://127.0.0.1:1/x.png"})"));
    unread("base64 that is none", textured(R"({"uri":"data:image/png;base64,####"})"));
    unread("a data: URI without base64", textured(R"({"uri":"data:image/png,abc"})"));
    unread("a buffer elsewhere",
           view(R"("buffer":0,"byteLength":4)", R"({"byteLength":4,"uri":"x.bin"})"));
    unread("an image of nothing", data(""));
    unread("an image of a GIF", data("GIF89a..."));
    const std::string png = png_of(2, 2, std::vector<unsigned char>(16, 128));
    unread("base64 with a line's end within",
           textured(R"({"uri":"data:image/png;base64,)" + base64(png).insert(8, "\\n") + "\"}"));
    unread("a buffer whose base64 ends early",
           view(R"("buffer":0,"byteLength":4)",
                R"({"byteLength":4,"uri":"data:application/octet-stream;base64,AA#AAA=="})"));
    unread("a PNG cut short", data(png.substr(0, png.size() - 30)));
    std::string huge = png;
    huge.replace(16, 8, std::string("\x7F\xFF\xFF\xFF\x7F\xFF\xFF\xFF", 8));
    unread("a PNG that says 2^31 x 2^31", data(huge));
    std::string bent = png;
    bent[bent.size() - 20] = static_cast<char>(bent[bent.size() - 20] ^ 0x5A);
    unread("a PNG with a wrong byte", data(bent));
    const std::string jpeg = jpeg_of(16, 16, std::vector<unsigned char>(1024, 77));
    unread("a JPEG cut short", data(jpeg.substr(0, jpeg.size() / 2)));
    std::string wide = jpeg;
    const std::size_t frame = wide.find(std::string("\xFF\xC0", 2));
    wide.replace(frame + 5, 4, "\xFF\xFF\xFF\xFF");
    unread("a JPEG that says 65535 x 65535", data(wide));
}

void add_lists(std::vector<HostileScene>& all) {
    const auto invalid = [&](const char* name, const std::string& material, const char* pointer) {
        all.push_back({name, R"({"materials":[)" + material + "]}", "invalid_scene", pointer});
    };
    invalid("list: empty", "", "/materials");
    invalid("list: an unknown lobe", R"({"lobes":["glitter"]})", "/materials/0/lobes/0");
    invalid("list: a lobe twice", R"({"lobes":["metal","metal"]})", "/materials/0/lobes/1");
    invalid("list: an unknown field", R"({"colour":1})", "/materials/0/colour");
    invalid("list: roughness 1.5", R"({"lobes":["metal"],"roughness":1.5})",
            "/materials/0/roughness");
    invalid("list: a range that falls", R"({"lobes":["metal"],"roughness":[0.7,0.4]})",
            "/materials/0/roughness");
    invalid("list: a range of three", R"({"lobes":["metal"],"roughness":[0,0.5,1]})",
            "/materials/0/roughness");
    invalid("list: sheen roughness without sheen", R"({"lobes":["metal"],"sheen_roughness":1})",
            "/materials/0/sheen_roughness");
    invalid("list: ior and f0", R"({"lobes":["dielectric"],"ior":1.4,"f0":0.04})",
            "/materials/0/ior");
    invalid("list: measured and lobes",
            R"({"lobes":["metal"],"measured":")" + measurement('a') + "\"}", "/materials/0/lobes");
    invalid("list: measured by a file's name", R"({"measured":"../../etc/passwd"})",
            "/materials/0/measured");
    invalid("list: measured by no text", R"({"measured":7})", "/materials/0/measured");
    invalid("list: measured and not used, by half a hash",
            R"({"used":false,"measured":"sha256:0123"})", "/materials/0/measured");
    invalid("list: a name of a thousand", R"({"name":")" + std::string(1000, 'n') + "\"}",
            "/materials/0/name");
}

}  // namespace

std::vector<HostileScene> hostile_scenes() {
    std::vector<HostileScene> all;
    add_texts(all);
    add_containers(all);
    add_structure(all);
    add_bounds(all);
    add_materials(all);
    add_images(all);
    add_lists(all);
    return all;
}

}  // namespace kiln::test
