// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "server/store/job_store.h"

namespace kiln {

namespace {
// In the order of JobState.
constexpr std::array<std::string_view, 5> kWords{"queued", "running", "done", "failed",
                                                 "cancelled"};
}  // namespace

std::string_view to_word(JobState state) { return kWords.at(static_cast<std::size_t>(state)); }

std::optional<JobState> job_state_from(std::string_view word) {
    for (std::size_t i = 0; i < kWords.size(); ++i)
        if (kWords[i] == word) return static_cast<JobState>(i);
    return std::nullopt;
}

}  // namespace kiln
