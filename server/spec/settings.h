// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace kiln {

/// A job document with `field=value` settings applied in order: "seed=7", "output.format=png",
/// "resolution=[64,64]". Dots lead into objects, which are made where absent, and numbers into
/// arrays. A value is JSON if it reads as JSON, else a string. The result is not validated:
/// parse_job does that. Throws Malformed for a document that cannot be read and, naming it, for a
/// setting that cannot be applied.
std::string apply_settings(std::string_view job_text, const std::vector<std::string>& settings);

}  // namespace kiln
