// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "server/measured/hemisphere.h"
#include "server/measured/reader.h"

namespace kiln::measured {

/// What a component's numbers say about it.
struct IncidenceSurvey {
    double theta_i = 0, phi_i = 0;  ///< degrees
    std::size_t points = 0;         ///< usable ones
    std::vector<double> albedo;     ///< integral over the measured part, a channel each
    double coverage = 0;            ///< share of the hemisphere that this part is, 0 … 1
};
struct ComponentSurvey {
    std::string name;
    std::vector<std::string> channels;
    std::size_t points = 0, usable = 0, mirrored = 0, below_horizon = 0, not_measured = 0,
                rejected = 0;
    double value_min = 0, value_max = 0;  ///< 1/sr, of usable points
    double theta_out_max = 0;             ///< degrees, of usable points
    std::vector<IncidenceSurvey> incidences;
    std::size_t incidence_count = 0;  ///< incidences may be fewer: the account has a bound
    ReciprocityError reciprocity;
};

ComponentSurvey survey(const Component& component);

/// The account of a file as JSON text: format, title, findings, warnings, left_out, components.
std::string account_json(const Understood& understood, const std::vector<ComponentSurvey>& parts);

/// Reads and surveys in one step: what a worker does with an uploaded file.
std::string account_of_file(std::string_view bytes);

}  // namespace kiln::measured
