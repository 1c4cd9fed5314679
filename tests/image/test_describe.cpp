// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <map>

#include "server/base/version.h"
#include "server/image/image.h"
#include "server/spec/spec.h"
#include "tests/image/tables.h"

namespace {

using namespace kiln;

const Provenance kProvenance = {
    .kernel_digest = "abc", .numerics = "cpu-exact-1", .key = "def", .standard_error_max = 0.1};

std::map<std::string, std::string> described(const JobSpec& job) {
    const Metadata all = describe(job, kProvenance);
    std::map<std::string, std::string> by_key(all.begin(), all.end());
    EXPECT_EQ(by_key.size(), all.size()) << "a key is there twice";
    return by_key;
}

JobSpec job_of(const std::string& text) { return parse_job(text); }

const char* const kSplitSum =
    R"({"quantities": ["split_sum_scale", "split_sum_bias"], "resolution": [256, 128]})";

const char* const kOdd = R"({
  "quantities": ["directional_albedo", "multiscatter_albedo"], "resolution": [33, 1],
  "layout": {"x": {"parameter": "alpha", "mapping": "square", "grid": "node", "flip": true,
                   "range": [0.1, 0.7]},
             "y": {"parameter": "NoV", "mapping": "sqrt"}},
  "sample_count": 4096, "sampler": "lattice", "importance": "ndf", "seed": 9007199254740991,
  "microfacet": {"masking": "smith_separable"}, "output": {"format": "png", "pixel": "uint16"}})";

TEST(Describe, TheJobAloneMakesTheFileAgain) {
    for (const char* text : {kSplitSum, kOdd}) {
        const JobSpec job = job_of(text);
        for (const auto& [format, pixel] : {std::pair{ImageFormat::exr, PixelType::half},
                                            std::pair{ImageFormat::png, PixelType::uint8}}) {
            const Table table = tables::noise(2, 2, 2, 0, 1);
            const Decoded decoded =
                decode(encode(table, format, pixel, describe(job, kProvenance)).bytes);
            const std::map<std::string, std::string> read(decoded.metadata.begin(),
                                                          decoded.metadata.end());
            EXPECT_EQ(parse_job(read.at("kiln.job")), job);
        }
    }
}

TEST(Describe, SaysEverythingThatReproducesTheTable) {
    auto read = described(job_of(kOdd));
    EXPECT_EQ(read["kiln.quantities"], "directional_albedo multiscatter_albedo");
    EXPECT_EQ(read["kiln.grid"], "x node, y center");
    EXPECT_EQ(read["kiln.layout"], "custom");
    EXPECT_EQ(read["kiln.alpha_mapping"], "alpha = roughness^2");
    EXPECT_EQ(read["kiln.distribution"], "ggx");
    EXPECT_EQ(read["kiln.masking"], "smith_separable");
    EXPECT_EQ(read["kiln.fresnel"], "none");
    EXPECT_EQ(read["kiln.sampler"], "lattice");
    EXPECT_EQ(read["kiln.importance"], "ndf");
    EXPECT_EQ(read["kiln.sample_count"], "4096");
    EXPECT_EQ(read["kiln.seed"], "9007199254740991");
    EXPECT_EQ(read["kiln.version"], kVersion);
    EXPECT_EQ(read["kiln.kernel_digest"], "abc");
    EXPECT_EQ(read["kiln.encoder_revision"], std::to_string(kEncoderRevision));
    EXPECT_EQ(read["kiln.numerics"], "cpu-exact-1");
    EXPECT_EQ(read["kiln.key"], "def");
    EXPECT_EQ(read["kiln.color"], "linear data, no transfer function");
    EXPECT_EQ(read["kiln.standard_error_max"],
              "0.1");  // the shortest text, not 0.1000000000000000055
    EXPECT_EQ(described(job_of(kSplitSum))["kiln.fresnel"],
              "schlick (1994), F = F0 + (F90 - F0)(1 - VoH)^5");
}

TEST(Describe, NoStandardErrorIsLeftOut) {
    Provenance provenance = kProvenance;
    provenance.standard_error_max.reset();
    for (const auto& [key, value] : describe(job_of(kSplitSum), provenance))
        EXPECT_NE(key, "kiln.standard_error_max");
}

TEST(Describe, NothingOfTimeOrPlace) {
    char host[256] = {};
    ASSERT_EQ(gethostname(host, sizeof host - 1), 0);
    std::string all;
    for (const auto& [key, value] : describe(job_of(kSplitSum), kProvenance)) {
        EXPECT_EQ(key.find("date"), std::string::npos);
        EXPECT_EQ(key.find("host"), std::string::npos);
        all += value + "\n";
    }
    // A short name ("ci") may stand in some word by chance.
    const bool told = std::string(host).size() > 3 && all.find(host) != std::string::npos;
    EXPECT_FALSE(told) << host;
    EXPECT_EQ(describe(job_of(kSplitSum), kProvenance), describe(job_of(kSplitSum), kProvenance));
}

TEST(Convention, DefaultLayoutInWords) {
    const std::vector<std::string> expected = {
        "x: NoV from 0 (left) to 1, linear in NoV, texel centres: column i of 256 lies at "
        "t = (i + 0.5)/256, NoV = t; look up at u = t",
        "y: roughness from 0 (row 0, top of the image) to 1, linear in roughness, texel centres: "
        "row i of 128 lies at t = (i + 0.5)/128, roughness = t; look up at v = t",
        "R: split_sum_scale (A), multiplies F0: albedo(F0, F90) = F0 A + F90 B",
        "G: split_sum_bias (B), multiplies F90: albedo(F0, F90) = F0 A + F90 B",
        "alpha = roughness^2",
        "distribution: ggx (Walter et al. 2007)",
        "masking: height-correlated Smith (Heitz 2014)",
        "Fresnel: schlick (1994), F = F0 + (F90 - F0)(1 - VoH)^5",
        "V points away from the surface, NoV = cos(theta)",
        "values: linear data, no transfer function",
        "lookup: bilinear, clamp to edge, no mipmaps"};
    EXPECT_EQ(convention(job_of(kSplitSum)), expected);
}

TEST(Convention, MappingGridFlipAndRangeInWords) {
    const auto lines = convention(job_of(kOdd));
    ASSERT_GE(lines.size(), 5U);
    EXPECT_EQ(
        lines[0],
        "x: alpha from 0.7 (left) to 0.1, flipped, linear in the square of alpha, nodes at the "
        "texels: column i of 33 lies at t = 1 - i/(33 - 1), "
        "alpha = sqrt(0.1^2 + (0.7^2 - 0.1^2) t); look up at u = ((1 - t) (33 - 1) + 0.5)/33");
    EXPECT_EQ(
        lines[1],
        "y: NoV from 0 (row 0, top of the image) to 1, linear in the square root of NoV, texel "
        "centres: row i of 1 lies at t = 0.5, NoV = t^2; look up at v = t");
    EXPECT_EQ(lines[4], "B: 0, carries no quantity (PNG has no two-channel colour)");
}

// Slices are stacked: a row of the whole image is none of a slice.
TEST(Convention, SlicesInWords) {
    const auto lines_of = [](const std::string& z, const std::string& y) {
        return convention(job_of(
            R"({"quantities":["specular_albedo"],"resolution":[16,32,8],"layout":
               {"x":{"parameter":"NoV"},"y":{"parameter":"roughness")" +
            y + R"(},"z":{"parameter":"f0")" + z + "}}}"));
    };
    const std::string rows = "y: roughness from 0 (row 0, top of each slice) to 1, linear in ";
    const std::string slices = "z: f0 from 0 (slice 0, topmost) to 1, linear in f0, ";
    const auto centred = lines_of("", "");
    EXPECT_EQ(centred[1],
              rows +
                  "roughness, texel centres: row i of 32 in each slice lies at "
                  "t = (i + 0.5)/32, roughness = t; look up at v = (slice + t)/8 of a whole "
                  "slice");
    EXPECT_EQ(centred[2], slices +
                              "texel centres: slice i of 8 lies at t = (i + 0.5)/8, f0 = t; "
                              "slices stand one below the other; look up at slice = t 8 - 0.5 "
                              "within 0..7, mixing the slices next to it by its fraction");
    EXPECT_EQ(centred.back(),
              "lookup: bilinear in a slice, v 8 - slice held within 0.5/32..1 - 0.5/32 or the next "
              "slice bleeds in; clamp to edge, no mipmaps");
    const auto nodes = lines_of(R"(,"grid":"node","flip":true)", R"(,"grid":"node")");
    EXPECT_NE(nodes[1].find("look up at v = (slice + (t (32 - 1) + 0.5)/32)/8"), std::string::npos)
        << nodes[1];
    EXPECT_NE(nodes[2].find("look up at slice = (1 - t) (8 - 1) within 0..7"), std::string::npos)
        << nodes[2];
}

TEST(Convention, PresetsSayTheirShiftBoundsAndChannels) {
    const auto lines_of = [](const char* layout) {
        return convention(job_of(R"({"quantities": ["split_sum_bias", "directional_albedo"],
                                     "resolution": [64, 64], "layout": ")" +
                                 std::string(layout) + "\"}"));
    };
    const std::string rows =
        "y: roughness from 1 (row 0, top of the image) to 0, flipped, linear in roughness, texel "
        "centres: row i of 64 lies at t = 1 - (i + 0.5)/64 + 1/64, roughness = t";
    const std::string look_up = "; look up at v = 1 - t + 1/64";
    const auto filament = lines_of("filament"), godot = lines_of("godot");
    EXPECT_EQ(filament[1], rows + ", at most 1" + look_up);
    EXPECT_EQ(godot[1], rows + ", not bounded, so beyond 1 at that end" + look_up);
    EXPECT_EQ(filament[5],
              "layout filament reads R = split_sum_bias, G = directional_albedo "
              "(--ibl-dfg-multiscatter)");
    EXPECT_NE(godot[4].find("masking karis_ibl"), std::string::npos) << godot[4];
    const std::string cycles = lines_of("cycles")[0];
    EXPECT_NE(cycles.find("roughness = t, at least 1e-04;"), std::string::npos) << cycles;
}

bool says(const std::string& document, const std::string& words) {
    for (const std::string& line : convention(job_of(document)))
        if (line.find(words) != std::string::npos) return true;
    return false;
}

TEST(Convention, ModelsInWords) {
    const std::string depth =
        R"({"quantities":["compensated_albedo"],"resolution":[2,2,3],"multiscatter":"turquin",
            "layout":{"x":{"parameter":"NoV"},"y":{"parameter":"roughness"},
                      "z":{"parameter":"f0"}}})";
    EXPECT_TRUE(says(depth, "f0 along z, f90 1"));
    EXPECT_TRUE(says(depth, "1 + F(1) (1 - E) / E, F(1) at normal incidence"));
    EXPECT_TRUE(says(canonical(job_of(depth)), "f0 along z"));
    EXPECT_TRUE(says(R"({"quantities":["specular_albedo"],"resolution":[2,2,3],"layout":
        {"x":{"parameter":"NoV"},"y":{"parameter":"roughness"},
         "z":{"parameter":"f0","values":[0,0.0625,1]}}})",
                     "z: f0, slice by slice: 0, 0.0625, 1;"));
    const std::string copper = R"({"quantities":["specular_albedo"],"fresnel":
        {"model":"conductor","metal":"copper"}})";
    EXPECT_TRUE(says(copper, "eta 0.267 1.04698 1.29918"));
    EXPECT_TRUE(says(copper, "Johnson and Christy 1972"));
    EXPECT_FALSE(says(copper, "gamut"));
    // F at normal incidence of .131 + 4.0624 i.
    EXPECT_TRUE(says(R"({"quantities":["specular_albedo"],"fresnel":
        {"model":"conductor","metal":"gold"}})",
                     "out of gamut: red would be 1.0376 at normal incidence and is capped at "
                     "0.9705"));
    EXPECT_TRUE(says(R"({"quantities":["split_sum_scale","split_sum_bias"],"resolution":[8,8],
        "layout":"unreal"})",
                     "F0 A + saturate(50 F0.g) B"));
    EXPECT_TRUE(says(R"({"quantities":["directional_albedo"],"microfacet":{"distribution":"charlie",
        "masking":"charlie","terminator_softening":true}})",
                     "softened"));
    const std::string matte =
        R"({"quantities":["diffuse_albedo"],"diffuse":{"model":"oren_nayar"}})";
    EXPECT_TRUE(says(matte, "sigma in radians"));
    EXPECT_FALSE(says(matte, "masking"));
}

TEST(Describe, QuadratureNamesNoSamples) {
    auto read = described(job_of(R"({"quantities":["split_sum_bias"],"integrator":"quadrature"})"));
    EXPECT_EQ(read["kiln.integrator"], "quadrature");
    EXPECT_EQ(read.count("kiln.sample_count") + read.count("kiln.sampler"), 0u);
}

TEST(Convention, OneAxisAndFiveChannels) {
    const JobSpec averages = job_of(
        R"({"quantities": ["average_albedo"], "resolution": [64],
            "layout": {"x": {"parameter": "roughness"}}})");
    EXPECT_EQ(convention(averages).front().substr(0, 12), "x: roughness");
    EXPECT_EQ(convention(averages)[1].substr(0, 18), "R: average_albedo,");
    const JobSpec all = job_of(
        R"({"quantities": ["split_sum_scale", "split_sum_bias", "directional_albedo",
                           "average_albedo", "multiscatter_albedo"], "resolution": [8, 8]})");
    EXPECT_EQ(convention(all)[2].substr(0, 19), "split_sum_scale (A)");
}

}  // namespace
