// SPDX-License-Identifier: Apache-2.0
// Tables that other programs write or publish, each under the preset of that program. Their own
// error is known from quadrature; the wrong axes are worse than it.
#include <ImathBox.h>
#include <ImfRgbaFile.h>
#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "server/spec/spec.h"
#include "tests/compute/against_reference.h"

namespace kiln {
namespace {

using namespace against_reference;

struct Distance {
    double rms = 0, max = 0;
};

Distance distance(const std::vector<float>& ours, const Values& theirs) {
    EXPECT_EQ(ours.size(), theirs.size());
    Distance d;
    for (std::size_t i = 0; i < std::min(ours.size(), theirs.size()); ++i) {
        const double off = std::abs(ours[i] - theirs[i]);
        d.max = std::max(d.max, off);
        d.rms += off * off / static_cast<double>(theirs.size());
    }
    d.rms = std::sqrt(d.rms);
    return d;
}

Outcome outcome_of(const std::string& layout, const std::string& quantities,
                   const std::string& resolution, std::int64_t sample_count) {
    return bake(parse_job(R"({"device":"native","layout":)" + layout + R"(,"quantities":)" +
                          quantities + R"(,"resolution":)" + resolution + R"(,"sample_count":)" +
                          std::to_string(sample_count) + "}"));
}

Table bake_of(const std::string& layout, const std::string& quantities,
              const std::string& resolution, std::int64_t sample_count) {
    return outcome_of(layout, quantities, resolution, sample_count).table;
}

/// A folder that is gone with this object.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string name = KILN_BINARY_DIR "/published-XXXXXX";
        if (!mkdtemp(name.data())) throw std::runtime_error("mkdtemp");
        path_ = name;
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// The first two channels of what cmgen writes for 64 x 64, top row first. Its file is compressed
/// by PIZ, which Kiln's own reader leaves to the library.
std::array<Values, 2> run_cmgen(const std::string& options) {
    const TemporaryFolder folder;
    const std::string file = folder.path() / "dfg.exr";
    const std::string command = "cmgen --quiet " + options + " --ibl-dfg='" + file + "' -s 64";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    Imf::RgbaInputFile in(file.c_str());
    const std::size_t count = 64 * 64;
    EXPECT_EQ(in.dataWindow(), Imath::Box2i({0, 0}, {63, 63}));
    std::vector<Imf::Rgba> texels(count);
    in.setFrameBuffer(texels.data(), 1, 64);
    in.readPixels(0, 63);
    std::array<Values, 2> planes;
    for (const Imf::Rgba& texel : texels) {
        planes[0].push_back(texel.r);
        planes[1].push_back(texel.g);
    }
    return planes;
}

// cmgen draws 1024 Hammersley points from D once for all texels: by quadrature its table is off by
// up to 1.26e-2, rms 2.7e-3 in A and E, and up to 8e-3 in B. Ours is off by 1e-3 at most.
TEST(Published, CmgenIsReproducedByItsPresetAlone) {
    if (std::system("command -v cmgen >/dev/null 2>&1") != 0)
        GTEST_SKIP() << "cmgen is not installed (package libfilament-tools)";
    struct Case {
        const char *options, *quantities;
    };
    for (const Case& c :
         {Case{"", R"(["split_sum_scale","split_sum_bias"])"},
          Case{"--ibl-dfg-multiscatter", R"(["split_sum_bias","directional_albedo"])"}}) {
        SCOPED_TRACE(c.quantities);
        const std::array<Values, 2> theirs = run_cmgen(c.options);
        const Table ours = bake_of(R"("filament")", c.quantities, "[64,64]", 16384);
        const Table plain =
            bake_of(R"({"x":{"parameter":"NoV"},"y":{"parameter":"roughness","flip":true}})",
                    c.quantities, "[64,64]", 16384);
        double plain_max = 0;
        for (std::size_t channel = 0; channel < 2; ++channel) {
            const Distance d = distance(ours.planes[channel], theirs[channel]);
            EXPECT_LE(d.max, 1.4e-2) << channel;
            EXPECT_LE(d.rms, 3.5e-3) << channel;
            plain_max = std::max(plain_max, distance(plain.planes[channel], theirs[channel]).max);
        }
        EXPECT_GE(plain_max, 3e-2);
    }
}

/// Empty where there is none.
std::filesystem::path published_folder() {
    const char* given = std::getenv("KILN_PUBLISHED_TABLES");
    const std::filesystem::path folder = given ? given : KILN_SOURCE_DIR "/../shared/data/luts";
    return std::filesystem::exists(folder) ? folder : "";
}

Values numbers_in(const std::filesystem::path& file) {
    std::ifstream in(file);
    EXPECT_TRUE(in.good()) << file;
    Values values;
    for (std::string word; in >> word;) {
        std::istringstream line(word);
        for (std::string number; std::getline(line, number, ',');)
            values.push_back(std::stod(number));
    }
    return values;
}

constexpr const char* kNoFolder =
    "no folder of published tables; KILN_PUBLISHED_TABLES may name one";

// By quadrature three.js' A is off by up to 1.4e-2 (in the first row), on average 8e-4, its B by up
// to 6.7e-4.
TEST(Published, ThreeJsIsReproducedByItsPresetAlone) {
    const std::filesystem::path folder = published_folder();
    if (folder.empty()) GTEST_SKIP() << kNoFolder;
    const char* quantities = R"(["split_sum_scale","split_sum_bias"])";
    const Table ours = bake_of(R"("threejs")", quantities, "[16,16]", 65536);
    const Table plain = bake_of(R"("kiln")", quantities, "[16,16]", 65536);
    const Values A = numbers_in(folder / "threejs/dfg_A_16x16.csv");
    const Values B = numbers_in(folder / "threejs/dfg_B_16x16.csv");
    EXPECT_LE(distance(ours.planes[0], A).max, 1.5e-2);
    EXPECT_LE(distance(ours.planes[0], A).rms, 2.5e-3);
    EXPECT_LE(distance(ours.planes[1], B).max, 1e-3);
    EXPECT_GE(distance(plain.planes[0], A).max, .3);
    EXPECT_GE(distance(plain.planes[1], B).max, .2);
}

// Cycles' averages are good to 6e-7 and rounded to six digits (5e-7); ours to five of their
// standard errors and float's rounding. 2^20 scrambled points leave 2e-5 at most, where a
// half-texel shift costs more than 5e-3.
TEST(Published, CyclesAveragesAreReproduced) {
    const std::filesystem::path folder = published_folder();
    if (folder.empty()) GTEST_SKIP() << kNoFolder;
    const Values theirs = numbers_in(folder / "blender-cycles/table_ggx_Eavg.csv");
    const Outcome ours = outcome_of(R"("cycles")", R"(["average_albedo"])", "[32]", 1 << 20);
    ASSERT_EQ(theirs.size(), 32U);
    for (std::size_t i = 0; i < theirs.size(); ++i)
        EXPECT_NEAR(ours.table.planes[0][i], theirs[i],
                    5 * ours.standard_errors[0][i] + kRounding + 1.1e-6)
            << i;
    EXPECT_LE(distance(ours.table.planes[0], theirs).max, 2.5e-5);
    const Table plain = bake_of(R"("kiln")", R"(["average_albedo"])", "[32]", 1 << 16);
    EXPECT_GE(distance(plain.planes[0], theirs).max, 5e-3);
    // By quadrature, to 1e-6, nothing is left but what they round.
    EngineOptions options;
    options.device = DeviceChoice::native;
    const JobSpec job =
        parse_job(R"({"device":"native","layout":"cycles","quantities":)"
                  R"(["average_albedo"],"resolution":[32],"integrator":)"
                  R"("quadrature","target_error":1e-6,"output":{"pixel":"float"}})");
    const Table exact = Engine(options).run(job, Control{}).table;
    EXPECT_LE(distance(exact.planes[0], theirs).max, 1.1e-6 + 1e-6);
}

/// Plane `channel` of an RGBD image as Babylon.js reads it: (c / 255)^2.2 / (a / 255), top row
/// first.
Values rgbd_plane(const std::filesystem::path& file, std::size_t channel) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_file(&image, file.c_str()), 0) << file;
    image.format = PNG_FORMAT_RGBA;
    std::vector<png_byte> bytes(PNG_IMAGE_SIZE(image));
    EXPECT_NE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr), 0) << file;
    Values values;
    for (std::size_t i = 0; i < bytes.size(); i += 4)
        values.push_back(std::pow(bytes[i + channel] / 255., 2.2) / (bytes[i + 3] / 255.));
    return values;
}

const char* kGgx = R"({"distribution":"ggx"})";
const char* kTexelLower =
    R"({"x":{"parameter":"NoV"},"y":{"parameter":"roughness","range":[0.00390625,1]}})";
const char* kRoughnessNodes = R"({"x":{"parameter":"roughness","grid":"node"}})";

struct PublishedTable {
    const char *file, *layout, *quantities, *resolution, *lobe;
    double max, mean;       ///< what the publisher's own points leave, by quadrature
    int rgbd_channel = -1;  ///< of an image; else the file holds one quantity's numbers
};

/// Largest and mean difference from the first channel of a job, relative above 1, within the
/// figures of the table and five of our standard errors, and not closer than they are to the truth.
void hold(const PublishedTable& table, const Values& theirs, const Outcome& ours) {
    // Of an image that lies a texel too low the last row is of no roughness.
    const std::size_t texels = ours.table.planes[0].size();
    ASSERT_EQ(theirs.size(), texels + (table.layout == kTexelLower ? 256 : 0));
    double max = 0, mean = 0, own_max = 0, own_mean = 0;
    const auto count = static_cast<double>(texels);
    for (std::size_t i = 0; i < texels; ++i) {
        const double size = std::max(1.0, theirs[i]);
        const double off = std::abs(ours.table.planes[0][i] - theirs[i]) / size;
        const double own = ours.standard_errors[0][i] / size;
        max = std::max(max, off);
        mean += off / count;
        own_max = std::max(own_max, own);
        own_mean += own / count;
    }
    // Their figures are rounded to two digits; ours carries its own error.
    EXPECT_LE(max, 1.05 * table.max + 5 * own_max);
    EXPECT_LE(mean, 1.05 * table.mean + own_mean);
    EXPECT_GE(max, 0.5 * table.max) << "closer than they are to the truth";
}

// Each good to what its own points leave by quadrature. Where the mean is that small a shift by
// half a texel would show (5e-3). Cloth is half precision of 4096 points, of a lobe that reaches
// 9.2 in the corner; RGBD has 8 bits a channel. Babylon's file lies a texel too low, its row i at
// roughness (i + 1.5) / 256: read at (i + .5) / 256, as the shader does, the sheen of its first
// rows is off by up to 100 %, E by 3.1e-2. Its openPBR file does not, and its third channel is no
// lobe of Charlie's.
const PublishedTable kTables[] = {
    {"dassault-enterprise-pbr/GGX_E.csv", R"("kiln")", R"(["directional_albedo"])", "[32,32]", kGgx,
     3.6e-2, 7.7e-4},
    {"dassault-enterprise-pbr/GGX_E_avg.csv", R"({"x":{"parameter":"roughness"}})",
     R"(["average_albedo"])", "[32]", kGgx, 4.8e-4, 4.8e-4},
    {"appleseed/glossy_ggx_Eavg_32.csv", kRoughnessNodes, R"(["average_albedo"])", "[32]", kGgx,
     2.6e-3, 1.2e-3},
    {"filament-cmgen-1.9.25/dfg_split_64_R_A.csv", R"("filament")", R"(["split_sum_scale"])",
     "[64,64]", kGgx, 1.3e-2, 1.5e-3},
    {"filament-cmgen-1.9.25/dfg_split_64_G_B.csv", R"("filament")", R"(["split_sum_bias"])",
     "[64,64]", kGgx, 4.2e-3, 1e-3},
    {"filament-cmgen-1.9.25/dfg_multiscatter_32_R_B.csv", R"("filament")", R"(["split_sum_bias"])",
     "[32,32]", kGgx, 2.7e-3, 1e-3},
    {"filament-cmgen-1.9.25/dfg_multiscatter_32_G_total.csv", R"("filament")",
     R"(["directional_albedo"])", "[32,32]", kGgx, 1.3e-2, 1.5e-3},
    {"filament-cmgen-1.9.25/dfg_multiscatter_cloth_64_R_B.csv", R"("filament")",
     R"(["split_sum_bias"])", "[64,64]", kGgx, 4.2e-3, 1e-3},
    {"filament-cmgen-1.9.25/dfg_multiscatter_cloth_64_G_total.csv", R"("filament")",
     R"(["directional_albedo"])", "[64,64]", kGgx, 1.3e-2, 1.5e-3},
    {"filament-cmgen-1.9.25/dfg_multiscatter_cloth_64_B_cloth.csv", R"("filament")",
     R"(["sheen_albedo"])", "[64,64]", kGgx, 1.1e-2, 7.6e-5},
    {"babylonjs/environmentBRDF_rgbd.png", kTexelLower, R"(["split_sum_bias"])", "[256,255]", kGgx,
     1.9e-2, 3.7e-4, 0},
    {"babylonjs/environmentBRDF_rgbd.png", kTexelLower, R"(["directional_albedo"])", "[256,255]",
     kGgx, 1.8e-2, 1.8e-3, 1},
    {"babylonjs/environmentBRDF_rgbd.png", kTexelLower, R"(["sheen_albedo"])", "[256,255]", kGgx,
     2e-2, 9.4e-4, 2},
    {"babylonjs/openPBR_environmentBRDF_rgbd.png", R"("babylon")", R"(["directional_albedo"])",
     "[128,128]", kGgx, 1.4e-2, 4.6e-3, 1},
    {"babylonjs/openPBR_environmentBRDF_rgbd.png", R"("babylon")", R"(["split_sum_bias"])",
     "[128,128]", kGgx, 1.3e-2, 2.6e-3, 0},
};

TEST(Published, OtherTablesAreMetWithinTheirOwnError) {
    const std::filesystem::path folder = published_folder();
    if (folder.empty()) GTEST_SKIP() << kNoFolder;
    for (const PublishedTable& table : kTables) {
        SCOPED_TRACE(std::string(table.file) + ' ' + table.quantities + ' ' + table.lobe);
        const Values theirs =
            table.rgbd_channel < 0
                ? numbers_in(folder / table.file)
                : rgbd_plane(folder / table.file, static_cast<std::size_t>(table.rgbd_channel));
        hold(table, theirs,
             bake(parse_job(std::string(R"({"device":"native","sample_count":16384,"layout":)") +
                            table.layout + R"(,"quantities":)" + table.quantities +
                            R"(,"resolution":)" + table.resolution + R"(,"microfacet":)" +
                            table.lobe + "}")));
    }
}

/// Rows t and t + 1 of the grid of ltc_code, NoV = 1 - (t / 63)^2 with angles up to 1.57, which is
/// no mapping of an axis: as two nodes between them, the lower NoV first. x = roughness.
Outcome ltc_rows(Quantity quantity, int t) {
    const auto NoV = [](int row) {
        const double x = row / 63.;
        return std::max(1 - x * x, std::cos(1.57));
    };
    JobSpec job = square_job({quantity}, 64, 16384);
    job.resolution[1] = 2;
    job.axes = {axis(Parameter::roughness, Grid::node), axis(Parameter::NoV, Grid::node)};
    job.axes[1].lo = NoV(t + 1);
    job.axes[1].hi = NoV(t);
    return bake(job);
}

// Heitz' and Hill's albedos beside their fits, of 32 x 32 regular points each: off by 6.6e-2 in the
// last row of E, 3.7e-3 on average, and 2.8e-2 and 8e-5 in B. The matrices of the fits themselves,
// the sheen of Cycles (a transformed cosine for a layer of volume) and its thin films (a spectral
// table) are no albedos: Kiln has no quantity for them.
TEST(Published, RegularPointsOfLtcCodeAreMetWithinTheirOwnError) {
    const std::filesystem::path folder = published_folder();
    if (folder.empty()) GTEST_SKIP() << kNoFolder;
    struct Case {
        const char* file;
        Quantity quantity;
        double max, mean;
    };
    for (const Case& c :
         {Case{"ltc_code/ltc2_x_E_albedo_64x64.csv", Quantity::directional_albedo, 6.6e-2, 3.7e-3},
          Case{"ltc_code/ltc2_y_B_fresnel_64x64.csv", Quantity::split_sum_bias, 2.8e-2, 8e-5}}) {
        SCOPED_TRACE(c.file);
        const Values theirs = numbers_in(folder / c.file);
        ASSERT_EQ(theirs.size(), 64U * 64);
        Outcome all;
        all.table.planes.resize(1);
        all.standard_errors.resize(1);
        const auto append = [](const auto& from, auto& to, std::size_t row) {
            to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(64 * row),
                      from.begin() + static_cast<std::ptrdiff_t>(64 * row + 64));
        };
        for (int t = 0; t < 64; t += 2) {
            const Outcome rows = ltc_rows(c.quantity, t);
            for (const std::size_t row : {1U, 0U}) {
                append(rows.table.planes[0], all.table.planes[0], row);
                append(rows.standard_errors[0], all.standard_errors[0], row);
            }
        }
        hold({c.file, "", "", "", "", c.max, c.mean}, theirs, all);
    }
}

// The three channels of Kulla-Conty image-based lighting, as brdf.xyz = (scale, bias, fms) of its
// usual shader: Karis' G with k = r^2 / 2. E and B at (NoV, roughness) to the six digits that two
// independent integrators agreed on; scale is E - B, and fms, the integral of f_ms NoL, 1 - E.
TEST(Published, ScaleBiasFmsOfTheExampleJob) {
    struct Anchor {
        double NoV, roughness, E, B;
    };
    constexpr Anchor kAnchors[] = {{.1, .25, .682358, .291091},
                                   {.25, .5, .670296, .060884},
                                   {.5, .75, .579982, .006970},
                                   {.5, 1, .409137, .002456},
                                   {1, 1, .306853, .000034}};
    std::ifstream file(KILN_SOURCE_DIR "/examples/scale_bias_fms.json");
    std::stringstream text;
    text << file.rdbuf();
    JobSpec job = parse_job(text.str());
    EXPECT_EQ(job.axes[0].parameter, Parameter::NoV);
    EXPECT_EQ(job.axes[1].parameter, Parameter::roughness);
    ASSERT_EQ(channels_of(job).size(), 3U);
    job.resolution = {2, 2};
    job.sample_count = 1 << 18;
    job.device = DeviceChoice::native;
    for (Axis& axis : job.axes) axis.grid = Grid::node;
    for (const Anchor& anchor : kAnchors) {
        // The anchor is the texel at (0, 0), or the last one where it lies at an end.
        const auto around = [](Axis& axis, double value) {
            axis.lo = value < 1 ? value : .5;
            axis.hi = 1;
            return value < 1 ? 0U : 1U;
        };
        const unsigned x = around(job.axes[0], anchor.NoV);
        const unsigned y = around(job.axes[1], anchor.roughness);
        const Outcome outcome = bake(job);
        const double truth[] = {anchor.E - anchor.B, anchor.B, 1 - anchor.E};
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(outcome.table.planes[c][2 * y + x], truth[c],
                        5 * outcome.standard_errors[c][2 * y + x] + kRounding + 1e-6)
                << outcome.table.channels[c] << " at " << anchor.NoV << ", " << anchor.roughness;
        for (const auto& errors : outcome.standard_errors) EXPECT_LT(errors[2 * y + x], 3e-5);
    }
}

}  // namespace
}  // namespace kiln
