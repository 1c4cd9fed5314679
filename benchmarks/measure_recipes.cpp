// SPDX-License-Identifier: Apache-2.0
// measure_recipes PICTURE.png [CMGEN.dds]: the true error of the recipes in examples/ on a 256²
// split sum and on 256 values of E_avg, against quadrature, as rows of Markdown tables; and a
// picture of where the error lies (A, common recipe on the left, recommended one on the right;
// black 1e-6, white 1e-1, logarithmic). The second file is what `cmgen --ibl-dfg=CMGEN.dds -s 256`
// wrote; its rows lie one texel high, and it is measured on those.
#include <Imath/half.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/compute/axes.h"
#include "server/compute/engine.h"
#include "server/image/image.h"
#include "server/spec/spec.h"
#include "tests/reference/reference.h"

namespace {

using namespace kiln;

constexpr std::size_t kSide = 256;

struct Recipe {
    const char* name;
    const char* settings;
};

constexpr Recipe kAverageRecipes[] = {
    {"common: Hammersley, GGX half vectors, 1024",
     R"("sampler":"hammersley","importance":"ndf","sample_count":1024)"},
    {"recommended: scrambled Sobol, visible normals, 1024",
     R"("sampler":"sobol_owen","importance":"vndf","sample_count":1024)"},
    {"the same, 4096", R"("sampler":"sobol_owen","importance":"vndf","sample_count":4096)"},
};

constexpr Recipe kRecipes[] = {
    {"common: Hammersley, GGX half vectors, 1024",
     R"("sampler":"hammersley","importance":"ndf","sample_count":1024)"},
    {"recommended: scrambled Sobol, visible normals, 1024",
     R"("sampler":"sobol_owen","importance":"vndf","sample_count":1024)"},
    {"the same, 4096", R"("sampler":"sobol_owen","importance":"vndf","sample_count":4096)"},
    {"the same, 65536", R"("sampler":"sobol_owen","importance":"vndf","sample_count":65536)"},
};

JobSpec job_of(const Recipe& recipe) {
    return parse_job(
        std::string(R"({"quantities":["split_sum_scale","split_sum_bias"],"resolution":[256,256],)"
                    R"("device":"native",)") +
        recipe.settings + "}");
}

/// Row i of cmgen's table, from the bottom of its image, stands for roughness min((i + 3/2) / n,
/// 1).
std::vector<double> exact(reference::Quantity quantity, double row_offset = 0.5) {
    std::vector<double> NoV, alpha;
    for (std::size_t i = 0; i < kSide; ++i) {
        const auto at = static_cast<double>(i);
        NoV.push_back((at + 0.5) / kSide);
        alpha.push_back(alpha_from_roughness(std::min(1.0, (at + row_offset) / kSide)));
    }
    return reference::table(quantity, reference::Masking::correlated, NoV, alpha, 2);
}

struct Distance {
    double rms = 0, max = 0;
};

Distance measure(const std::vector<float>& plane, const std::vector<double>& truth) {
    Distance error;
    for (std::size_t i = 0; i < plane.size(); ++i) {
        const double off = std::abs(static_cast<double>(plane[i]) - truth[i]);
        error.rms += off * off / static_cast<double>(plane.size());
        error.max = std::max(error.max, off);
    }
    error.rms = std::sqrt(error.rms);
    return error;
}

/// Planes A and B of cmgen's RGBA half DDS (148 bytes of header), bottom row of the image first.
std::vector<std::vector<float>> read_cmgen(const char* path) {
    constexpr std::size_t kHeader = 148, kTexel = 4;
    std::ifstream file(path, std::ios::binary);
    std::vector<half> values(kSide * kSide * kTexel);
    file.seekg(kHeader);
    file.read(reinterpret_cast<char*>(values.data()),
              static_cast<std::streamsize>(values.size() * sizeof(half)));
    if (!file)
        throw kiln::Error("cannot_decode", std::string(path) + " is no 256 x 256 RGBA half DDS");
    std::vector<std::vector<float>> planes(2, std::vector<float>(kSide * kSide));
    for (std::size_t i = 0; i < kSide * kSide; ++i)
        for (std::size_t c = 0; c < 2; ++c)
            planes[c][(kSide - 1 - i / kSide) * kSide + i % kSide] = values[kTexel * i + c];
    return planes;
}

void print_row(const char* name, const Distance& a, const Distance& b, const std::string& rest) {
    std::printf("| %s | %.1e | %.1e | %.1e | %.1e | %s |\n", name, a.rms, a.max, b.rms, b.max,
                rest.c_str());
}

void draw(Table& picture, std::size_t column, const std::vector<float>& plane,
          const std::vector<double>& truth) {
    for (std::size_t i = 0; i < plane.size(); ++i) {
        const double off = std::abs(static_cast<double>(plane[i]) - truth[i]);
        const double shade = (std::log10(std::max(off, 1e-12)) + 6) / 5;
        picture.planes[0][i / kSide * picture.width + column * kSide + i % kSide] =
            static_cast<float>(std::clamp(shade, 0.0, 1.0));
    }
}

/// E_avg at 256 roughnesses.
void measure_averages(Engine& engine) {
    std::vector<double> truth;
    for (std::size_t i = 0; i < kSide; ++i) {
        const double roughness = (static_cast<double>(i) + 0.5) / kSide;
        truth.push_back(reference::average_albedo(alpha_from_roughness(roughness),
                                                  reference::Masking::correlated));
    }
    std::puts("\n| recipe, samples a texel | E_avg rms | E_avg max | reported rms |");
    std::puts("|---|---|---|---|");
    for (const Recipe& recipe : kAverageRecipes) {
        const Outcome outcome = engine.run(
            parse_job(std::string(R"({"quantities":["average_albedo"],"resolution":[256],)"
                                  R"("device":"native",)") +
                      recipe.settings + "}"),
            Control{});
        const Distance error = measure(outcome.table.planes[0], truth);
        std::printf("| %s | %.1e | %.1e | %.1e |\n", recipe.name, error.rms, error.max,
                    outcome.report.error[0].standard_error_rms.value_or(0));
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2 || argc > 3) {
        std::fprintf(stderr, "usage: measure_recipes PICTURE.png [CMGEN.dds]\n");
        return 2;
    }
    const std::vector<double> A = exact(reference::Quantity::scale),
                              B = exact(reference::Quantity::bias);
    Table picture{2 * kSide, kSide, {"log10_error"}, {std::vector<float>(2 * kSide * kSide)}};
    EngineOptions options;
    options.device = DeviceChoice::native;
    Engine engine(options);
    std::puts(
        "| recipe, samples a texel | A rms | A max | B rms | B max | reported rms of A | "
        "integration |");
    std::puts("|---|---|---|---|---|---|---|");
    double first_s = 0;
    for (std::size_t r = 0; r < std::size(kRecipes); ++r) {
        const Outcome outcome = engine.run(job_of(kRecipes[r]), Control{});
        const Distance a = measure(outcome.table.planes[0], A),
                       b = measure(outcome.table.planes[1], B);
        const double seconds = outcome.report.run_time_s.integrate;
        if (r == 0) first_s = seconds;
        std::array<char, 64> rest{};
        std::snprintf(rest.data(), rest.size(), "%.1e | %.1f x",
                      outcome.report.error[0].standard_error_rms.value_or(0), seconds / first_s);
        print_row(kRecipes[r].name, a, b, rest.data());
        if (r < 2) draw(picture, r, outcome.table.planes[0], A);
    }
    if (argc == 3) {
        const auto planes = read_cmgen(argv[2]);
        print_row("cmgen: 1024 Hammersley points, not randomised",
                  measure(planes[0], exact(reference::Quantity::scale, 1.5)),
                  measure(planes[1], exact(reference::Quantity::bias, 1.5)), "- | -");
    }
    measure_averages(engine);
    const Encoded png = encode(picture, ImageFormat::png, PixelType::uint8, {});
    std::ofstream(argv[1], std::ios::binary) << png.bytes;
    return 0;
}
