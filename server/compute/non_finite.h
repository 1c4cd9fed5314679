// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "server/base/error.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// The error of a value that no table holds, with its cause where the lobe is known to have none.
inline Error non_finite(const std::string& what, int distribution) {
    const bool charlie = distribution == static_cast<int>(Distribution::charlie);
    return Error(
        "non_finite",
        what + " not finite" +
            (charlie ? "; Charlie's albedo has no bound at NoV = 0, at roughness 0 or under "
                       "masking \"charlie\": let the NoV axis start above 0"
                     : ""));
}

}  // namespace kiln
