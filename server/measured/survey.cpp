// SPDX-License-Identifier: Apache-2.0
#include "server/measured/survey.h"

#include <algorithm>
#include <limits>
#include <map>

#include "server/measured/bounds.h"

namespace kiln::measured {
namespace {

void count_states(const Cloud& cloud, ComponentSurvey& result) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t n = 0; n < cloud.size(); ++n) {
        switch (cloud.state[n]) {
            case PointState::kMeasured:
                break;
            case PointState::kMirrored:
                ++result.mirrored;
                break;
            case PointState::kBelowHorizon:
                ++result.below_horizon;
                break;
            case PointState::kNotMeasured:
                ++result.not_measured;
                break;
            case PointState::kRejected:
                ++result.rejected;
                break;
        }
        if (!usable(cloud.state[n])) continue;
        ++result.usable;
        result.theta_out_max =
            std::max(result.theta_out_max, static_cast<double>(cloud.theta_o[n]));
        for (std::size_t c = 0; c < cloud.channels.size(); ++c) {
            low = std::min(low, static_cast<double>(cloud.at(n)[c]));
            high = std::max(high, static_cast<double>(cloud.at(n)[c]));
        }
    }
    result.value_min = result.usable > 0 ? low : 0;
    result.value_max = result.usable > 0 ? high : 0;
}

}  // namespace

ComponentSurvey survey(const Component& component) {
    const Cloud& cloud = component.cloud;
    ComponentSurvey result;
    result.name = component.name;
    result.channels = cloud.channels;
    result.points = cloud.size();
    count_states(cloud, result);
    std::vector<Incidence> incidences = incidences_of(component, usual_theta_in());
    result.incidence_count = incidences.size();
    if (incidences.size() > kSurveyedIncidencesMax) incidences.resize(kSurveyedIncidencesMax);
    std::vector<Hemisphere> hemispheres;
    for (const Incidence& incidence : incidences) {
        hemispheres.emplace_back(incidence, cloud.channels.size());
        const Hemisphere& one = hemispheres.back();
        result.incidences.push_back({incidence.theta_i, incidence.phi_i,
                                     static_cast<std::size_t>(std::count_if(
                                         incidence.state.begin(), incidence.state.end(), usable)),
                                     one.albedo(), one.coverage()});
    }
    result.reciprocity = reciprocity_error(hemispheres);
    return result;
}

std::string account_of_file(std::string_view bytes) {
    const Reading reading = read_measurement(bytes);
    std::vector<ComponentSurvey> parts;
    for (const Component& component : reading.components) parts.push_back(survey(component));
    return account_json(reading.understood, parts);
}

}  // namespace kiln::measured
