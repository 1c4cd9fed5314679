// SPDX-License-Identifier: Apache-2.0
#include "tests/measured/fuzz_targets.h"

#include <cstdlib>

#include "server/measured/survey.h"

namespace kiln {
namespace {

void look_at(const measured::Reading& reading) {
    std::vector<measured::ComponentSurvey> parts;
    for (const measured::Component& part : reading.components)
        // Of MERL's layout views are made afresh, thousands of whatever file.
        if (part.cloud.size() <= kSurveyPointsMax && part.grid.phi_d == 0)
            parts.push_back(measured::survey(part));
    if (measured::account_json(reading.understood, parts).empty()) std::abort();
}

/// One input of 16, by a hash of its bytes (FNV-1a): what follows takes as long as reading.
bool goes_on(std::string_view bytes) {
    std::uint32_t hash = 2166136261u;
    for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
    return hash >> 28 == 0;
}

}  // namespace

void read_all_the_way(const FuzzTarget& target, std::string_view bytes) {
    const measured::Reading reading = target.read(bytes);
    if (!goes_on(bytes)) return;
    look_at(reading);
    // The chooser and what it finds, which MERL's small table is not for.
    if (target.name != "merl") measured::read_measurement(bytes);
}

}  // namespace kiln
