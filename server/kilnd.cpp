// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <malloc.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/base/version.h"
#include "server/compute/kernel_digest.h"
#include "server/compute/opencl_threads.h"
#include "server/http/bounds.h"
#include "server/http/child_process.h"
#include "server/http/serve.h"
#include "server/image/image.h"
#include "server/measured/bounds.h"
#include "server/measured/reader.h"
#include "server/scene/bounds.h"
#include "server/settings/settings.h"
#include "server/spec/contract.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"
#include "server/worker/bounds.h"
#include "server/worker/read_measurement.h"
#include "server/worker/worker.h"

namespace {

using kiln::Error;
using kiln::Reader;
using kiln::Settings;

constexpr int kExitFailed = 1;
constexpr int kExitUsage = 2;

static_assert(kiln::measured::kFileBytesMax == std::size_t{kiln::kUploadMibMost} << 20,
              "what may be uploaded is what readers take");

constexpr const char* kUsage =
    "kilnd serve  [options]   serve HTTP and keep worker processes running\n"
    "kilnd worker [options]   claim jobs from a data directory and bake them\n"
    "kilnd --version | --help\n";

std::optional<std::string> environment(const std::string& name) {
    const char* value = std::getenv(name.c_str());
    if (value == nullptr) return std::nullopt;
    return value;
}

/// The data directory, made when absent, private to its user.
void make_data_dir(const std::string& path) {
    std::error_code failure;
    const bool made = std::filesystem::create_directories(path, failure);
    if (failure)
        throw Error("bad_setting",
                    "--data-dir: cannot make \"" + path + "\": " + failure.message());
    if (made) chmod(path.c_str(), 0700);
}

/// Held by the one server of a data directory until its process ends.
void lock_data_dir(const std::string& path) {
    const std::string file = path + "/serve.lock";
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (descriptor < 0)
        throw Error("bad_setting",
                    "--data-dir: cannot open \"" + file + "\": " + std::strerror(errno));
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0)
        throw Error("bad_setting", "another kilnd serve uses the data directory \"" + path +
                                       "\"; stop it or give another --data-dir");
}

/// Signals are taken by the threads that wait for them; a broken connection is an error return.
void arrange_signals() {
    sigset_t ends;
    sigemptyset(&ends);
    sigaddset(&ends, SIGTERM);
    sigaddset(&ends, SIGINT);
    sigprocmask(SIG_BLOCK, &ends, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
}

void raise_descriptor_limit() {
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
}

std::uint64_t bytes_of(std::int64_t mebibytes) {
    return static_cast<std::uint64_t>(mebibytes) << 20;
}

kiln::Bounds every_bound() {
    kiln::Bounds all;
    for (const kiln::Bounds& some :
         {kiln::http_bounds(), kiln::scene_bounds(), kiln::store_bounds(), kiln::worker_bounds(),
          kiln::measured::measured_bounds()})
        all.insert(all.end(), some.begin(), some.end());
    return all;
}

int run(const std::string& command, const Settings& settings) {
    make_data_dir(settings.data_dir);
    if (command == "serve") lock_data_dir(settings.data_dir);
    raise_descriptor_limit();
    const auto jobs = kiln::open_sqlite_job_store(settings.data_dir + "/jobs.db");
    kiln::DiskBlobStore disk(settings.data_dir, bytes_of(settings.cache_mib));
    if (command == "worker") {
        kiln::pin_opencl_threads();
        return kiln::run_worker(settings, *jobs, disk);
    }
    // Hundreds of connection threads would each grow an arena of their own.
    mallopt(M_ARENA_MAX, 4);
    kiln::CachedBlobStore hot(disk, bytes_of(settings.hot_cache_mib),
                              bytes_of(settings.downloads_mib));
    const std::string engine = kiln::kernel_digest() + "/" + std::to_string(kiln::kEncoderRevision);
    kiln::MeasurementStore measurements(settings.data_dir, bytes_of(settings.measurements_mib));
    return kiln::serve(settings, {engine, kiln::measured::kReaderRevision}, every_bound(), *jobs,
                       hot, measurements);
}

}  // namespace

int main(int count, char** values) {
    const std::vector<std::string> words(values + 1, values + count);
    const std::string command = words.empty() ? "" : words.front();
    if (command == "--version") {
        std::printf("kilnd %s\n", kiln::kVersion);
        return 0;
    }
    // Started by a server alone, with its socket and the file in place.
    if (command == "read-measurement") return kiln::read_measurement_once(kiln::kWorkerSocket);
    const bool known = command == "serve" || command == "worker";
    const Reader reader = command == "worker" ? Reader::worker : Reader::serve;
    if (!known || (words.size() > 1 && (words[1] == "--help" || words[1] == "-h"))) {
        const bool asked = known || command == "--help" || command == "-h";
        if (!asked && !words.empty())
            std::fprintf(stderr, "kilnd: \"%.80s\" is no command; allowed: serve, worker\n",
                         command.c_str());
        std::fputs(kUsage, asked ? stdout : stderr);
        if (known) std::printf("\n%s", kiln::settings_help(reader).c_str());
        return asked ? 0 : kExitUsage;
    }
    try {
        arrange_signals();
        kiln::check_contract();
        return run(command,
                   kiln::read_settings({words.begin() + 1, words.end()}, reader, environment));
    } catch (const Error& failure) {
        std::fprintf(stderr, "kilnd: %s\n", failure.what());
        return failure.code() == "bad_setting" ? kExitUsage : kExitFailed;
    } catch (const std::exception& failure) {
        std::fprintf(stderr, "kilnd: %s\n", failure.what());
        return kExitFailed;
    }
}
