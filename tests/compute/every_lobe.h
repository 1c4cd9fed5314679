// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/error.h"
#include "server/compute/plan.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {

/// Every distribution under every masking that it takes, by every importance that draws it: what a
/// job document may say.
inline std::vector<JobSpec> every_lobe_job() {
    std::vector<JobSpec> lobes;
    const auto add = [&](std::string_view distribution, std::string_view masking,
                         std::string_view importance, bool softened) {
        std::string job = R"({"quantities":["directional_albedo"],"importance":")";
        job += importance;
        job += R"(","microfacet":{"distribution":")";
        job += distribution;
        job += R"(","masking":")";
        job += masking;
        job += softened ? R"(","terminator_softening":true}})" : "\"}}";
        try {
            lobes.push_back(parse_job(job));
        } catch (const InvalidJob&) {
            // no such lobe
        }
    };
    for (const std::string_view distribution : words<Distribution>())
        for (const std::string_view masking : words<Masking>())
            for (const std::string_view importance : words<Importance>())
                for (const bool softened : {false, true})
                    add(distribution, masking, importance, softened);
    return lobes;
}

/// The same as the kernels number it, with no term yet.
inline std::vector<KernelMaterial> every_lobe() {
    std::vector<KernelMaterial> lobes;
    for (const JobSpec& job : every_lobe_job()) lobes.push_back(lobe_of(job));
    return lobes;
}

struct LobePair {
    int distribution, masking;
};

/// Those of them that quadrature integrates by its rule for every lobe: all but GGX under Smith's
/// maskings, once each.
inline std::vector<LobePair> lobes_of_the_general_rule() {
    std::vector<LobePair> pairs;
    for (const KernelMaterial& lobe : every_lobe()) {
        if (lobe.distribution == KILN_DISTRIBUTION_GGX &&
            lobe.masking <= KILN_MASKING_SMITH_SEPARABLE)
            continue;
        if (std::ranges::none_of(pairs, [&](const LobePair& pair) {
                return pair.distribution == lobe.distribution && pair.masking == lobe.masking;
            }))
            pairs.push_back({lobe.distribution, lobe.masking});
    }
    return pairs;
}

}  // namespace kiln
