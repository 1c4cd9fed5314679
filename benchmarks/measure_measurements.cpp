// SPDX-License-Identifier: Apache-2.0
// measure_measurements [FILE...]: what each step from a measured file to an image costs, as rows of
// Markdown: the work of all cores together (the least of some runs, which others on the machine
// hardly move) and peak memory beyond that before the step, for the files and for synthetic ones of
// growing size. Each file in a process of its own.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/base/sha256.h"
#include "server/image/image.h"
#include "server/measured/atlas.h"
#include "server/measured/survey.h"
#include "tests/measured/synthetic.h"

namespace {

using namespace kiln;
using namespace kiln::measured;

constexpr int kRuns = 3;

/// Of /proc/self/status, in MiB.
double status_mib(const std::string& field) {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with(field)) return std::stod(line.substr(field.size() + 1)) / 1024;
    return 0;
}

void reset_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

struct Cost {
    double seconds = 1e9, mib = 0;
};

template <class Step>
void measure(Cost& cost, const Step& step) {
    const double before = status_mib("VmRSS:");
    reset_peak();
    const std::clock_t start = std::clock();
    step();
    cost.seconds =
        std::min(cost.seconds, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    cost.mib = std::max(cost.mib, status_mib("VmHWM:") - before);
}

void print_row(const std::string& name, const std::string& bytes) {
    Cost hash, read, survey_cost, cloud, slices, half, packed;
    std::size_t points = 0;
    const SliceLayout layout;
    for (int run = 0; run < kRuns; ++run) {
        std::optional<Reading> reading;
        std::optional<Material> material;
        std::optional<Atlas> atlas;
        measure(hash, [&] { sha256_hex(bytes); });
        measure(read, [&] { reading = read_measurement(bytes); });
        points = reading->components.front().cloud.size();
        measure(survey_cost, [&] {
            for (const Component& part : reading->components) survey(part);
        });
        measure(cloud, [&] {
            material.emplace(reading->components.front(), Extrapolation{}, reading->understood);
        });
        atlas.emplace(layout, 1);
        measure(slices, [&] { atlas->add(*material, [](double) {}); });
        const Table& table = atlas->made().table;
        measure(half, [&] { encode(table, ImageFormat::exr, PixelType::half, {}); });
        measure(packed, [&] { encode(table, ImageFormat::exr, PixelType::rgb9e5, {}); });
    }
    std::printf("| %s | %.2f | %zu |", name.c_str(), static_cast<double>(bytes.size()) / 1e6,
                points);
    for (const Cost& cost : {hash, read, survey_cost, cloud, slices, half, packed})
        std::printf(" %.0f ms, %.0f |", 1e3 * cost.seconds, std::max(0.0, cost.mib));
    std::printf("\n");
    std::fflush(stdout);
}

void in_a_process(const std::string& name, const std::string& bytes) {
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        try {
            print_row(name, bytes);
        } catch (const Error& error) {
            std::printf("| %s | %.2f | %s |\n", name.c_str(),
                        static_cast<double>(bytes.size()) / 1e6, error.what());
            std::fflush(stdout);
        }
        _exit(0);
    }
    waitpid(child, nullptr, 0);
}

void synthetic_rows() {
    const synthetic::Material satin = synthetic::ggx(0.35, {0.6, 0.5, 0.4}, {0.2, 0.2, 0.2});
    for (const double step : {5.0, 2.0, 1.0}) {
        synthetic::MiniDiffGrid grid;
        grid.azimuth_step = grid.radial_step = step;
        char name[64];
        std::snprintf(name, sizeof name, "MiniDiff layout, %g degrees", step);
        in_a_process(name, synthetic::minidiff_file(satin, grid));
    }
    in_a_process("MERL, 180 azimuths", synthetic::merl_file(satin));
    in_a_process("MERL, 360 azimuths", synthetic::merl_file(satin, 360));
}

}  // namespace

int main(int count, char** values) {
    std::printf(
        "| file | MB | points | SHA-256 | read | survey | cloud | slices 13 x 361 x 181 | half EXR "
        "| "
        "rgb9e5 EXR |\n|---|---|---|---|---|---|---|---|---|---|\n");
    for (int i = 1; i < count; ++i) {
        std::ifstream file(values[i], std::ios::binary);
        const std::string path = values[i];
        in_a_process(path.substr(path.rfind('/') + 1), {std::istreambuf_iterator<char>(file), {}});
    }
    synthetic_rows();
    return 0;
}
