// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <random>

#include "tests/scene/scenes.h"

namespace kiln::test {

std::string mutated(const std::string& bytes, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::string result = bytes;
    const auto below = [&](std::size_t count) {
        return count == 0 ? 0 : static_cast<std::size_t>(random() % count);
    };
    constexpr std::array<std::string_view, 24> kPieces = {"-1",
                                                          "1e999",
                                                          "0.5",
                                                          "4294967296",
                                                          "18446744073709551616",
                                                          "null",
                                                          "true",
                                                          "[]",
                                                          "{}",
                                                          "\"\"",
                                                          "[[[[",
                                                          "}}}}",
                                                          "\xFF",
                                                          "\"",
                                                          ",",
                                                          ":",
                                                          "1e-9",
                                                          "[0,0,0]",
                                                          "9007199254740993",
                                                          "\"data:;base64,AAAA\"",
                                                          "NaN",
                                                          "0",
                                                          "-0.0",
                                                          "\"../../x\""};
    const std::size_t changes = 1 + below(6);
    for (std::size_t i = 0; i < changes; ++i) {
        const std::size_t at = below(result.size() + 1);
        switch (below(6)) {
            case 0:  // a byte
                if (at < result.size()) result[at] = static_cast<char>(random());
                break;
            case 1:  // a piece that readers trip over, in place of some bytes
                result.replace(at, below(8), kPieces[below(kPieces.size())]);
                break;
            case 2:  // cut out
                result.erase(at, below(64));
                break;
            case 3:  // twice
                result.insert(at, result.substr(at, below(64)));
                break;
            case 4: {  // one number for another
                const std::size_t digit = result.find_first_of("0123456789", at);
                if (digit != result.npos) result.replace(digit, 1, kPieces[below(8)]);
                break;
            }
            default:  // cut short
                if (below(4) == 0) result.resize(at);
        }
    }
    return result;
}

}  // namespace kiln::test
