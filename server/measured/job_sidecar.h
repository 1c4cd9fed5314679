// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
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
    std::string colour;  ///< what red, green and blue are
    AzimuthAccount azimuths;
    Extrapolation extrapolation;  ///< what was done of what was asked for
};

/// A material that parameters are near enough to.
struct FittedMaterial {
    MeasuredMaterial material;
    Fit fit;
    bool left_out = false;  ///< the image has no cell of it
};

/// What every measured kind says of itself: kind, readers and, of tables, the pixel type and where
/// its bits lie.
nlohmann::ordered_json sidecar_head(const JobSpec& job);
/// What every measured kind says of a material: the measurement by hash, its format, title,
/// extrapolation and warnings.
void add_material(nlohmann::ordered_json& entry, const MeasuredMaterial& material,
                  const MaterialNote& note);
nlohmann::ordered_json fit_json(const Fit& fit);

/// sidecar_json() of a job, with what only the job knows: the pixel type and where its bits lie,
/// the measurements by hash, their extrapolation, and the notes. ASCII.
std::string job_sidecar(const JobSpec& job, const SliceLayout& layout, const SliceTable& made,
                        const std::vector<MaterialNote>& notes,
                        const std::vector<FittedMaterial>& fitted);

}  // namespace kiln::measured
