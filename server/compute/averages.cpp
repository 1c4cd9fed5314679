// SPDX-License-Identifier: Apache-2.0
#include "server/compute/averages.h"

#include <algorithm>

#include "server/base/error.h"
#include "server/compute/integrate.h"
#include "server/compute/quadrature.h"

namespace kiln {

namespace {
/// One value serves a whole line of texels, so it may cost more than one of them.
constexpr std::int64_t kAverageSamplesMin = 65536;

/// Of the average albedo by quadrature: where 1 - E is had as a difference, no more is left of it.
double exact(const QuadratureKind& kind) { return integrates_deficit(kind) ? 1e-9 : 1e-8; }
}  // namespace

Averages exact_average_deficits(const JobSpec& job, Backend& native, const Control& control) {
    const Places places = Places::averaged(job);
    std::vector<double> alpha;
    for (std::size_t i = 0; i < places.count(); ++i) alpha.push_back(places.alpha(i));
    const auto between = [&] {
        control.progress({});
        if (control.cancelled()) throw Cancelled();
    };
    const QuadratureKind kind = quadrature_average_kind(lobe_of(job));
    Averages averages;
    averages.deficit = quadrature_averages(native, kind, {}, alpha, exact(kind), between).mean;
    averages.standard_error.assign(places.count(), 0);
    return averages;
}

Averages average_deficits(const JobSpec& job, Backend& native, ThreadPool& pool,
                          const Control& control) {
    const bool cheap = job.distribution == Distribution::ggx;  // its azimuth is in closed form
    if (cheap || job.integrator == Integrator::quadrature)
        return exact_average_deficits(job, native, control);
    const std::size_t rough = roughness_axis(job);
    JobSpec line = job;
    line.quantities = {Quantity::average_albedo};
    line.resolution = {job.resolution[rough]};
    line.axes = {job.axes[rough]};
    line.precision = Precision::float64;
    line.target_error.reset();
    line.time_budget_s.reset();
    line.sample_count = std::max(job.sample_count, kAverageSamplesMin);
    Control alive;  // says that it works, not how much of the job is done
    alive.progress = [&](const Progress&) { control.progress({}); };
    alive.cancelled = control.cancelled;
    const Plan plan = make_plan(line, [] { return Averages{}; });
    const Outcome outcome = integrate(line, plan, native, pool, alive, true);
    Averages averages;
    for (const float E_avg : outcome.table.planes[0])
        averages.deficit.push_back(1 - static_cast<double>(E_avg));
    averages.standard_error.assign(outcome.standard_errors[0].begin(),
                                   outcome.standard_errors[0].end());
    return averages;
}

}  // namespace kiln
