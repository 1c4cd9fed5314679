// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
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

/// What a data: URI holds; empty for any other URI and for one that is not good base64.
std::optional<std::string> data_uri_bytes(std::string_view uri);

}  // namespace kiln
