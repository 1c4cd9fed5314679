// SPDX-License-Identifier: Apache-2.0
// Deterministic mutations of a small valid file of each format, given to the reader from memory
// that ends at a page nobody may read.
//   fuzz_readers --runs 1000000 [--reader NAME] [--seed N]
//   fuzz_readers --seconds 60 [--reader NAME] [--seed N]
// A run passes if the file is read or refused by kiln::Error. Runs go by their number alone, so a
// failure is repeated by its printed reader and seed. Seconds are of each reader, which makes 3000
// runs in any case; KILN_FUZZ_SECONDS stands for what --seconds says.
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <stdexcept>

#include "server/base/error.h"
#include "tests/measured/fuzz_targets.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)  // GCC
#define KILN_SANITIZED 1
#elif defined(__has_feature)  // Clang
#define KILN_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define KILN_SANITIZED 0
#endif

namespace kiln {
namespace {

/// SplitMix64 (Steele, Lea and Flood 2014).
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next() {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15);
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
        z = (z ^ z >> 27) * 0x94d049bb133111eb;
        return z ^ z >> 31;
    }
    std::size_t below(std::size_t count) { return count == 0 ? 0 : next() % count; }

  private:
    std::uint64_t state_;
};

/// Bytes whose end is the end of what may be read.
class Guarded {
  public:
    Guarded() : page_(static_cast<std::size_t>(sysconf(_SC_PAGESIZE))) {
        memory_ = static_cast<char*>(mmap(nullptr, kRoom + page_, PROT_READ | PROT_WRITE,
                                          MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
        if (memory_ == MAP_FAILED || mprotect(memory_ + kRoom, page_, PROT_NONE) != 0)
            throw std::runtime_error("mmap");
    }
    ~Guarded() { munmap(memory_, kRoom + page_); }
    Guarded(const Guarded&) = delete;
    Guarded& operator=(const Guarded&) = delete;
    std::string_view hold(std::string_view bytes) {
        const std::size_t size = std::min(bytes.size(), kRoom);
        char* start = memory_ + kRoom - size;
        std::memcpy(start, bytes.data(), size);
        return {start, size};
    }

  private:
    static constexpr std::size_t kRoom = std::size_t{1} << 20;
    std::size_t page_;
    char* memory_;
};

constexpr std::uint64_t kIntegers[] = {0,
                                       1,
                                       2,
                                       0x7fffffff,
                                       0x80000000,
                                       0xffffffff,
                                       0x7fffffffffffffff,
                                       0x8000000000000000,
                                       0xffffffffffffffff};

void mutate(std::string& bytes, Random& random) {
    const std::size_t at = random.below(bytes.size() + 1);
    switch (random.below(8)) {
        case 0:
            if (at < bytes.size())
                bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
            break;
        case 1:
            if (at < bytes.size()) bytes[at] = static_cast<char>(random.next());
            break;
        case 2:
            bytes.resize(at);
            break;
        case 3:
            bytes.erase(at, random.below(16));
            break;
        case 4:
            bytes.insert(at, bytes.substr(random.below(bytes.size() + 1), random.below(64)));
            break;
        case 5:
            bytes.insert(at, kFuzzWords[random.below(std::size(kFuzzWords))]);
            break;
        case 6: {
            const std::string word = kFuzzWords[random.below(std::size(kFuzzWords))];
            bytes.replace(at, std::min(word.size(), bytes.size() - at), word);
            break;
        }
        default: {
            const std::uint64_t value = kIntegers[random.below(std::size(kIntegers))];
            const std::size_t size =
                std::min<std::size_t>(random.below(2) == 0 ? 4 : 8, bytes.size() - at);
            std::memcpy(bytes.data() + at, &value, size);
        }
    }
}

struct Tally {
    std::uint64_t read = 0;
    std::map<std::string, std::uint64_t> refused;
};

void run(const FuzzTarget& target, std::string_view bytes, Tally& tally) {
    try {
        read_all_the_way(target, bytes);
        ++tally.read;
    } catch (const Error& error) {
        ++tally.refused[error.code()];
    }
}

void limit_memory() {
    if (KILN_SANITIZED) return;
    const rlimit limit{std::size_t{1} << 30, std::size_t{1} << 30};
    setrlimit(RLIMIT_AS, &limit);
}

/// How long each reader is fuzzed.
struct Effort {
    std::uint64_t runs = 3000;
    double seconds = 0;  ///< 0: runs alone count
};

/// Whether run n is still to be made.
bool goes_on(const Effort& effort, std::uint64_t n, std::chrono::steady_clock::time_point start) {
    if (n < effort.runs || effort.seconds <= 0) return n < effort.runs;
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    return spent.count() < effort.seconds;
}

int fuzz(std::string_view only, const Effort& effort, std::uint64_t seed) {
    limit_memory();
    Guarded guarded;
    bool any = false;
    for (const FuzzTarget& reader : fuzz_targets()) {
        if (!only.empty() && only != reader.name) continue;
        any = true;
        const std::string& start = reader.seed;
        Tally tally;
        const auto began = std::chrono::steady_clock::now();
        std::uint64_t runs = 0;
        for (; goes_on(effort, runs, began); ++runs) {
            const std::uint64_t n = runs;
            Random random(seed + n);
            std::string bytes = start;
            const std::size_t count = 1 + random.below(6);
            for (std::size_t k = 0; k < count; ++k) mutate(bytes, random);
            try {
                run(reader, guarded.hold(bytes), tally);
            } catch (const std::exception& problem) {
                std::printf("%s: seed %llu: %s\n", reader.name.data(),
                            static_cast<unsigned long long>(seed + n), problem.what());
                return 1;
            }
        }
        std::printf("%-10s %llu runs, %llu read", reader.name.data(),
                    static_cast<unsigned long long>(runs),
                    static_cast<unsigned long long>(tally.read));
        for (const auto& [code, count] : tally.refused)
            std::printf(", %llu %s", static_cast<unsigned long long>(count), code.c_str());
        std::printf("\n");
        std::fflush(stdout);
    }
    return any ? 0 : 2;
}

}  // namespace
}  // namespace kiln

int main(int count, char** arguments) {
    std::string_view only;
    kiln::Effort effort;
    std::uint64_t seed = 0;
    for (int n = 1; n + 1 < count; n += 2) {
        const std::string_view key = arguments[n];
        if (key == "--reader") only = arguments[n + 1];
        if (key == "--runs") effort.runs = std::strtoull(arguments[n + 1], nullptr, 10);
        if (key == "--seconds") effort.seconds = std::strtod(arguments[n + 1], nullptr);
        if (key == "--seed") seed = std::strtoull(arguments[n + 1], nullptr, 10);
    }
    const char* asked = std::getenv("KILN_FUZZ_SECONDS");
    if (asked && effort.seconds > 0) effort.seconds = std::max(1e-3, std::strtod(asked, nullptr));
    return kiln::fuzz(only, effort, seed);
}
