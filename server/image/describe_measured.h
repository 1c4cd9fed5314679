// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/image/image.h"

/// What describe() and convention() say of slices and atlases; nobody outside includes this.
namespace kiln {

Metadata describe_measured(const JobSpec& job, const Provenance& provenance);
std::vector<std::string> measured_convention(const JobSpec& job);

}  // namespace kiln
