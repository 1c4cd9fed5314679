// SPDX-License-Identifier: Apache-2.0
#include "server/compute/exactness.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>

#include "server/base/error.h"
#include "server/compute/averages.h"
#include "server/compute/lattice.h"
#include "server/compute/plan.h"
#include "server/compute/quadrature.h"
#include "server/compute/quadrature_job.h"
#include "server/spec/channels.h"
#include "server/spec/words.h"

namespace kiln {

namespace {

/// Tables of at most so many texels are held against quadrature whole: a millisecond.
constexpr std::uint64_t kTexelsAlways = 1024;
/// Else where it costs at most this share of the samples, as does the finer lattice; a node costs
/// 1.6 samples (bench_kernels).
constexpr double kShareOfSamples = 0.1, kSamplesANode = 1.6;
/// A place of ggx_lambert is solved in the time of so many walks.
constexpr std::uint64_t kWalksAPlace = 1000;
/// What float arithmetic reaches, and what double is asked for.
constexpr double kFloatTolerance = 1e-6, kDoubleTolerance = 1e-9;
/// Of the largest standard error: finer would be lost beside it. Lookup errors below 1e-5 are none.
constexpr double kShareOfError = 0.01, kCoarseTolerance = 1e-5;

double largest_standard_error(const Report& report) {
    double largest = 0;
    for (const ChannelError& error : report.error)
        largest = std::max(largest, error.standard_error_max.value_or(0));
    return largest;
}

double tolerance_for(const JobSpec& job, const Report& report) {
    if (job.integrator == Integrator::quadrature) return kFloatTolerance;
    const double least = job.precision == Precision::float64 ? kDoubleTolerance : kFloatTolerance;
    return std::clamp(kShareOfError * largest_standard_error(report), least, kCoarseTolerance);
}

/// Sums of squares over texels that each stand for some.
struct Differences {
    double sum = 0, weight = 0, max = 0;
    std::int64_t texels = 0;

    void add(double difference, double texel_weight) {
        sum += texel_weight * difference * difference;
        weight += texel_weight;
        max = std::max(max, std::abs(difference));
        ++texels;
    }
    void tell(ChannelError& error) const {
        error.reference_rms = std::sqrt(sum / weight);
        error.reference_max = max;
        error.reference_texels = texels;
    }
};

class Check {
  public:
    Check(const JobSpec& job, Outcome& outcome, Backend& native, ThreadPool& pool,
          const Control& control)
        : job_(job), outcome_(outcome), native_(native), pool_(pool) {
        control_.cancelled = control.cancelled;
        control_.progress = [&control](const Progress&) { control.progress({1, {}}); };
        served_ = job;
        served_.quantities.clear();
        for (const Quantity quantity : job.quantities)
            if (const auto why = why_unserved(quantity))
                outcome.report.left_out.push_back(
                    {"the reference of " + std::string(to_word(quantity)), *why});
            else
                served_.quantities.push_back(quantity);
        const auto& asked = served_.quantities;
        walks_ = job.diffuse.model == DiffuseModel::ggx_lambert &&
                 std::any_of(asked.begin(), asked.end(), reads_diffuse);
        tolerance_ = tolerance_for(job, outcome.report);
        served_.precision = tolerance_ < kFloatTolerance ? Precision::float64 : Precision::float32;
    }

    void run() {
        if (!served_.quantities.empty()) {
            const Lattice lattice = affordable_lattice();
            const Table exact = at(lattice.job());
            const bool sampled = job_.integrator == Integrator::monte_carlo;
            const bool whole = sampled && is_cheap();
            if (whole) hold_all(at(served_));
            for (std::size_t c = 0; c < exact.channels.size(); ++c) {
                ChannelError& error = error_of(exact.channels[c]);
                error.reconstruction_max = lattice.reconstruction_max(exact.planes[c]);
                if (sampled && !whole) hold_some(lattice, exact.planes[c], error);
            }
        }
        for (std::size_t c = 0; c < outcome_.table.planes.size(); ++c) {
            ChannelError& error = error_of(outcome_.table.channels[c]);
            if (!error.reconstruction_max)
                error.reconstruction_max =
                    estimated_reconstruction_max(job_, outcome_.table.planes[c]);
        }
    }

  private:
    Table at(const JobSpec& job) const {
        return exact_table(job, tolerance_, native_, pool_, control_);
    }

    std::optional<std::string> why_unserved(Quantity quantity) const {
        if (const auto lack = quadrature_lacks(job_, quantity))
            return "quadrature has no rule for " + *lack;
        if (!is_worth_it(quantity))
            return "quadrature of it costs more than a tenth of the samples";
        return {};
    }

    /// Averages over NoV of a lobe whose azimuth has no closed form take millions of nodes a row:
    /// only where that is little beside what made the table.
    bool is_worth_it(Quantity quantity) const {
        const bool averaged =
            quantity == Quantity::average_albedo ||
            (reads_multiscatter(quantity) && job_.multiscatter >= Multiscatter::kulla_conty &&
             job_.multiscatter != Multiscatter::turquin);
        if (job_.distribution == Distribution::ggx || !averaged) return true;
        constexpr double kNodesARow = 4e6;
        const double nodes = kNodesARow * static_cast<double>(Places::averaged(job_).count());
        return job_.integrator == Integrator::quadrature ||
               nodes * kSamplesANode <=
                   kShareOfSamples * static_cast<double>(outcome_.report.samples_total);
    }

    /// Of one place and channel, by the dearest of the rules that the job needs.
    std::uint64_t nodes_a_place() const {
        const Plan plan = make_plan(served_, [] { return Averages{}; });
        std::uint64_t most = 0;
        for (const KernelKind& kernel : quadrature_kernels(served_, plan)) {
            const auto& kind = std::get<QuadratureKind>(kernel);
            const std::size_t start = quadrature_start(kind, tolerance_);
            std::uint64_t nodes = 0;
            for (const std::size_t step : {start, start + 1})
                nodes += quadrature_evaluations(kind, kQuadratureSteps[step].order);
            most = std::max(most, nodes);
        }
        return most;
    }

    /// Whether quadrature at so many places costs little beside what made the table.
    bool is_affordable(std::uint64_t places) const {
        std::uint64_t nodes = walks_ ? kWalksAPlace : nodes_a_place();
        const std::vector<Channel> channels = channels_of(served_);
        if (std::any_of(channels.begin(), channels.end(),
                        [](const Channel& channel) { return channel.colour != 0; }))
            nodes *= 3;
        return static_cast<double>(places * nodes) * kSamplesANode <=
               static_cast<double>(outcome_.report.samples_total) * kShareOfSamples;
    }

    bool is_cheap() const {
        const std::uint64_t texels = outcome_.table.width * outcome_.table.height;
        return texels <= kTexelsAlways || is_affordable(texels);
    }

    Lattice affordable_lattice() const {
        Lattice fine(served_);
        // What advice said of a table (advice.h) its report says again.
        const bool advised = job_.integrator == Integrator::quadrature;
        if (advised || is_affordable(fine.place_count())) return fine;
        return Lattice(served_, Lattice::kCoarse);
    }

    void hold_all(const Table& exact) {
        for (std::size_t c = 0; c < exact.channels.size(); ++c) {
            const std::vector<float>& plane = plane_of(exact.channels[c]);
            Differences differences;
            for (std::size_t i = 0; i < plane.size(); ++i)
                differences.add(static_cast<double>(plane[i]) - exact.planes[c][i], 1);
            differences.tell(error_of(exact.channels[c]));
        }
    }

    void hold_some(const Lattice& lattice, const std::vector<float>& exact,
                   ChannelError& error) const {
        const std::vector<float>& plane = plane_of(error.quantity);
        Differences differences;
        lattice.each_texel([&](std::size_t place, std::size_t texel, double weight) {
            differences.add(static_cast<double>(plane[texel]) - exact[place], weight);
        });
        differences.tell(error);
    }

    ChannelError& error_of(const std::string& channel) {
        return *std::find_if(outcome_.report.error.begin(), outcome_.report.error.end(),
                             [&](const ChannelError& error) { return error.quantity == channel; });
    }
    const std::vector<float>& plane_of(const std::string& channel) const {
        const auto& names = outcome_.table.channels;
        return outcome_.table.planes[static_cast<std::size_t>(
            std::find(names.begin(), names.end(), channel) - names.begin())];
    }

    const JobSpec& job_;
    Outcome& outcome_;
    Backend& native_;
    ThreadPool& pool_;
    Control control_;
    JobSpec served_;
    bool walks_ = false;  ///< over facets
    double tolerance_ = 0;
};

}  // namespace

Table exact_table(const JobSpec& job, double tolerance, Backend& native, ThreadPool& pool,
                  const Control& control) {
    for (const Quantity quantity : job.quantities)
        if (const auto lack = quadrature_lacks(job, quantity))
            throw Error("no_quadrature", "quadrature has no rule for " + *lack);
    JobSpec exact = job;
    exact.integrator = Integrator::quadrature;
    const Plan plan =
        make_plan(exact, [&] { return exact_average_deficits(exact, native, control); });
    return std::move(integrate_by_quadrature(exact, plan, native, pool, tolerance, control).table);
}

void hold_against_quadrature(const JobSpec& job, Outcome& outcome, Backend& native,
                             ThreadPool& pool, const Control& control) {
    const auto start = std::chrono::steady_clock::now();
    try {
        Check(job, outcome, native, pool, control).run();
    } catch (const Cancelled&) {
        throw;
    } catch (const Error& error) {  // the table stands, what is said of it does not
        outcome.report.warnings.push_back(std::string("not held against quadrature: ") +
                                          error.what());
    }
    outcome.report.run_time_s.reference =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace kiln
