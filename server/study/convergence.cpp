// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "server/base/error.h"
#include "server/compute/points.h"
#include "server/spec/channels.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"
#include "server/study/honest.h"
#include "server/study/studies.h"

// The convergence study: error against run time and samples of every sampler, importance and
// backend, beside quadrature, which is the truth here.
namespace kiln {

namespace {

constexpr std::int64_t kLeastSamples = 32;
/// Seeds of one point of a curve: their spread is what a run more could change.
constexpr std::uint64_t kRuns = 3;
/// Of quadrature in float.
constexpr double kTolerances[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6};

struct Recipe {
    DeviceChoice device = DeviceChoice::native;
    Sampler sampler = Sampler::sobol_owen;
    Importance importance = Importance::vndf;
    auto operator<=>(const Recipe&) const = default;
};

/// One recipe at one sample count, over all its runs.
struct Measured {
    std::int64_t sample_count = 0;
    std::array<double, kRuns> seconds{};
    double error_rms = 0, error_max = 0, standard_error_rms = 0;

    double median() const {
        std::array<double, kRuns> sorted = seconds;
        std::sort(sorted.begin(), sorted.end());
        return sorted[kRuns / 2];
    }
    double least() const { return *std::min_element(seconds.begin(), seconds.end()); }
    double most() const { return *std::max_element(seconds.begin(), seconds.end()); }
};

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

std::string name_of(DeviceChoice device) {
    return device == DeviceChoice::opencl ? "OpenCL" : "native";
}

std::string name_of(const Recipe& recipe) {
    return std::string(to_word(recipe.sampler)) + ", " + std::string(to_word(recipe.importance)) +
           ", " + name_of(recipe.device);
}

/// The exponent p of error ~ samples^p by least squares.
double order_of(const std::vector<Measured>& points) {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (const Measured& point : points) {
        if (point.error_rms <= 0) continue;
        const double a = std::log(static_cast<double>(point.sample_count)),
                     b = std::log(point.error_rms);
        n += 1, x += a, y += b, xx += a * a, xy += a * b;
    }
    return (n * xy - x * y) / (n * xx - x * x);
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
        for (const Recipe& recipe : recipes) measure(recipe, recipes.size());
        report_.samples_total = samples_;
        report_.samples_per_texel = base_.sample_count;
        report_.error.clear();
        report_.trace.clear();
        return {{"Convergence: " + title(), notes_, verdicts(), table(), charts()}, report_};
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
        exact.precision = Precision::float32;
        exact.device = DeviceChoice::native;
        for (const double tolerance : kTolerances) {
            exact.target_error = tolerance;
            Measured& point = quadrature_.emplace_back();
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

    JobSpec job_of(const Recipe& recipe, std::int64_t sample_count, std::uint64_t run) const {
        JobSpec job = base_;
        job.device = recipe.device;
        job.sampler = recipe.sampler;
        job.importance = recipe.importance;
        job.sample_count = sample_count;
        job.seed = base_.seed + run;
        return job;
    }

    void measure(const Recipe& recipe, std::size_t recipe_count) {
        engine_.run(job_of(recipe, kLeastSamples, 0), quiet(), false);  // its program, as above
        for (std::int64_t n = kLeastSamples; n <= base_.sample_count; n *= 2)
            curves_[recipe].push_back(point_of(recipe, n));
        fraction_ += 1 / static_cast<double>(recipe_count);
    }

    Measured point_of(const Recipe& recipe, std::int64_t sample_count) {
        Measured point{sample_count, {}, 0, 0, 0};
        for (std::uint64_t run = 0; run < kRuns; ++run) {
            const Outcome outcome = engine_.run(job_of(recipe, sample_count, run), quiet(), false);
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
        for (const auto& [recipe, points] : curves_) {
            Recipe other = recipe;
            other.device = DeviceChoice::opencl;
            const auto at = curves_.find(other);
            if (at == curves_.end()) continue;
            for (std::size_t i = 0; i < points.size(); ++i)
                apart = std::max(apart, std::abs(points[i].error_rms - at->second[i].error_rms));
        }
        char words[96];
        std::snprintf(words, sizeof words, "their errors differ by %.2g at most", apart);
        return {"OpenCL equals native", apart == 0, true, apart, 0.0, words};
    }

    /// A reported error that is far below the true one misleads; it has no floor of rounding.
    Verdict honest() const {
        constexpr double kFloor = 2e-6;
        double worst = 0;
        std::string where;
        std::size_t count = 0;
        for (const auto& [recipe, points] : curves_)
            for (const Measured& point : points) {
                ++count;
                const double ratio = point.error_rms / (point.standard_error_rms + kFloor);
                if (ratio <= worst) continue;
                worst = ratio;
                where = name_of(recipe) + ", " + std::to_string(point.sample_count) + " samples";
            }
        const double most = honest_ratio(kRuns, kReplicatesMax, count);
        char words[224];
        std::snprintf(words, sizeof words,
                      "the true rms error is at most %.2f x the reported one (%s); of %zu such "
                      "ratios chance leaves %.2f",
                      worst, where.c_str(), count, most);
        return {"reported errors are honest", worst <= most, false, worst, most, words};
    }

    std::vector<Verdict> verdicts() const {
        std::vector<Verdict> found{honest()};
        if (std::any_of(curves_.begin(), curves_.end(), [](const auto& curve) {
                return curve.first.device == DeviceChoice::opencl;
            }))
            found.insert(found.begin(), same_everywhere());
        return found;
    }

    StudyTable table() const {
        StudyTable table;
        table.columns = {"backend",   "sampler",           "importance",   "sample_count",
                         "seconds",   "seconds_least",     "seconds_most", "error_rms",
                         "error_max", "standard_error_rms"};
        for (const auto& [recipe, points] : curves_)
            for (const Measured& p : points)
                table.rows.push_back({std::string(to_word(recipe.device)),
                                      std::string(to_word(recipe.sampler)),
                                      std::string(to_word(recipe.importance)),
                                      static_cast<double>(p.sample_count), p.median(), p.least(),
                                      p.most(), p.error_rms, p.error_max, p.standard_error_rms});
        for (const Measured& q : quadrature_)
            table.rows.push_back({std::string("native"),
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

    using Figure = double Measured::*;

    static Series over_time(const std::string& name, const std::vector<Measured>& points,
                            Figure figure) {
        Series series{name, {}, {}, {}, {}};
        for (const Measured& point : points) {
            series.x.push_back(point.median());
            series.y.push_back(point.*figure);
            series.low.push_back(point.least());
            series.high.push_back(point.most());
        }
        return series;
    }

    LineChart error_over_time(const std::string& title, Figure figure) const {
        LineChart chart{title, "seconds of integration", "error", true, true, {}};
        const auto add = [&](const Recipe& recipe) {
            const auto at = curves_.find(recipe);
            if (at != curves_.end())
                chart.series.push_back(over_time(name_of(recipe), at->second, figure));
        };
        for (const DeviceChoice device : {DeviceChoice::native, DeviceChoice::opencl})
            add({device, Sampler::sobol_owen, Importance::vndf});
        for (const DeviceChoice device : {DeviceChoice::native, DeviceChoice::opencl}) {
            if (chart.series.size() > 3) break;
            add({device, Sampler::random, Importance::vndf});
            add({device, Sampler::hammersley, Importance::ndf});
        }
        chart.series.push_back(over_time("quadrature, native", quadrature_, figure));
        return chart;
    }

    /// Curves of the recipes that `matches`, named by `name`, with their fitted order.
    template <class Matches, class Name>
    LineChart error_over_samples(const std::string& title, Matches matches, Name name) const {
        LineChart chart{title, "samples a texel", "rms error", true, true, {}};
        for (const auto& [recipe, points] : curves_) {
            if (recipe.device != curves_.begin()->first.device || !matches(recipe)) continue;
            char label[96];
            std::snprintf(label, sizeof label, "%s, order %.2f", std::string(name(recipe)).c_str(),
                          order_of(points));
            Series series{label, {}, {}, {}, {}};
            for (const Measured& point : points) {
                series.x.push_back(static_cast<double>(point.sample_count));
                series.y.push_back(point.error_rms);
            }
            chart.series.push_back(std::move(series));
        }
        return chart;
    }

    std::vector<Chart> charts() const {
        const Importance importance = curves_.begin()->first.importance;
        return {error_over_time("Error against run time, rms", &Measured::error_rms),
                error_over_time("Error against run time, largest", &Measured::error_max),
                error_over_samples(
                    "Samplers under " + std::string(to_word(importance)),
                    [&](const Recipe& r) { return r.importance == importance; },
                    [](const Recipe& r) { return to_word(r.sampler); }),
                error_over_samples(
                    "Importances with sobol_owen",
                    [](const Recipe& r) { return r.sampler == Sampler::sobol_owen; },
                    [](const Recipe& r) { return to_word(r.importance); })};
    }

    Engine& engine_;
    const Control& control_;
    JobSpec base_;
    Table truth_;
    std::vector<Measured> quadrature_;
    std::map<Recipe, std::vector<Measured>> curves_;
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
