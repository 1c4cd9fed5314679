// SPDX-License-Identifier: Apache-2.0
// libFuzzer's entry to the readers of measured files; see CONTRIBUTING.md.
//   fuzz_measurement --reader=csv -runs=1000000 CORPUS
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "server/base/error.h"
#include "tests/measured/fuzz_targets.h"

namespace {

const kiln::FuzzTarget*& chosen() {
    static const kiln::FuzzTarget* target = nullptr;
    return target;
}

}  // namespace

/// libFuzzer leaves flags of two dashes to the target.
extern "C" int LLVMFuzzerInitialize(int* count, char*** values) {
    static const std::vector<kiln::FuzzTarget> targets = kiln::fuzz_targets();
    for (int n = 1; n < *count; ++n)
        for (const kiln::FuzzTarget& target : targets)
            if (std::string((*values)[n]) == "--reader=" + std::string(target.name))
                chosen() = &target;
    if (chosen()) return 0;
    std::fprintf(stderr, "say --reader=NAME with one of:");
    for (const kiln::FuzzTarget& target : targets)
        std::fprintf(stderr, " %s", std::string(target.name).c_str());
    std::fprintf(stderr, "\n");
    std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        kiln::read_all_the_way(*chosen(), {reinterpret_cast<const char*>(data), size});
    } catch (const kiln::Error&) {
    }
    return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t size_max);

/// Damage starts from a valid file, so that an empty corpus will do; words of the formats stand for
/// a dictionary.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t size_max, unsigned seed) {
    const std::string& valid = chosen()->seed;
    if ((size < 16 || seed % 64 == 0) && valid.size() <= size_max) {
        std::copy(valid.begin(), valid.end(), data);
        size = valid.size();
    }
    if (seed % 4 == 1) {
        const char* word = kiln::kFuzzWords[seed / 4 % std::size(kiln::kFuzzWords)];
        const std::size_t length = std::strlen(word), at = seed / 128 % (size + 1);
        if (size + length <= size_max) {
            std::memmove(data + at + length, data + at, size - at);
            std::memcpy(data + at, word, length);
            return size + length;
        }
    }
    return LLVMFuzzerMutate(data, size, size_max);
}
