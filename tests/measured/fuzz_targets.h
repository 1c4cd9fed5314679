// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/measured/reader.h"

namespace kiln {

/// A reader with a valid file to start from. MERL's is of a small table, which the format has not,
/// so that its values are reached in microseconds.
struct FuzzTarget {
    std::string_view name;
    std::string seed;
    std::function<measured::Reading(std::string_view)> read;
};
std::vector<FuzzTarget> fuzz_targets();

/// Words of these formats, and what numbers should not be.
inline constexpr const char* kFuzzWords[] = {"-1",
                                             "0",
                                             "1e308",
                                             "nan",
                                             "inf",
                                             "4294967296",
                                             "-",
                                             "\t",
                                             ",",
                                             "\r",
                                             "\n\n",
                                             "1e-400",
                                             "91",
                                             "#",
                                             "\"",
                                             "{",
                                             "<",
                                             "&#0;",
                                             ";",
                                             "]",
                                             "TIS",
                                             "AOI 5",
                                             "VARS a",
                                             "DataBegin",
                                             "scale",
                                             "sin",
                                             "log",
                                             "RGB",
                                             "\xef\xbb\xbf",
                                             "999999999999999999999"};

/// Largest cloud that is looked at as well as read.
inline constexpr std::size_t kSurveyPointsMax = 600;

/// Straight into the reader, so that no mutation of the magic hides it, and one input of 16 the
/// whole way: chooser, survey, account. Throws kiln::Error for what is refused.
void read_all_the_way(const FuzzTarget& target, std::string_view bytes);

}  // namespace kiln
