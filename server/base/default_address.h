// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kiln {

/// Where `kilnd serve` listens and `kiln` looks for it unless told otherwise.
inline constexpr const char* kDefaultAddress = "127.0.0.1:8117";

}  // namespace kiln
