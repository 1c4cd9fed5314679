// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "server/spec/job_spec.h"

namespace kiln {

/// One plane of a job's table.
struct Channel {
    Quantity quantity;
    int colour = 0;    ///< 0…2 for R G B of a coloured quantity, else 0
    std::string name;  ///< the quantity's word, followed by .R .G .B where it is coloured
};

/// The planes of a job in their order: a quantity is one plane, or three where the numbers of the
/// models that it reads are three.
std::vector<Channel> channels_of(const JobSpec& job);

/// What a quantity reads beside the lobe.
bool reads_fresnel(Quantity quantity);
bool reads_diffuse(Quantity quantity);
/// The microfacet lobe, alone or in a material.
bool reads_lobe(Quantity quantity);
bool reads_multiscatter(Quantity quantity);

/// What keeps quadrature from a quantity of the job, as the object of "has no rule for"; empty
/// where nothing does.
std::optional<std::string> quadrature_lacks(const JobSpec& job, Quantity quantity);

/// False for what is a function of roughness (or of nothing) alone, so that a table of one axis
/// holds it.
bool depends_on_NoV(Quantity quantity);

}  // namespace kiln
