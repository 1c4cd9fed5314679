// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <filesystem>
#include <string>

#include "server/store/blob_store.h"
#include "server/store/job_store.h"

namespace {

using namespace kiln;

// On the disk that the program is started on: a memory file system would hide every fsync.
struct Folder {
    Folder() {
        std::string name = (std::filesystem::current_path() / "bench_store.XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp " + name);
        path = name;
    }
    ~Folder() { std::filesystem::remove_all(path); }
    std::string path;
};

void job_submit_claim_finish(benchmark::State& state) {
    Folder folder;
    auto store = open_sqlite_job_store(folder.path + "/jobs.db");
    const std::string spec(600, 'x');
    std::int64_t count = 0;
    for (auto _ : state) {
        store->submit("job" + std::to_string(count++), spec, "engine");
        const JobRecord job = store->claim("worker", std::chrono::minutes(1), 3).value();
        store->finish(job.id, job.attempts, "digest", "exr", spec);
    }
}
BENCHMARK(job_submit_claim_finish)->Unit(benchmark::kMicrosecond)->UseRealTime();

void job_submit_known(benchmark::State& state) {
    Folder folder;
    auto store = open_sqlite_job_store(folder.path + "/jobs.db");
    store->submit("job", std::string(600, 'x'), "engine");
    for (auto _ : state) benchmark::DoNotOptimize(store->submit("job", "x", "engine"));
}
BENCHMARK(job_submit_known)->Unit(benchmark::kMicrosecond)->UseRealTime();

const std::size_t kImageBytes = 200'000;  // a 256² half-float table

void blob_put(benchmark::State& state) {
    Folder folder;
    DiskBlobStore store(folder.path, 64 << 20);
    std::string bytes(kImageBytes, 'x');
    std::uint64_t count = 0;
    for (auto _ : state) {
        const std::string number = std::to_string(count++);
        bytes.replace(0, number.size(), number);
        store.put(bytes);
    }
}
BENCHMARK(blob_put)->Unit(benchmark::kMicrosecond)->UseRealTime();

void blob_get_cold(benchmark::State& state) {
    Folder folder;
    DiskBlobStore store(folder.path, 64 << 20);
    const std::string digest = store.put(std::string(kImageBytes, 'x'));
    for (auto _ : state) benchmark::DoNotOptimize(store.get(digest));
}
BENCHMARK(blob_get_cold)->Unit(benchmark::kMicrosecond)->UseRealTime();

// One cache for all threads, as in the server.
void blob_get_hot(benchmark::State& state) {
    static Folder* folder;
    static DiskBlobStore* disk;
    static CachedBlobStore* cache;
    static std::string digest;
    if (state.thread_index() == 0) {
        folder = new Folder;
        disk = new DiskBlobStore(folder->path, 64 << 20);
        cache = new CachedBlobStore(*disk, 16 << 20, 64 << 20);
        digest = cache->put(std::string(kImageBytes, 'x'));
    }
    for (auto _ : state) benchmark::DoNotOptimize(cache->get(digest));
    if (state.thread_index() == 0) {
        delete cache;
        delete disk;
        delete folder;
    }
}
BENCHMARK(blob_get_hot)->Threads(1)->Threads(2)->Threads(8)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
