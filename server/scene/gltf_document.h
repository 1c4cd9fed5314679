// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tiny_gltf.h>

#include <nlohmann/json_fwd.hpp>

#include "server/spec/schema.h"

namespace kiln {

/// What the contract's schema Gltf names of a parsed document, taken apart by the library. Types,
/// bounds and defaults hold; that an index has something to point at is for the reader to ask.
/// Images and buffers hold their URI and no bytes: nothing was decoded, nothing outside the
/// document was opened. Problems are added, each with its pointer, and what is returned then means
/// nothing.
tinygltf::Model open_gltf(nlohmann::json document, ProblemList& problems);

}  // namespace kiln
