// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "server/measured/fits.h"
#include "server/measured/slices.h"
#include "server/spec/job_spec.h"

namespace kiln::measured {

/// What is told of a job's material beside its SliceAccount.
struct MaterialNote {
    std::string format, title;         ///< of the file
    std::vector<double> lookup_error;  ///< one a slice
    std::vector<std::string> warnings;
};

/// A material that parameters are near enough to.
struct FittedMaterial {
    MeasuredMaterial material;
    Fit fit;
    bool left_out = false;  ///< the image has no cell of it
};

/// sidecar_json() of a job, with what only the job knows: the pixel type and where its bits lie,
/// the measurements by hash, their extrapolation, and the notes. ASCII.
std::string job_sidecar(const JobSpec& job, const SliceLayout& layout, const SliceTable& made,
                        const std::vector<MaterialNote>& notes,
                        const std::vector<FittedMaterial>& fitted);

}  // namespace kiln::measured
