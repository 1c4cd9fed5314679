// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "server/measured/job_sidecar.h"
#include "server/measured/resample.h"

namespace kiln::measured {

/// The image and side-car of a job of kind companion, sampling, lobe_view or sphere_view, made a
/// material at a time in the job's order.
///
/// companion: a row a material, texel x at NoV = (x + 0.5) / width; E in R, G and B, and the share
/// of it that is extrapolated. sampling: for each theta_in rings of cells about the mirror
/// direction (LobeSampler), each with the running sum of the rings to its own, the running sum of
/// its ring's cells to itself, and its probability.
class JobProduct {
  public:
    /// `job` outlives this.
    explicit JobProduct(const JobSpec& job);
    ~JobProduct();
    JobProduct(const JobProduct&) = delete;
    JobProduct& operator=(const JobProduct&) = delete;

    /// Throws Error("unfit_measurement") where nothing of the kind can be made of the material.
    void add(const Material& material, const MaterialNote& note, Resampler& resampler);

    const Table& table() const;                        ///< of companion and sampling
    std::string picture() const;                       ///< of views: a PNG
    std::string sidecar() const;                       ///< ASCII
    const std::vector<std::string>& warnings() const;  ///< with the material's name in front

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace kiln::measured
