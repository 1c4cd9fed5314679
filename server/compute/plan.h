// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "server/compute/axes.h"
#include "server/compute/backend.h"
#include "server/compute/points.h"
#include "server/compute/report.h"
#include "server/compute/terms.h"
#include "server/spec/channels.h"

namespace kiln {

/// What two means a and b make of a channel, with the derivatives that carry their errors over, and
/// the variance of what else went in.
struct Part {
    double value = 0, by_a = 1, by_b = 0, variance = 0;
};

/// What a pass adds to one channel: a combination of its terms, or a function of two.
struct Share {
    std::size_t channel = 0;
    Combination a{}, b{};
    /// Of (place, a, b). Empty: a itself. Linear in each place's error, to first order.
    std::function<Part(std::size_t, double, double)> part;
};

/// What a pass samples.
enum class Lobe { microfacet, diffuse, sheen };

/// One kernel specialisation over one set of places: the shares in it cost its terms once.
struct Pass {
    Specialisation what;
    Lobe lobe = Lobe::microfacet;
    PointKind points = PointKind::visible_normals;
    Places places;
    std::array<double, kParameterCount> parameters{};
    std::vector<std::size_t> slices{0};  ///< of the table that hold what is found
    std::vector<Share> shares;
    /// Mean of a specular term at the mirror, α = 0, of a NoV.
    std::function<double(std::size_t term, double NoV)> mirror;
};

/// A channel that needs no integration: value(slice), the same at every place.
struct Exact {
    std::size_t channel = 0;
    std::function<double(std::size_t)> value;
};

/// What is computed for a job, and what is not.
struct Plan {
    std::vector<Channel> channels;
    std::vector<Pass> passes;
    std::vector<Exact> exact;
    std::vector<LeftOut> left_out;
    std::vector<std::string> warnings;  ///< what the report says of the job, however it is computed
};

/// 1 − E_avg of the job's lobe at each place of Places::averaged(job), with its standard error.
struct Averages {
    std::vector<double> deficit, standard_error;
};

/// `averages` is asked only where a term of multiple scattering needs it.
Plan make_plan(const JobSpec& job, const std::function<Averages()>& averages);

/// Whether the kernels' fast path (kernels/batch.h) knows this lobe and these terms.
inline bool is_on_fast_path(const KernelMaterial& material) {
    return static_cast<Distribution>(material.distribution) == Distribution::ggx &&
           static_cast<Masking>(material.masking) <= Masking::smith_separable &&
           static_cast<Importance>(material.importance) <= Importance::ndf &&
           (material.terms & ~(1 << kWeight | 1 << kSchlick | 1 << kDeficit)) == 0;
}

/// The lobe of a job as the kernels number it, with no term yet.
KernelMaterial lobe_of(const JobSpec& job);

}  // namespace kiln
