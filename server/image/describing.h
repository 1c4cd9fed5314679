// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "server/spec/job_spec.h"

/// What the files that put a job into words share; nobody outside includes this.
namespace kiln::describing {

/// Shortest text that reads back as the same double.
inline std::string number(double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    return {text, end};
}

inline std::string text(std::string_view word) { return std::string(word); }

inline bool is_split_sum(Quantity q) {
    return q == Quantity::split_sum_scale || q == Quantity::split_sum_bias;
}

inline bool any(const JobSpec& job, bool (*of)(Quantity)) {
    return std::any_of(job.quantities.begin(), job.quantities.end(), of);
}

}  // namespace kiln::describing
