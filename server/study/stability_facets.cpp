// SPDX-License-Identifier: Apache-2.0
#include "server/compute/facet_space.h"
#include "server/study/host_albedo.h"
#include "server/study/stability.h"

// Lambertian facets solved without chance (server/compute/facet_space.h), which the host does in
// double alone.
namespace kiln::stability {

namespace {

constexpr unsigned kDirections = 24;
/// What a rule of so many directions is off by, server/compute/facet_space.h's test has it.
constexpr double kRule = 5e-7;
const double kAlphas[] = {0, 1e-40, 1e-12, 1e-6, 1e-3, 0.1, 1};
const double kCosines[] = {0, 1e-40, 1e-6, 1e-3, 0.1, 1};
/// What leaves after two facets is no part of its 16 digits.
constexpr double kFaint = 1e-30;
const double kAlbedos[] = {0, kFaint, 0.5, 1};

std::pair<Right, std::string> right_of(double alpha, double NoV, std::size_t k,
                                       const FacetSpace& fine,
                                       const std::vector<FacetSpace::Lit>& lit) {
    const double rho = kAlbedos[k];
    if (rho == 0) return {{0, 0}, "nothing is reflected"};
    if (rho == 1) return {{1, 1e-12}, "white facets lose nothing"};
    // What a facet can see of others is of the order of its slope.
    if (alpha < 1e-6) return {{rho, 1e-6 * rho}, "Lambert, its limit as alpha -> 0"};
    if (rho == kFaint)
        return {{rho * host_single_facet_albedo(NoV, alpha, kRule * 1e-2), kRule * rho},
                "one facet, over slopes and lights in double"};
    return {{fine.albedo(NoV, lit)[k], kRule * rho}, "twice the directions"};
}

void facets(Bench& bench, Findings& findings) {
    const std::string name = "ggx_lambert, solved";
    for (const double alpha : kAlphas) {
        bench.look();
        const FacetSpace space(alpha, kDirections), fine(alpha, 2 * kDirections);
        std::vector<FacetSpace::Lit> lights, fine_lights;
        for (const double rho : kAlbedos) {
            lights.push_back(space.lit(rho));
            fine_lights.push_back(fine.lit(rho));
        }
        for (const double NoV : kCosines) {
            const std::vector<double> found = space.albedo(NoV, lights);
            for (std::size_t k = 0; k < std::size(kAlbedos); ++k) {
                const auto [right, source] = right_of(alpha, NoV, k, fine, fine_lights);
                const std::string quantity = "albedo " + plain(kAlbedos[k]);
                Readings values;
                values[kNativeDouble] = found[k];
                findings.add({name, name, quantity, place_column({NoV, alpha}), quantity, "",
                              source, NoV, alpha, right, right, values, 0,
                              "the rule of 24 directions"});
            }
        }
    }
}

}  // namespace

Part facets_part() { return {{}, facets}; }

}  // namespace kiln::stability
