// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/base/error.h"
#include "server/compute/fresnel.h"
#include "server/compute/quadrature.h"
#include "server/spec/words.h"
#include "server/study/host_albedo.h"
#include "server/study/stability.h"

// What the host adds to the kernels' sums: averages, multiple scattering, couplings.
namespace kiln::stability {

namespace {

/// Values that the host makes in double alone.
void add_average(Findings& findings, const std::string& model, const std::string& row,
                 const std::string& column, double value, Right right, const std::string& source,
                 std::optional<double> alpha = {}) {
    Readings values;
    values[kNativeDouble] = value;
    findings.add({model,
                  model,
                  row,
                  column,
                  "average",
                  "",
                  source,
                  {},
                  alpha,
                  right,
                  right,
                  values,
                  0,
                  "what the closed form leaves out, or 1e-9"});
}

/// 1 - E_avg, which goes to 0 with alpha: its leading terms, and the closed forms at alpha = 1.
void average_deficits(Bench& bench, Findings& findings) {
    const double left = 1 - std::numbers::ln2;
    for (const Masking masking : {Masking::smith_correlated, Masking::smith_separable}) {
        const bool correlated = masking == Masking::smith_correlated;
        const std::string name = "1 - E_avg, " + std::string(to_word(masking));
        const auto add = [&](double alpha, Right right, const char* source) {
            bench.look();
            const double value = bench.average_deficit(masking, alpha);
            add_average(findings, "1 - E_avg", name, "alpha " + plain(alpha), value, right, source,
                        alpha);
        };
        add(0, {0, 0}, "the mirror's limit");
        // alpha^2 (ln(1/alpha) + c): fitted from quadrature to 1e-5 relative at 1e-3; the next term
        // is of the order of alpha^2 less.
        const double constant = correlated ? 0.489235 : 0.540052;
        for (const double alpha : {1e-6, 1e-5, 1e-4, 1e-3}) {
            const double right = alpha * alpha * (std::log(1 / alpha) + constant);
            add(alpha, {right, 2e-5 * right}, "its limit as alpha -> 0");
        }
        const double white = correlated ? 1 - 4.0 / 3 * left : 1 - 4 * left * left;
        add(1, {white, 1e-9}, "closed form at alpha = 1");
    }
}

void fresnel_averages(Bench& bench, Findings& findings) {
    for (const FresnelRow& row : fresnel_rows()) {
        bench.look();
        const FresnelModel& model = row.model;
        const auto value = [&](double u) { return 2 * u * fresnel(model, 0, u); };
        double edge = 0.5;  // of total internal reflection
        if (model.model == Fresnel::dielectric && model.ior[0] < 1)
            edge = std::sqrt((1 - model.ior[0]) * (1 + model.ior[0]));
        Right right{0, 1e-9};
        std::string source = "quadrature in double";
        if (model.model == Fresnel::schlick && model.exponent == 5) {
            right.value = model.f0[0] + (model.f90[0] - model.f0[0]) / 21;
            source = "F0 + (F90 - F0) / 21";
        } else {
            // Grazing angles matter as the square of the cosine.
            right.value = adaptive_integral(value, 0, edge * 1e-3, 1e-13) +
                          adaptive_integral(value, edge * 1e-3, edge, 1e-13) +
                          adaptive_integral(value, edge, 1, 1e-13);
        }
        add_average(findings, "F_avg", "F_avg", row.name, fresnel_average(model, 0), right, source);
    }
}

struct Total {
    std::string model, row;
    JobSpec job;
    /// Of a place, given its exact E; empty where only E's own error is between.
    std::function<double(const Place&, double E)> right;
    bool exact;  ///< what is right holds for the sample means themselves
};

JobSpec total_job(Quantity quantity, FresnelModel fresnel, Multiscatter multiscatter) {
    JobSpec job;
    job.quantities = {quantity};
    job.fresnel = std::move(fresnel);
    job.multiscatter = multiscatter;
    job.sample_count = 1 << 14;
    return job;
}

std::vector<Total> totals() {
    std::vector<Total> all;
    const FresnelModel white{.f0 = {1}, .f90 = {1}}, black{.f0 = {0}, .f90 = {0}},
        nothing{.model = Fresnel::dielectric, .ior = {1}}, glass{.f0 = {0.04}};
    for (const Multiscatter m :
         {Multiscatter::kulla_conty, Multiscatter::kulla_conty_linear, Multiscatter::turquin}) {
        const std::string name(to_word(m));
        const auto job = [&](const FresnelModel& F) {
            return total_job(Quantity::compensated_albedo, F, m);
        };
        all.push_back(
            {name, name + ", F = 1", job(white), [](auto&, double) { return 1.0; }, true});
        all.push_back(
            {name, name + ", F = 0", job(black), [](auto&, double) { return 0.0; }, true});
    }
    for (const Coupling c :
         {Coupling::none, Coupling::half_vector, Coupling::view, Coupling::kelemen})
        for (const double rho : {0.0, 1.0}) {
            const std::string name(to_word(c)), row = name + ", albedo " + plain(rho);
            const auto job = [&](const FresnelModel& F) {
                JobSpec made = total_job(Quantity::total_albedo, F, Multiscatter::none);
                made.coupling = c;
                made.diffuse.albedo = {rho};
                return made;
            };
            const std::string model = "coupling " + name;
            const bool adds = c == Coupling::none, fills = c == Coupling::kelemen;
            all.push_back({model, row + ", F = 1", job(white),
                           [=](auto&, double E) {
                               return adds ? rho + E : fills ? rho + (1 - rho) * E : E;
                           },
                           false});
            all.push_back(
                {model, row + ", ior 1", job(nothing), [=](auto&, double) { return rho; }, true});
            if (c == Coupling::half_vector) continue;
            // At alpha = 0 the lobe is F(NoV).
            all.push_back({model, row + ", F0 0.04", job(glass),
                           [=](const Place& at, double) {
                               const double F = 0.04 + 0.96 * std::pow(1 - at.NoV, 5);
                               return adds ? rho + F : rho + (1 - rho) * F;
                           },
                           true});
        }
    return all;
}

/// Four places of a table of nodes.
struct Corner {
    double NoV[2], alpha[2];
};

class TotalRun {
  public:
    TotalRun(Bench& bench, Findings& findings, const Total& total)
        : bench_(bench), findings_(findings), total_(total) {
        alive_.progress = [&](const Progress&) { bench_.look(); };
    }

    void run(const Corner& corner, const std::array<double, 4>& E) {
        JobSpec job = total_.job;
        job.layout = "custom";
        job.resolution = {2, corner.alpha[0] == corner.alpha[1] ? 1 : 2};
        job.axes = {
            {Parameter::NoV, Mapping::linear, Grid::node, false, corner.NoV[0], corner.NoV[1]},
            {Parameter::alpha, Mapping::linear, Grid::node, false, corner.alpha[0],
             corner.alpha[1]}};
        job.seed = bench_.job().seed;
        std::array<Outcome, kArithmetics> outcomes;
        for (std::size_t a = 0; a < kArithmetics; ++a) {
            job.device = is_opencl(a) ? DeviceChoice::opencl : DeviceChoice::native;
            job.precision = is_double(a) ? Precision::float64 : Precision::float32;
            // In double the host's part of it is the same, and the kernels' has been looked at.
            if (a == kOpenClDouble || (is_opencl(a) && !bench_.has_opencl())) continue;
            outcomes[a] = bench_.engine().run(job, alive_, true);
        }
        const auto places = static_cast<std::size_t>(2 * job.resolution[1]);
        for (std::size_t i = 0; i < places; ++i)
            judge({corner.NoV[i % 2], corner.alpha[i / 2]}, E[i], outcomes, i);
    }

  private:
    void judge(const Place& place, double E, const std::array<Outcome, kArithmetics>& outcomes,
               std::size_t texel) {
        const double right = total_.right(place, E);
        Finding found{"Compensation and couplings",
                      total_.model,
                      total_.row,
                      place_column(place),
                      "albedo",
                      "",
                      "closed form",
                      place.NoV,
                      place.alpha,
                      {},
                      {},
                      {},
                      1};
        double error = 0;
        for (std::size_t a = 0; a < kArithmetics; ++a) {
            if (outcomes[a].table.planes.empty()) continue;
            found.values[a] = outcomes[a].table.planes[0][texel];
            error = std::max<double>(error, outcomes[a].standard_errors[0][texel]);
        }
        // Tables hold floats: half a unit of the last place is 6e-8 of the value in double too.
        const double size = std::max(1.0, std::abs(right));
        const double chance =
            total_.exact ? 0
                         : 7 * error + 8.0 * size / static_cast<double>(total_.job.sample_count);
        found.in_float = {right, chance + 3e-6 * size};
        found.in_double = {right, chance + 1e-7 * size};
        found.limit = total_.exact ? "rounding" : "7 standard errors, unseen events and rounding";
        findings_.add(std::move(found));
    }

    Bench& bench_;
    Findings& findings_;
    const Total& total_;
    Control alive_;
};

}  // namespace

Part averages_part() {
    return {{}, [](Bench& bench, Findings& findings) {
                average_deficits(bench, findings);
                fresnel_averages(bench, findings);
            }};
}

Part couplings_part() {
    return {{}, [](Bench& bench, Findings& findings) {
                const std::vector<Total> all = totals();
                const Corner corners[] = {{{0, 1e-6}, {0, 1e-6}},
                                          {{1e-3, 1}, {0, 1e-6}},
                                          {{0, 1e-6}, {1e-3, 1}},
                                          {{1e-3, 1}, {1e-3, 1}}};
                for (const Corner& corner : corners) {
                    std::array<double, 4> E{};
                    for (std::size_t i = 0; i < 4; ++i)
                        E[i] = quadrature_directional_albedo(corner.NoV[i % 2], corner.alpha[i / 2],
                                                             Masking::smith_correlated);
                    for (const Total& total : all) {
                        // Of a mirror alone: one row of the table.
                        const bool mirror = total.row.ends_with("F0 0.04");
                        if (mirror && corner.alpha[0] != 0) continue;
                        Corner own = corner;
                        if (mirror) own.alpha[1] = own.alpha[0];
                        TotalRun(bench, findings, total).run(own, E);
                    }
                }
            }};
}

}  // namespace kiln::stability
