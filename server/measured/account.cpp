// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "server/measured/survey.h"

namespace kiln::measured {
namespace {

using json = nlohmann::ordered_json;

json component_json(const ComponentSurvey& part) {
    json incidences = json::array();
    for (const IncidenceSurvey& one : part.incidences)
        incidences.push_back({{"theta_in_deg", one.theta_i},
                              {"phi_in_deg", one.phi_i},
                              {"points", one.points},
                              {"albedo", one.albedo},
                              {"coverage", one.coverage}});
    json result = {{"name", part.name},
                   {"channels", part.channels},
                   {"points",
                    {{"all", part.points},
                     {"usable", part.usable},
                     {"mirrored", part.mirrored},
                     {"below_horizon", part.below_horizon},
                     {"not_measured", part.not_measured},
                     {"rejected", part.rejected}}},
                   {"value", {{"min", part.value_min}, {"max", part.value_max}}},
                   {"theta_out_max_deg", part.theta_out_max},
                   {"incidence_count", part.incidence_count},
                   {"incidences", incidences}};
    result["reciprocity"] = nullptr;
    if (part.reciprocity.pairs > 0)
        result["reciprocity"] = {{"pairs", part.reciprocity.pairs},
                                 {"median", part.reciprocity.median},
                                 {"p95", part.reciprocity.p95}};
    return result;
}

}  // namespace

std::string account_json(const Understood& understood, const std::vector<ComponentSurvey>& parts) {
    json account = {{"format", understood.format}, {"title", understood.title}};
    json findings = json::array(), left_out = json::array(), components = json::array();
    for (const Finding& finding : understood.findings)
        findings.push_back(
            {{"what", finding.what}, {"value", finding.value}, {"evidence", finding.evidence}});
    for (const LeftOut& left : understood.left_out)
        left_out.push_back({{"what", left.what}, {"why", left.why}});
    for (const ComponentSurvey& part : parts) components.push_back(component_json(part));
    account["findings"] = findings;
    account["warnings"] = understood.warnings;
    account["left_out"] = left_out;
    account["components"] = components;
    return account.dump();
}

}  // namespace kiln::measured
