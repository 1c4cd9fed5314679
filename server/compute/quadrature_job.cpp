// SPDX-License-Identifier: Apache-2.0
#include "server/compute/quadrature_job.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "server/base/error.h"
#include "server/compute/quadrature.h"
#include "server/compute/replicates.h"
#include "server/compute/texels.h"
#include "server/spec/layouts.h"

namespace kiln {

namespace {

/// Places between two looks at the clock: some milliseconds.
constexpr std::size_t kBlockPlaces = 8192;

/// Means of the fast terms at some places, and how far the last two orders were apart.
struct Means {
    std::vector<double> weight, schlick, deficit;
    std::vector<float> error;
};

class Quadrature {
  public:
    Quadrature(const JobSpec& job, const Plan& plan, Backend& backend, const Control& control)
        : job_(job), plan_(plan), backend_(backend), control_(control), texels_(job) {
        Table& table = outcome_.table;
        table.width = texels_.width();
        table.height = texels_.height();
        for (const Channel& channel : plan.channels) table.channels.push_back(channel.name);
        table.planes.assign(plan.channels.size(), std::vector<float>(table.width * table.height));
        sums_.resize(plan.channels.size());
        for (const Pass& pass : plan.passes) planned_ += pass.places.count();
    }

    Outcome run() {
        const auto start = std::chrono::steady_clock::now();
        for (const Pass& pass : plan_.passes)
            for (std::size_t first = 0; first < pass.places.count(); first += kBlockPlaces)
                run_block(pass, first, std::min(kBlockPlaces, pass.places.count() - first));
        for (const Exact& exact : plan_.exact)
            texels_.fill(outcome_.table.planes[exact.channel], exact.value);
        Report& report = outcome_.report;
        report.run_time_s.integrate =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        report.warnings = plan_.warnings;
        report.status = unsettled_ == 0 ? "converged" : "roundoff_floor";
        if (unsettled_ != 0)
            report.warnings.push_back(std::to_string(unsettled_) +
                                      " places did not reach the tolerance at the highest order");
        report.samples_total = report.work.brdf_evaluations;
        report.samples_per_texel =
            static_cast<std::int64_t>(planned_ == 0 ? 0 : report.samples_total / planned_);
        for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
            ChannelError error{outcome_.table.channels[c], {}, {}, {}, {}, {}, {}};
            error.reference_rms = sums_[c].rms();
            error.reference_max = sums_[c].max;
            report.error.push_back(std::move(error));
        }
        return std::move(outcome_);
    }

  private:
    void run_block(const Pass& pass, std::size_t first, std::size_t count) {
        const Means means = pass.what.material.averaged ? averaged(pass, first, count)
                                                        : directional(pass, first, count);
        for (const Share& share : pass.shares)
            for (std::size_t i = 0; i < count; ++i) {
                const double a = combined(share.a, means, i);
                const Part part = share.part ? share.part(first + i, a, combined(share.b, means, i))
                                             : Part{a, 1, 0, 0};
                const double off = means.error[i] * (std::abs(part.by_a) + std::abs(part.by_b));
                sums_[share.channel].add(off * off, pass.slices.size());
                for (const std::size_t slice : pass.slices)
                    texels_.each(pass.what.material.averaged != 0, slice, first + i,
                                 [&](std::size_t texel) {
                                     float& at = outcome_.table.planes[share.channel][texel];
                                     at = static_cast<float>(at + part.value);
                                 });
            }
        done_ += count;
        control_.progress({static_cast<double>(done_) / planned_places(), {}});
        if (control_.cancelled()) throw Cancelled();
    }

    static double combined(const Combination& c, const Means& means, std::size_t i) {
        return c[kWeight] * means.weight[i] +
               c[kSchlick] * (means.schlick.empty() ? 0 : means.schlick[i]) +
               c[kDeficit] * means.deficit[i];
    }

    Means directional(const Pass& pass, std::size_t first, std::size_t count) {
        std::vector<double> NoV, alpha;
        for (std::size_t i = first; i < first + count; ++i) {
            NoV.push_back(pass.places.NoV(i));
            alpha.push_back(pass.places.alpha(i));
        }
        const int terms = pass.what.material.terms;
        const QuadratureKind kind{job_.masking, (terms & 1 << kSchlick) != 0, job_.precision};
        QuadratureTolerance tolerance;
        if (terms & 1 << kDeficit) tolerance.deficit_relative = 1e-6;
        QuadratureResult found = integrate_quadrature(backend_, kind, NoV, alpha, tolerance);
        count_work(found.evaluations, terms);
        unsettled_ += found.unsettled;
        return {std::move(found.E), std::move(found.B), std::move(found.deficit),
                std::move(found.error)};
    }

    /// E_avg of each roughness, on the host: a line of the table at most.
    Means averaged(const Pass& pass, std::size_t first, std::size_t count) {
        Means means;
        for (std::size_t i = first; i < first + count; ++i) {
            const double deficit = quadrature_average_deficit(pass.places.alpha(i), job_.masking);
            means.weight.push_back(1 - deficit);
            means.deficit.push_back(deficit);
            means.error.push_back(1e-9f);
            control_.progress({static_cast<double>(done_ + i - first) / planned_places(), {}});
            if (control_.cancelled()) throw Cancelled();
        }
        return means;
    }

    double planned_places() const { return static_cast<double>(planned_); }

    void count_work(std::uint64_t evaluations, int terms) {
        Work& work = outcome_.report.work;
        work.brdf_evaluations += evaluations;
        if (terms & 1 << kSchlick) work.fresnel_evaluations += evaluations;
        if (terms & 1 << kDeficit) work.multiscatter_evaluations += evaluations;
    }

    const JobSpec& job_;
    const Plan& plan_;
    Backend& backend_;
    const Control& control_;
    const Texels texels_;
    Outcome outcome_;
    std::vector<ErrorSummary> sums_;
    std::size_t planned_ = 0, done_ = 0, unsettled_ = 0;
};

}  // namespace

Outcome integrate_by_quadrature(const JobSpec& job, const Plan& plan, Backend& backend,
                                const Control& control) {
    return Quadrature(job, plan, backend, control).run();
}

}  // namespace kiln
