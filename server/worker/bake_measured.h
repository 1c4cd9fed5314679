// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/worker/bake.h"

namespace kiln {

/// bake() of slices and atlases: from files to slices to an image and its side-car.
Baked bake_measured(Engine& engine, const JobSpec& job, const Control& control,
                    const MeasurementSource& measurements);

}  // namespace kiln
