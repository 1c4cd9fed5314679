// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "server/base/error.h"
#include "server/compute/points.h"
#include "server/spec/channels.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"
#include "server/study/convergence.h"
#include "server/study/honest.h"
#include "server/study/studies.h"

// The convergence study: error against run time and samples of every sampler, importance and
// backend, beside quadrature, which is the truth here.
namespace kiln {

namespace {

using namespace convergence;

constexpr std::int64_t kLeastSamples = 32;
/// Of quadrature in float.
constexpr double kTolerances[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6};

struct Distance {
    double rms = 0, max = 0;
};

Distance distance(const Table& a, const Table& b) {
    double sum = 0, most = 0;
    std::size_t count = 0;
    for (std::size_t c = 0; c < a.planes.size(); ++c)
        for (std::size_t i = 0; i < a.planes[c].size(); ++i, ++count) {
            const double off = std::abs(static_cast<double>(a.planes[c][i]) - b.planes[c][i]);
            sum += off * off;
            most = std::max(most, off);
        }
    return {std::sqrt(sum / static_cast<double>(count)), most};
}

/// Whether the contract allows the recipe for this job: its one owner says so.
bool is_allowed(const JobSpec& job) {
    try {
        parse_job(canonical(job));
        return true;
    } catch (const InvalidJob&) {
        return false;
    }
}

class Convergence {
  public:
    Convergence(Engine& engine, const JobSpec& job, const Control& control)
        : engine_(engine), control_(control), base_(job) {
        base_.kind = Kind::lut;
        base_.integrator = Integrator::monte_carlo;
        base_.format = ImageFormat::exr;
        base_.pixel = PixelType::float32;
    }

    Studied run() {
        integrate_exactly();
        const std::vector<Recipe> recipes = recipes_to_run();
        for (const DeviceChoice device : devices_) {
            integrate_in_float(device);
            std::uint64_t seed = base_.seed;
            for (const Recipe& recipe : recipes)
                if (recipe.device == device) measure(recipe, recipes.size(), seed);
        }
        report_.samples_total = samples_;
        report_.samples_per_texel = base_.sample_count;
        report_.error.clear();
        report_.trace.clear();
        return {{"Convergence: " + title(), notes_, verdicts(), table(), charts_of(curves_)},
                report_};
    }

  private:
    void integrate_exactly() {
        JobSpec exact = base_;
        exact.integrator = Integrator::quadrature;
        exact.precision = Precision::float64;
        exact.device = DeviceChoice::automatic;
        Outcome outcome = engine_.run(exact, quiet(), false);
        truth_ = std::move(outcome.table);
        report_ = std::move(outcome.report);
    }

    void integrate_in_float(DeviceChoice device) {
        JobSpec exact = base_;
        exact.integrator = Integrator::quadrature;
        exact.precision = Precision::float32;
        exact.device = device;
        engine_.run(exact, quiet(), false);  // its programs, which no point pays for
        for (const double tolerance : kTolerances) {
            exact.target_error = tolerance;
            Measured& point = curves_.quadrature[device].emplace_back();
            for (double& seconds : point.seconds) {
                const Outcome quick = engine_.run(exact, quiet(), false);
                const Distance off = distance(quick.table, truth_);
                seconds = quick.report.run_time_s.integrate;
                point.sample_count = quick.report.samples_per_texel;
                point.error_rms = off.rms;
                point.error_max = off.max;
            }
        }
    }

    /// Control for the runs inside: the study's own progress stays the caller's.
    Control quiet() const {
        return {[this](const Progress&) {
                    control_.progress({fraction_, {}});
                },
                control_.cancelled};
    }

    std::vector<Recipe> recipes_to_run() {
        std::vector<Recipe> found;
        for (const DeviceChoice device : {DeviceChoice::native, DeviceChoice::opencl}) {
            if (base_.device != DeviceChoice::automatic && base_.device != device) continue;
            if (!is_usable(device)) continue;
            devices_.push_back(device);
            for (const std::string_view sampler : words<Sampler>())
                for (const std::string_view importance : words<Importance>()) {
                    const Recipe recipe{device, *from_word<Sampler>(sampler),
                                        *from_word<Importance>(importance)};
                    if (is_allowed(job_of(recipe, kLeastSamples, 0))) found.push_back(recipe);
                }
        }
        return found;
    }

    bool is_usable(DeviceChoice device) {
        JobSpec job = base_;
        job.device = device;
        job.sample_count = kLeastSamples;
        try {
            engine_.run(job, quiet(), false);  // builds the program, so that no curve pays for it
            return true;
        } catch (const Error& error) {
            if (base_.device != DeviceChoice::automatic || device == DeviceChoice::native) throw;
            if (error.code() != "device_unavailable" && error.code() != "device_failed") throw;
            notes_.push_back(std::string("without OpenCL: ") + error.what());
            return false;
        }
    }

    JobSpec job_of(const Recipe& recipe, std::int64_t sample_count, std::uint64_t seed) const {
        JobSpec job = base_;
        job.device = recipe.device;
        job.sampler = recipe.sampler;
        job.importance = recipe.importance;
        job.sample_count = sample_count;
        job.seed = seed;
        return job;
    }

    /// Every run has points of its own: `seed` counts through them, on each device alike.
    void measure(const Recipe& recipe, std::size_t recipe_count, std::uint64_t& seed) {
        engine_.run(job_of(recipe, kLeastSamples, 0), quiet(), false);  // its program, as above
        for (std::int64_t n = kLeastSamples; n <= base_.sample_count; n *= 2, seed += kRuns)
            curves_.sampled[recipe].push_back(point_of(recipe, n, seed));
        fraction_ += 1 / static_cast<double>(recipe_count);
    }

    Measured point_of(const Recipe& recipe, std::int64_t sample_count, std::uint64_t seed) {
        Measured point{sample_count, {}, 0, 0, 0};
        for (std::uint64_t run = 0; run < kRuns; ++run) {
            const JobSpec job = job_of(recipe, sample_count, seed + run);
            const Outcome outcome = engine_.run(job, quiet(), true);
            // Bits of another backend are no runs of their own.
            if (recipe.device == devices_[0]) runs_.push_back(judged_run(job, outcome, truth_));
            const Distance off = distance(outcome.table, truth_);
            point.seconds[run] = outcome.report.run_time_s.integrate;
            point.error_rms += off.rms * off.rms / kRuns;
            point.error_max = std::max(point.error_max, off.max);
            for (const ChannelError& error : outcome.report.error)
                point.standard_error_rms +=
                    error.standard_error_rms.value_or(0) * error.standard_error_rms.value_or(0) /
                    static_cast<double>(kRuns * outcome.report.error.size());
            samples_ += outcome.report.samples_total;
            report_.work.brdf_evaluations += outcome.report.work.brdf_evaluations;
            report_.run_time_s.integrate += outcome.report.run_time_s.integrate;
        }
        point.error_rms = std::sqrt(point.error_rms);
        point.standard_error_rms = std::sqrt(point.standard_error_rms);
        return point;
    }

    std::string title() const {
        std::string text;
        for (const Quantity quantity : base_.quantities)
            text += (text.empty() ? "" : ", ") + std::string(to_word(quantity));
        for (std::size_t i = 0; i < base_.resolution.size(); ++i)
            text += (i == 0 ? " of " : " x ") + std::to_string(base_.resolution[i]);
        return text;
    }

    /// Of recipes that differ in the backend alone.
    Verdict same_everywhere() const {
        double apart = 0;
        for (const auto& [recipe, points] : curves_.sampled) {
            Recipe other = recipe;
            other.device = DeviceChoice::opencl;
            const auto at = curves_.sampled.find(other);
            if (at == curves_.sampled.end()) continue;
            for (std::size_t i = 0; i < points.size(); ++i)
                apart = std::max(apart, std::abs(points[i].error_rms - at->second[i].error_rms));
        }
        char words[96];
        std::snprintf(words, sizeof words, "their errors differ by %.2g at most", apart);
        return {"OpenCL equals native", apart == 0, true, apart, 0.0, words};
    }

    std::vector<Verdict> verdicts() const {
        std::vector<Verdict> found{honest_errors(runs_)};
        if (devices_.size() > 1) found.insert(found.begin(), same_everywhere());
        return found;
    }

    StudyTable table() const {
        StudyTable table;
        table.columns = {"backend",   "sampler",           "importance",   "sample_count",
                         "seconds",   "seconds_least",     "seconds_most", "error_rms",
                         "error_max", "standard_error_rms"};
        for (const auto& [recipe, points] : curves_.sampled)
            for (const Measured& p : points)
                table.rows.push_back({std::string(to_word(recipe.device)),
                                      std::string(to_word(recipe.sampler)),
                                      std::string(to_word(recipe.importance)),
                                      static_cast<double>(p.sample_count), p.median(), p.least(),
                                      p.most(), p.error_rms, p.error_max, p.standard_error_rms});
        for (const auto& [device, points] : curves_.quadrature)
            for (const Measured& q : points)
                table.rows.push_back({std::string(to_word(device)),
                                      std::string("quadrature"),
                                      {},
                                      static_cast<double>(q.sample_count),
                                      q.median(),
                                      q.least(),
                                      q.most(),
                                      q.error_rms,
                                      q.error_max,
                                      {}});
        return table;
    }

    Engine& engine_;
    const Control& control_;
    JobSpec base_;
    Table truth_;
    std::vector<DeviceChoice> devices_;  ///< that the study is of
    Curves curves_;
    std::vector<JudgedRun> runs_;
    std::vector<std::string> notes_{
        "Error: difference from quadrature in double, over all texels and quantities. Whiskers: "
        "the fastest and the slowest of 3 runs, which differ in their seeds too."};
    Report report_;
    std::uint64_t samples_ = 0;
    double fraction_ = 0;
};

}  // namespace

Studied study_convergence(Engine& engine, const JobSpec& job, const Control& control) {
    return Convergence(engine, job, control).run();
}

}  // namespace kiln
