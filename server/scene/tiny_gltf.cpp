// SPDX-License-Identifier: Apache-2.0
// The body of the glTF library; CMakeLists.txt beside it leaves out what opens files and decodes
// images.
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>
