// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>

namespace kiln {

/// A glTF asset taken apart; both are views of it.
struct Container {
    std::string_view json, binary;
    bool is_glb = false;
};

/// The chunks of a binary glTF 2.0, or the text itself. Throws Malformed for a binary one that does
/// not add up.
Container open_container(std::string_view bytes);

}  // namespace kiln
