// SPDX-License-Identifier: Apache-2.0
#include "client/proof.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "server/compute/fresnel.h"
#include "server/compute/multiscatter.h"
#include "server/spec/axis_value.h"
#include "server/spec/channels.h"

namespace kiln::client {

namespace {

// The full set's own error against quadrature, bilinear lookup included, stays below a tenth of
// what 64 nodes and half floats leave.
constexpr std::int64_t kFullNodes = 256;
// Of lobes that quadrature has no rule for: chan2018. Its samples are not the
// plan's: the same points would hide the same error on both sides.
constexpr std::int64_t kSampledNodes = 128, kSampledMost = 65536;
constexpr double kSampledError = 1e-3;

/// Where a value lies between the nodes of an axis, clamped to its ends as a texture unit does.
struct Between {
    std::size_t first = 0, second = 0;
    double share = 0;  ///< of the second
};
Between between(const Axis& axis, std::int64_t count, double value) {
    if (count == 1) return {};
    const double lo = mapped(axis, axis.lo), hi = mapped(axis, axis.hi);
    const double t = std::clamp((mapped(axis, value) - lo) / (hi - lo), 0.0, 1.0);
    const double at = t * static_cast<double>(count - 1);
    const auto first = std::min(static_cast<std::size_t>(at), static_cast<std::size_t>(count - 2));
    return {first, first + 1, at - static_cast<double>(first)};
}

/// Bilinear lookup, the way a texture unit does it.
double look_up(const BakedTable& baked, std::size_t channel, double NoV, double roughness) {
    const JobSpec& job = baked.job;
    const auto value_of = [&](const Axis& axis) {
        return axis.parameter == Parameter::NoV ? NoV : roughness;
    };
    const Between x = between(job.axes[0], job.resolution[0], value_of(job.axes[0]));
    Between y;
    if (job.axes.size() > 1) y = between(job.axes[1], job.resolution[1], value_of(job.axes[1]));
    const std::vector<float>& plane = baked.table.planes.at(channel);
    const auto texel = [&](std::size_t column, std::size_t row) -> double {
        return plane.at(row * baked.table.width + column);
    };
    const auto along = [&](std::size_t row) {
        return texel(x.first, row) * (1 - x.share) + texel(x.second, row) * x.share;
    };
    return along(y.first) * (1 - y.share) + along(y.second) * y.share;
}

/// What the renderer makes of A and B.
double albedo(double A, double B, double E_avg, rules::Reflectance F, Multiscatter added) {
    const double S = F.f0 * A + F.f90 * B, E = A + B;
    FresnelModel schlick;
    schlick.f0 = {F.f0};
    schlick.f90 = {F.f90};
    switch (added) {
        case Multiscatter::none:
            return S;
        case Multiscatter::turquin:
            return S * turquin_scale(F.f0, E);
        case Multiscatter::kulla_conty:
        case Multiscatter::kulla_conty_linear:
            return S + multiscatter_fresnel(added == Multiscatter::kulla_conty_linear,
                                            fresnel_average(schlick, 0), 1 - E_avg) *
                           (1 - E);
    }
    __builtin_unreachable();
}

class Prover {
  public:
    Prover(const ScenePlan& plan, const std::vector<BakedTable>& tables, const FullSet& full)
        : plan_(plan), tables_(tables), full_(full) {}

    LobeProof prove(const LobePlan& lobe) {
        LobeProof proof{lobe.need.material, lobe.need.lobe, 0, 0, 0, 0};
        double squares = 0;
        for (int i = 0; i < kProofPoints; ++i) {
            // Uniform in the angle, which visits grazing views more often than uniform NoV does.
            const double NoV = std::cos(random() * std::numbers::pi / 2);
            const double roughness = between_ends(lobe.need.roughness);
            double worst = 0;
            for (const Range& f0 : lobe.need.f0) {
                const rules::Reflectance F{between_ends(f0), between_ends(lobe.need.f90)};
                worst = std::max(worst, std::abs(reduced(lobe, NoV, roughness, F) -
                                                 reference(lobe, NoV, roughness, F)));
            }
            squares += worst * worst;
            if (worst <= proof.max) continue;
            proof.max = worst;
            proof.NoV = NoV;
            proof.roughness = roughness;
        }
        proof.rms = std::sqrt(squares / kProofPoints);
        return proof;
    }

  private:
    double random() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
    double between_ends(const Range& range) { return range.lo + (range.hi - range.lo) * random(); }

    double reduced(const LobePlan& lobe, double NoV, double roughness, rules::Reflectance F) const {
        const auto channel = [&](std::size_t c) {
            return look_up(tables_.at(*lobe.table), c, NoV, roughness);
        };
        switch (lobe.reading) {
            case Reading::closed_form:
                return F.f0 + (F.f90 - F.f0) * std::pow(1 - NoV, 5);
            case Reading::base_colour:
                return 1;
            case Reading::all_reflected:  // compared by E, which the table holds
            case Reading::one_channel:
            case Reading::times_colour:
                return channel(0);
            case Reading::two_channels: {
                const double E_avg =
                    lobe.average ? look_up(tables_.at(*lobe.average), 0, NoV, roughness) : 1;
                return albedo(channel(0), channel(1), E_avg, F, lobe.added);
            }
        }
        __builtin_unreachable();
    }

    const BakedTable* full(TableKind kind) const {
        for (std::size_t i = 0; i < full_.kinds.size(); ++i)
            if (full_.kinds[i] == kind) return &full_.tables.at(i);
        return nullptr;
    }

    double reference(const LobePlan& lobe, double NoV, double roughness,
                     rules::Reflectance F) const {
        if (lobe.need.lobe == Lobe::sheen)
            return look_up(*full(TableKind::sheen), 0, NoV, roughness);
        if (lobe.need.lobe == Lobe::diffuse) {
            const BakedTable* diffuse = full(TableKind::diffuse);
            return diffuse != nullptr ? look_up(*diffuse, 0, NoV, roughness) : 1;
        }
        const BakedTable& split = *full(TableKind::specular);
        const BakedTable* average = full(TableKind::average);
        if (lobe.reading == Reading::all_reflected)
            return look_up(split, 0, NoV, roughness) + look_up(split, 1, NoV, roughness);
        return albedo(look_up(split, 0, NoV, roughness), look_up(split, 1, NoV, roughness),
                      average != nullptr ? look_up(*average, 0, NoV, roughness) : 1, F,
                      plan_.options.multiscatter);
    }

    const ScenePlan& plan_;
    const std::vector<BakedTable>& tables_;
    const FullSet& full_;
    std::mt19937_64 engine_{6};  // the same points in every run
};

}  // namespace

FullSet full_set_of(const ScenePlan& plan) {
    PlanOptions fine = plan.options;
    fine.format = ImageFormat::exr;
    fine.pixel = PixelType::float32;
    FullSet full;
    const auto add = [&](TableKind kind, const Range& piece) {
        fine.resolution = kFullNodes;
        JobSpec job = table_job(kind, piece, fine, {});
        const bool sampled = std::any_of(
            job.quantities.begin(), job.quantities.end(),
            [&](Quantity quantity) { return quadrature_lacks(job, quantity).has_value(); });
        if (sampled) {
            fine.resolution = kSampledNodes;
            job = table_job(kind, piece, fine, {});
            job.sample_count = kSampledMost;
            job.target_error = kSampledError;
        } else {
            job.integrator = Integrator::quadrature;
            job.device = DeviceChoice::automatic;
        }
        full.jobs.push_back(std::move(job));
        full.kinds.push_back(kind);
    };
    bool specular = false, sheen = false, diffuse = false;
    for (const MaterialPlan& material : plan.materials)
        for (const LobePlan& lobe : material.lobes) {
            sheen |= lobe.need.lobe == Lobe::sheen;
            diffuse |= lobe.reading == Reading::times_colour;
            specular |= lobe.need.lobe != Lobe::sheen && lobe.need.lobe != Lobe::diffuse;
        }
    const Multiscatter added = plan.options.multiscatter;
    const bool averaged =
        added == Multiscatter::kulla_conty || added == Multiscatter::kulla_conty_linear;
    if (specular) add(TableKind::specular, {0, 1});
    if (specular && averaged) add(TableKind::average, {0, 1});
    if (sheen) add(TableKind::sheen, {kSheenRoughnessLeast, 1});
    if (diffuse) add(TableKind::diffuse, {0, 1});
    return full;
}

std::vector<LobeProof> prove(const ScenePlan& plan, const std::vector<BakedTable>& tables,
                             const FullSet& full) {
    Prover prover(plan, tables, full);
    std::vector<LobeProof> proofs;
    for (const MaterialPlan& material : plan.materials)
        for (const LobePlan& lobe : material.lobes)
            if (lobe.reading != Reading::base_colour) proofs.push_back(prover.prove(lobe));
    return proofs;
}

}  // namespace kiln::client
