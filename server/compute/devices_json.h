// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "server/compute/engine.h"

namespace kiln {

/// A JSON array on one line, as /v1/capabilities and `kiln devices --json` show devices. Whatever
/// is not UTF-8 in a driver's texts is replaced.
std::string to_json(const std::vector<DeviceInfo>& devices);

}  // namespace kiln
