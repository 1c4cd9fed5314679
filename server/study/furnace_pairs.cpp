// SPDX-License-Identifier: Apache-2.0
#include "server/study/furnace_pairs.h"

#include <cmath>
#include <numbers>
#include <random>

#include "server/base/error.h"
#include "server/study/facet_walks.h"
#include "server/study/reflectance.h"

namespace kiln {

namespace {

Albedos albedos_of(const FurnaceTables& tables, int colour, std::size_t y) {
    Albedos albedos;
    albedos.deficit = tables.row(Quantity::multiscatter_albedo, 0, y);
    albedos.compensated = tables.row(Quantity::compensated_albedo, colour, y);
    if (tables.colours(Quantity::average_albedo) != 0)
        albedos.average_deficit = 1 - tables.value(Quantity::average_albedo, 0, 0, y);
    return albedos;
}

class PairWalk {
  public:
    PairWalk(const JobSpec& job, const FurnaceTables& tables, const Control& control)
        : job_(job), tables_(tables), control_(control), engine_(job.seed) {}

    Pointwise run() {
        const int colours = tables_.colours(Quantity::total_albedo);
        for (std::size_t y = 0; y < tables_.roughnesses(); ++y) {
            for (int colour = 0; colour < colours; ++colour) {
                if (walks_over_facets(job_))
                    walk_facets(colour, y, kWalkedPairs / colours);
                else
                    walk(colour, y, kPairs / colours);
            }
        }
        return found_;
    }

  private:
    void walk(int colour, std::size_t y, int count) {
        const Albedos albedos = albedos_of(tables_, colour, y);
        const double roughness = tables_.roughness(y);
        const Reflectance f(job_, colour, roughness, albedos);
        std::uniform_real_distribution<double> cosine(1e-4, 1), azimuth(0, std::numbers::pi);
        for (int i = 0; i < count; ++i) {
            if (i % kPairsALook == 0) look();
            const Directions d{cosine(engine_), cosine(engine_), std::cos(azimuth(engine_))};
            const double there = f(d), back = f(d.swapped());
            if (std::min(there, back) < found_.least.value)
                found_.least = {std::min(there, back), roughness, d.NoV, d.NoL};
            const double greater = std::max(std::abs(there), std::abs(back));
            // Narrow lobes fall below the least double; 0 beside 0 is the same.
            if (greater < 1e-300) continue;
            const double apart = std::abs(there - back) / greater;
            if (!(apart <= found_.asymmetry.value))
                found_.asymmetry = {apart, roughness, d.NoV, d.NoL};
        }
    }

    void walk_facets(int colour, std::size_t y, int count) {
        const Albedos albedos = albedos_of(tables_, colour, y);
        const double roughness = tables_.roughness(y);
        const Reflectance f(job_, colour, roughness, albedos);
        FacetWalks facets(alpha_from_roughness(roughness), f.albedo(), engine_());
        std::uniform_real_distribution<double> cosine(kWalkedCosineMin, 1),
            azimuth(0, std::numbers::pi);
        for (int i = 0; i < count; ++i) {
            look();
            const Directions d{cosine(engine_), cosine(engine_), std::cos(azimuth(engine_))};
            const auto side = [&](const Directions& from) {
                const double share = f.walked_share(from);
                const WalkedValue found = facets.value(from, kWalks);
                return WalkedValue{f(from) + share * found.value, share * found.standard_error};
            };
            const WalkedValue there = side(d), back = side(d.swapped());
            if (std::min(there.value, back.value) < found_.least.value)
                found_.least = {std::min(there.value, back.value), roughness, d.NoV, d.NoL};
            const double greater = std::max(there.value, back.value);
            // What rounding alone may leave of a black surface.
            const double apart =
                std::max(0.0, std::abs(there.value - back.value) - kReciprocal * greater);
            const double error = std::hypot(there.standard_error, back.standard_error);
            const double deviation = apart > 0 ? apart / error : 0;
            if (!(deviation <= found_.asymmetry.value))
                found_.asymmetry = {deviation, roughness, d.NoV, d.NoL};
            if (greater > 0) found_.relative_errors += error / greater;
            ++found_.walked;
        }
    }

    void look() const {
        control_.progress({1, {}});
        if (control_.cancelled()) throw Cancelled();
    }

    const JobSpec& job_;
    const FurnaceTables& tables_;
    const Control& control_;
    std::mt19937_64 engine_;
    Pointwise found_;
};

}  // namespace

Pointwise look_at_pairs(const JobSpec& job, const FurnaceTables& tables, const Control& control) {
    return PairWalk(job, tables, control).run();
}

}  // namespace kiln
