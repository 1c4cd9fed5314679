// SPDX-License-Identifier: Apache-2.0
#include "client/cmgen.h"

#include <fcntl.h>
#include <half.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "client/failure.h"
#include "client/files.h"
#include "server/compute/engine.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

extern char** environ;

namespace kiln::client {

namespace {

constexpr int kRuns = 3;
constexpr std::size_t kTextBytesMax = 256u << 20;

bool is_its_table(const JobSpec& job) {
    return job.quantities == std::vector{Quantity::split_sum_scale, Quantity::split_sum_bias} &&
           job.resolution.size() == 2 && job.resolution[0] == job.resolution[1] &&
           std::has_single_bit(static_cast<std::uint64_t>(job.resolution[0])) &&
           job.distribution == Distribution::ggx && job.masking == Masking::smith_correlated;
}

class Folder {
  public:
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "kiln-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr)
            throw Failure(Exit::failed, "cannot_write", "cannot make a temporary folder");
        path_ = name;
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    const std::string& path() const { return path_; }

  private:
    std::string path_;
};

struct Run {
    bool found = false, done = false;
    double seconds = 0;  ///< wall time of the whole process
};

Run run_cmgen(const std::string& file, const std::string& size) {
    std::array<std::string, 5> words{"cmgen", "--quiet", "--ibl-dfg=" + file, "-s", size};
    std::array<char*, 6> arguments{};
    std::transform(words.begin(), words.end(), arguments.begin(),
                   [](std::string& word) { return word.data(); });
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        ::posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_RDWR, 0);
    const auto start = std::chrono::steady_clock::now();
    pid_t child = 0;
    const int refused =
        ::posix_spawnp(&child, words[0].c_str(), &actions, nullptr, arguments.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    if (refused != 0) return {};
    int status = 0;
    if (::waitpid(child, &status, 0) != child || status != 0) return {true, false};
    return {true, true,
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()};
}

/// A then B of every texel, from the half floats that it writes as C text, lowest roughness first.
std::vector<double> values_in(const std::string& text) {
    std::vector<double> values;
    for (auto at = text.find("0x"); at != text.npos; at = text.find("0x", at + 1)) {
        half value;
        value.setBits(static_cast<std::uint16_t>(std::strtoul(text.c_str() + at, nullptr, 16)));
        values.push_back(static_cast<double>(static_cast<float>(value)));
    }
    return values;
}

/// What should stand in its file: quadrature in double at Filament's texels, rows from the top.
Table exact_table(const JobSpec& job) {
    JobSpec exact = parse_job(R"({"quantities":["split_sum_scale","split_sum_bias"],)"
                              R"("layout":"filament","integrator":"quadrature",)"
                              R"("precision":"float64","resolution":[)" +
                              std::to_string(job.resolution[0]) + "," +
                              std::to_string(job.resolution[1]) + "]}");
    Engine engine({.device = DeviceChoice::native,
                   .opencl_wait = std::chrono::milliseconds(0),
                   .opencl_disabled_reason = "",
                   .thread_count = 0});
    return engine.run(exact, Control{}).table;
}

struct Distance {
    double rms = 0, max = 0;
};

Distance distance(const Table& exact, const std::vector<double>& values) {
    double sum = 0, most = 0;
    for (std::size_t y = 0; y < exact.height; ++y)
        for (std::size_t i = 0; i < 2 * exact.width; ++i) {
            const std::size_t row = exact.height - 1 - y;
            const double off = std::abs(values[2 * exact.width * y + i] -
                                        exact.planes[i % 2][row * exact.width + i / 2]);
            sum += off * off;
            most = std::max(most, off);
        }
    return {std::sqrt(sum / static_cast<double>(values.size())), most};
}

/// `seconds` ascend.
void add_line(const std::vector<double>& seconds, const Distance& off, Study& study) {
    const double median = seconds[seconds.size() / 2];
    std::size_t charts = 0;
    for (Chart& chart : study.charts) {  // the first two are over run time
        auto* lines = std::get_if<LineChart>(&chart);
        if (lines == nullptr || ++charts > 2) continue;
        lines->series.push_back({"cmgen, whole process, 1024 samples",
                                 {median},
                                 {charts == 1 ? off.rms : off.max},
                                 {seconds.front()},
                                 {seconds.back()}});
    }
    study.table.rows.push_back({std::string("cmgen"),
                                std::string("hammersley"),
                                std::string("ndf"),
                                1024.0,
                                median,
                                seconds.front(),
                                seconds.back(),
                                off.rms,
                                off.max,
                                {}});
}

/// What to say of it.
std::string measure_cmgen(const JobSpec& job, Study& study) {
    const Folder folder;
    const std::string file = folder.path() + "/dfg.txt";
    std::vector<double> seconds;
    for (int i = 0; i < kRuns; ++i) {
        const Run run = run_cmgen(file, std::to_string(job.resolution[0]));
        if (!run.found)
            return "Filament's cmgen was not found, so its line is left out: Debian's package is "
                   "libfilament-tools.";
        if (!run.done || !std::filesystem::exists(file))
            return "cmgen failed, so its line is left out.";
        seconds.push_back(run.seconds);
    }
    std::sort(seconds.begin(), seconds.end());
    const std::vector<double> values = values_in(read_input(file, kTextBytesMax));
    const Table exact = exact_table(job);
    if (values.size() != 2 * exact.width * exact.height)
        return "cmgen wrote a table of another size, so its line is left out.";
    add_line(seconds, distance(exact, values), study);
    return "cmgen: its own file of the same size against exact values at its own texels, timed on "
           "this machine from start to end.";
}

}  // namespace

bool add_cmgen(const JobSpec& job, Study& study) {
    if (!is_its_table(job)) return false;
    study.notes.push_back(measure_cmgen(job, study));
    return true;
}

}  // namespace kiln::client
