// SPDX-License-Identifier: Apache-2.0
#include "server/settings/settings.h"

namespace kiln {

namespace {
constexpr std::int64_t kMebibytesMax = std::int64_t{1} << 24;  // 16 TiB: bytes still fit 64 bits
}  // namespace

// One setting, two lines.
// clang-format off
const std::vector<Setting>& settings_table() {
    using S = Settings;
    using R = Reader;
    static const std::vector<Setting> table = {
        {"listen", &S::listen, 0, 0, {}, "HOST:PORT", R::serve,
         "address to serve on; port 0 picks a free one"},
        {"data_dir", &S::data_dir, 0, 0, {}, "DIR", R::both,
         "jobs and results; default: kiln under the user's state directory"},
        {"device", &S::device, 0, 0, {"auto", "opencl", "native"}, "", R::both,
         "where jobs may run"},
        {"workers", &S::workers, 0, kWorkersMax, {}, "processes", R::serve,
         "worker processes to start; 0 leaves the work to workers started elsewhere"},
        {"threads", &S::threads, 0, 1024, {}, "threads", R::both,
         "of the native backend of each worker; 0 is every core"},
        {"queue_max", &S::queue_max, 1, 100000, {}, "jobs", R::serve,
         "queued jobs before new ones get 429"},
        {"cache_mib", &S::cache_mib, 1, kMebibytesMax, {}, "MiB", R::both,
         "results kept on disk; the least recently used go first"},
        {"hot_cache_mib", &S::hot_cache_mib, 0, 65536, {}, "MiB", R::serve,
         "results kept in memory"},
        {"downloads_mib", &S::downloads_mib, 1, 65536, {}, "MiB", R::serve,
         "results being sent, beside the hot cache, or one that is larger; more get 503"},
        {"upload_mib", &S::upload_mib, 1, kUploadMibMost, {}, "MiB", R::serve,
         "largest measurement that may be uploaded"},
        {"measurements_mib", &S::measurements_mib, kUploadMibMost + 8, kMebibytesMax, {}, "MiB",
         R::serve, "measurements kept; the least recently used that no waiting job names go first"},
        {"connections_max", &S::connections_max, 8, 4096, {}, "connections", R::serve,
         "served at once; half of them may wait for a job or listen to events"},
        {"header_timeout_s", &S::header_timeout_s, 1, 60, {}, "s", R::serve,
         "from the first byte of a request to the end of its header"},
        {"idle_timeout_s", &S::idle_timeout_s, 1, 600, {}, "s", R::serve,
         "an unused connection is kept"},
        {"body_timeout_s", &S::body_timeout_s, 1, 600, {}, "s", R::serve,
         "for the whole body of a request"},
        {"send_timeout_s", &S::send_timeout_s, 1, 600, {}, "s", R::serve,
         "a client may take no byte of an answer"},
        {"lease_s", &S::lease_s, 1, 3600, {}, "s", R::both,
         "a worker holds a job without renewing its claim"},
        {"attempts_max", &S::attempts_max, 1, 100, {}, "attempts", R::both,
         "at a job whose worker dies"},
        {"stall_s", &S::stall_s, 1, 3600, {}, "s", R::both,
         "without progress before a worker ends itself, as its device hangs"},
        {"silence_s", &S::silence_s, 2, 3600, {}, "s", R::serve,
         "without a sign of life before a worker is killed"},
        {"breaker_deaths", &S::breaker_deaths, 1, 1000, {}, "deaths", R::serve,
         "of workers within breaker_s that switch OpenCL off for as long"},
        {"breaker_s", &S::breaker_s, 1, 86400, {}, "s", R::serve, "see breaker_deaths"},
        {"drain_s", &S::drain_s, 0, 3600, {}, "s", R::serve,
         "running jobs get at shutdown before they go back to the queue"},
        {"worker_name", &S::worker_name, 0, 0, {}, "NAME", R::worker,
         "under which jobs are claimed; default: host and process id"},
        {"opencl_off_reason", &S::opencl_off_reason, 0, 0, {}, "TEXT", R::supervised,
         "why OpenCL is not touched"},
        {"opencl_off_s", &S::opencl_off_s, 0, 86400, {}, "s", R::supervised,
         "how long opencl_off_reason holds"},
        {"doorbell_fd", &S::doorbell_fd, -1, 1 << 20, {}, "", R::supervised,
         "socket to the supervisor"},
    };
    return table;
}
// clang-format on

}  // namespace kiln
