// SPDX-License-Identifier: Apache-2.0
#include "server/compute/quadrature_job.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "server/base/error.h"
#include "server/compute/facet_albedos.h"
#include "server/compute/order_map.h"
#include "server/compute/quadrature.h"
#include "server/compute/quadrature_integrals.h"
#include "server/compute/replicates.h"
#include "server/compute/sparse_table.h"
#include "server/compute/stopping.h"
#include "server/compute/texels.h"

namespace kiln {

namespace {

/// Places between two looks at the clock: some milliseconds.
constexpr std::size_t kBlockPlaces = 8192;
/// From here on the places that make the order map are few beside those that it saves an order.
constexpr std::size_t kMappedPlaces = 4096;
/// From this tolerance on the values between some places are interpolated: below, the rounding of
/// float would be weighed against it.
constexpr double kSparseTolerance = 1e-5;

/// Of a diffuse lobe's average, of a float job.
constexpr double kFloatAverage = 1e-7;

/// Of 1 - E where it is asked for, relative.
constexpr double kDeficitTolerance = 1e-6;

/// Means of terms at some places, and how far the last two orders were apart.
struct Means {
    std::array<std::vector<double>, kTermCount> of;
    std::vector<float> error;
};

class Quadrature {
  public:
    Quadrature(const JobSpec& job, const Plan& plan, Backend& backend, ThreadPool& pool,
               double tolerance, const Control& control)
        : job_(job),
          plan_(plan),
          backend_(backend),
          pool_(pool),
          tolerance_(tolerance),
          control_(control),
          texels_(job) {
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
        for (const Pass& pass : plan_.passes) {
            make_maps(pass);
            walked_ = {};
            if (walks(pass)) walk(pass);
            for (std::size_t first = 0; first < pass.places.count(); first += kBlockPlaces)
                run_block(pass, first, std::min(kBlockPlaces, pass.places.count() - first));
        }
        for (const Exact& exact : plan_.exact)
            texels_.fill(outcome_.table.planes[exact.channel], exact.value);
        Report& report = outcome_.report;
        report.run_time_s.integrate =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        report.warnings = plan_.warnings;
        report.status = unsettled_ == 0 ? "converged" : "budget_exhausted";
        const bool beyond_float = job_.target_error && job_.precision == Precision::float32 &&
                                  *job_.target_error < kQuadratureFloatRounding;
        if (beyond_float) {
            report.status = "roundoff_floor";
            report.warnings.push_back("target_error is below what float32 arithmetic leaves, 1e-6");
        }
        if (out_of_time_) {
            report.status = "budget_exhausted";
            report.warnings.push_back(
                "time_budget_s ended the quadrature: places after that stand at its lowest orders");
        }
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
        const Means means = walks(pass)                   ? walked(pass, first, count)
                            : pass.what.material.averaged ? averaged(pass, first, count)
                                                          : directional(pass, first, count);
        const ErrorSummary errors = summary(means.error, pass.slices.size());
        for (const Share& share : pass.shares) {
            const std::vector<double> a = combined(share.a, means, count);
            if (share.part) {
                store_parts(pass, share, means, a, first);
            } else {
                sums_[share.channel].add(errors);
                store(pass, share, a, first);
            }
        }
        if (!walks(pass)) done_ += count;
        stay_in_touch();
    }

    static std::vector<double> combined(const Combination& c, const Means& means,
                                        std::size_t count) {
        std::vector<double> sums;
        for (std::size_t t = 0; t < kTermCount; ++t) {
            const std::vector<double>& mean = means.of[t];
            if (c[t] == 0) continue;
            if (mean.size() != count) throw Error("internal", "a term of the table has no mean");
            if (sums.empty()) {
                sums = mean;
                if (c[t] != 1)
                    for (double& sum : sums) sum *= c[t];
            } else {
                for (std::size_t i = 0; i < count; ++i) sums[i] += c[t] * mean[i];
            }
        }
        sums.resize(count);
        return sums;
    }

    /// Each place once a slice.
    static ErrorSummary summary(const std::vector<float>& errors, std::size_t slices) {
        ErrorSummary all;
        float most = 0;
        for (const float error : errors) {
            all.sum_of_squares += static_cast<double>(error) * error;
            most = std::max(most, error);
        }
        all.sum_of_squares *= static_cast<double>(slices);
        all.max = most;
        all.count = errors.size() * slices;
        return all;
    }

    static bool asks_for_deficit(const Pass& pass) {
        return (pass.what.material.terms & 1 << kDeficit) != 0;
    }

    void store(const Pass& pass, const Share& share, const std::vector<double>& values,
               std::size_t first) {
        if (pass.what.material.averaged) {
            for (const std::size_t slice : pass.slices)
                for (std::size_t i = 0; i < values.size(); ++i)
                    add(pass, share, slice, first + i, values[i]);
            return;
        }
        for (const std::size_t slice : pass.slices) {  // one place a texel, in their order
            float* to = &outcome_.table.planes[share.channel][slice * pass.places.count() + first];
            for (std::size_t i = 0; i < values.size(); ++i)
                to[i] = static_cast<float>(to[i] + values[i]);
        }
    }

    void store_parts(const Pass& pass, const Share& share, const Means& means,
                     const std::vector<double>& a, std::size_t first) {
        const std::vector<double> b = combined(share.b, means, a.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            const Part part = share.part(first + i, a[i], b[i]);
            const double off = means.error[i] * (std::abs(part.by_a) + std::abs(part.by_b));
            sums_[share.channel].add(off * off, pass.slices.size());
            for (const std::size_t slice : pass.slices)
                add(pass, share, slice, first + i, part.value);
        }
    }

    void add(const Pass& pass, const Share& share, std::size_t slice, std::size_t place,
             double value) {
        texels_.each(pass.what.material.averaged != 0, slice, place, [&](std::size_t texel) {
            float& at = outcome_.table.planes[share.channel][texel];
            at = static_cast<float>(at + value);
        });
    }

    /// Orders of a large table's places, for each integral of a pass: in float, where what a
    /// neighbour needs is enough to know. Under a loose tolerance the same for values. In double
    /// every place is compared.
    void make_maps(const Pass& pass) {
        maps_.clear();
        sparse_.clear();
        const bool mapped = !walks(pass) && !pass.what.material.averaged && job_.axes.size() > 1 &&
                            job_.precision == Precision::float32 &&
                            pass.places.count() > kMappedPlaces;
        if (!mapped) return;
        const QuadratureTolerance tolerance = tolerance_of(pass);
        const bool sparse = job_.axes.size() == 2 && tolerance.deficit_relative == 0 &&
                            tolerance.absolute >= kSparseTolerance &&
                            std::min(job_.resolution[0], job_.resolution[1]) >= 4;
        for (const Integral& integral : integrals_of(job_, pass)) {
            if (sparse) {
                sparse_.emplace_back(job_, pass.places, integral.kind, integral.parameters,
                                     tolerance.absolute, asks_for_deficit(pass), backend_);
                continue;
            }
            maps_.push_back(make_order_map(job_, pass.places, integral.kind, integral.parameters,
                                           tolerance, backend_));
            count_work(maps_.back().evaluations, integral.term, pass.what.material.terms);
            unsettled_ += maps_.back().unsettled;
        }
    }

    QuadratureTolerance tolerance_of(const Pass& pass) const {
        const bool single = job_.precision == Precision::float32;
        const QuadratureKind lobe = quadrature_average_kind(pass.what.material);
        const double least = single ? kQuadratureFloatRounding / 2 : 0;
        QuadratureTolerance tolerance{std::max(tolerance_, least), 0};
        if (asks_for_deficit(pass) && integrates_deficit(lobe))
            tolerance.deficit_relative = std::max(kDeficitTolerance, tolerance_);
        return tolerance;
    }

    Means directional(const Pass& pass, std::size_t first, std::size_t count) {
        out_of_time_ = deadline_.passed();
        const bool sparse = !sparse_.empty() && !out_of_time_;
        std::vector<double> NoV, alpha;
        for (std::size_t i = first; !sparse && i < first + count; ++i) {
            NoV.push_back(pass.places.NoV(i));
            alpha.push_back(pass.places.alpha(i));
        }
        // The two lowest orders: each place has a value.
        const QuadratureTolerance tolerance =
            out_of_time_ ? QuadratureTolerance{1, 0} : tolerance_of(pass);
        Means means;
        means.error.assign(count, 0);
        const std::vector<Integral> integrals = integrals_of(job_, pass);
        for (std::size_t k = 0; k < integrals.size(); ++k) {
            const Integral& integral = integrals[k];
            QuadraturePlaces places{NoV, alpha, integral.parameters, {}};
            const bool mapped = !maps_.empty() && !out_of_time_;
            if (mapped) places.steps = std::span(maps_[k].step).subspan(first, count);
            QuadratureResult found =
                sparse ? sparse_[k].take(first, count)
                       : integrate_quadrature(backend_, integral.kind, places, tolerance);
            if (sparse && first + count == pass.places.count())
                leave_out(sparse_[k].interpolated(), pass.places.count());
            count_work(found.evaluations, integral.term, pass.what.material.terms);
            unsettled_ += found.unsettled;
            const float* errors = mapped ? &maps_[k].error[first] : found.error.data();
            for (std::size_t i = 0; i < count; ++i)
                means.error[i] = std::max(means.error[i], errors[i]);
            if (is_diffuse(integral.kind)) {
                means.of[integral.term] = std::move(found.E);
                continue;
            }
            if (integral.term != kWeight) means.of[integral.term] = std::move(found.B);
            means.of[kWeight] = std::move(found.E);
            means.of[kDeficit] = std::move(found.deficit);
        }
        return means;
    }

    /// E_avg, or the average diffuse albedos, of each roughness.
    Means averaged(const Pass& pass, std::size_t first, std::size_t count) {
        std::vector<double> alpha;
        for (std::size_t i = first; i < first + count; ++i) alpha.push_back(pass.places.alpha(i));
        Means means;
        for (const Integral& integral : integrals_of(job_, pass)) {
            const bool matte = is_diffuse(integral.kind);
            // A float holds no more of an albedo; of the deficit it does.
            const bool coarse = matte && job_.precision == Precision::float32;
            const double tolerance = coarse ? std::max(tolerance_, kFloatAverage) : tolerance_;
            means.error.assign(count, static_cast<float>(tolerance));
            QuadratureAverages found =
                quadrature_averages(backend_, integral.kind, integral.parameters, alpha, tolerance,
                                    [this] { stay_in_touch(); });
            count_work(found.evaluations, integral.term, pass.what.material.terms);
            if (matte) {
                means.of[integral.term] = std::move(found.mean);
                continue;
            }
            means.of[kDeficit] = std::move(found.mean);
            for (const double deficit : means.of[kDeficit])
                means.of[kWeight].push_back(1 - deficit);
        }
        return means;
    }

    /// Every place of a pass, as those of one roughness are worked on together.
    void walk(const Pass& pass) {
        std::vector<double> NoV, alpha, rhos;
        for (std::size_t i = 0; i < pass.places.count(); ++i) {
            if (!pass.what.material.averaged) NoV.push_back(pass.places.NoV(i));
            alpha.push_back(pass.places.alpha(i));
        }
        for (const std::size_t term : terms_of(pass))
            rhos.push_back(pass.parameters[kAlbedoParameter + term - kDiffuse]);
        const double exact = tolerance_of(pass).absolute;
        walked_ = facet_albedos({NoV, alpha, rhos}, pool_, [&](double share) {
            stay_in_touch(share * static_cast<double>(alpha.size()));
            out_of_time_ = deadline_.passed();
            return out_of_time_ ? 1 : exact;
        });
        done_ += alpha.size();
        unsettled_ += walked_.unsettled;
        outcome_.report.work.brdf_evaluations += walked_.evaluations;
    }

    static std::vector<std::size_t> terms_of(const Pass& pass) {
        std::vector<std::size_t> terms;
        for (std::size_t term = kDiffuse; term < kDiffuse + 3; ++term)
            if (pass.what.material.terms >> term & 1) terms.push_back(term);
        return terms;
    }

    Means walked(const Pass& pass, std::size_t first, std::size_t count) const {
        Means means;
        const auto part = [&](const auto& all) {
            const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first);
            return std::vector(begin, begin + static_cast<std::ptrdiff_t>(count));
        };
        const std::vector<std::size_t> terms = terms_of(pass);
        for (std::size_t k = 0; k < terms.size(); ++k) means.of[terms[k]] = part(walked_.of[k]);
        means.error = part(walked_.error);
        return means;
    }

    void leave_out(std::size_t interpolated, std::size_t places) {
        outcome_.report.left_out.push_back(
            {"quadrature at " + std::to_string(interpolated) + " of " + std::to_string(places) +
                 " texels",
             "interpolation between the others is within a quarter of target_error of it"});
    }

    void stay_in_touch(double further = 0) {
        control_.progress({(static_cast<double>(done_) + further) / planned_places(), {}});
        if (control_.cancelled()) throw Cancelled();
    }

    double planned_places() const { return static_cast<double>(planned_); }

    void count_work(std::uint64_t evaluations, std::size_t term, int terms) {
        Work& work = outcome_.report.work;
        work.brdf_evaluations += evaluations;
        const bool matte = term >= kDiffuse && term < kTransmitted;
        if (term != kWeight && !matte) work.fresnel_evaluations += evaluations;
        if (terms & 1 << kDeficit) work.multiscatter_evaluations += evaluations;
    }

    const JobSpec& job_;
    const Plan& plan_;
    Backend& backend_;
    ThreadPool& pool_;
    const double tolerance_;
    const Control& control_;
    const Texels texels_;
    Outcome outcome_;
    std::vector<ErrorSummary> sums_;
    std::vector<OrderMap> maps_;
    std::vector<SparseTable> sparse_;
    FacetAlbedos walked_;
    std::size_t planned_ = 0, done_ = 0, unsettled_ = 0;
    const Deadline deadline_{std::chrono::steady_clock::now(), job_.time_budget_s, 1};
    bool out_of_time_ = false;
};

}  // namespace

Outcome integrate_by_quadrature(const JobSpec& job, const Plan& plan, Backend& backend,
                                ThreadPool& pool, double tolerance, const Control& control) {
    return Quadrature(job, plan, backend, pool, tolerance, control).run();
}

}  // namespace kiln
