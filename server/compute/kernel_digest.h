// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

namespace kiln {

/// The flattened OpenCL C text of kernels/.
std::string_view kernel_text();

/// SHA-256 of kernel_text(): names the physics that made a table.
const std::string& kernel_digest();

}  // namespace kiln
