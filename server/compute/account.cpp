// SPDX-License-Identifier: Apache-2.0
#include "server/compute/account.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "server/base/error.h"
#include "server/spec/words.h"

namespace kiln {

namespace {

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

std::string range(double least, double most) {
    return least == most ? number(least) : number(least) + "…" + number(most);
}

}  // namespace

void PlaceRange::add(const Pass& pass, std::size_t place) {
    const double alpha = pass.places.alpha(place);
    ++count;
    alpha_min = std::min(alpha_min, alpha);
    alpha_max = std::max(alpha_max, alpha);
    if (pass.what.material.averaged) return;
    NoV_min = std::min(NoV_min, pass.places.NoV(place));
    NoV_max = std::max(NoV_max, pass.places.NoV(place));
}

void PlaceRange::add(const PlaceRange& other) {
    count += other.count;
    NoV_min = std::min(NoV_min, other.NoV_min);
    NoV_max = std::max(NoV_max, other.NoV_max);
    alpha_min = std::min(alpha_min, other.alpha_min);
    alpha_max = std::max(alpha_max, other.alpha_max);
}

std::string PlaceRange::words() const {
    const std::string where = NoV_min > NoV_max ? "" : "NoV " + range(NoV_min, NoV_max) + ", ";
    return std::to_string(count) + (count == 1 ? " place (" : " places (") + where + "alpha " +
           range(alpha_min, alpha_max) + ")";
}

Account::Account(const JobSpec& job, const Plan& plan, const Control& control,
                 bool standard_error_planes)
    : job_(job), plan_(plan), control_(control), texels_(job) {
    Table& table = outcome_.table;
    table.width = texels_.width();
    table.height = texels_.height();
    for (const Channel& channel : plan.channels) table.channels.push_back(channel.name);
    const std::vector<float> plane(table.width * table.height);
    table.planes.assign(plan.channels.size(), plane);
    if (standard_error_planes) outcome_.standard_errors.assign(plan.channels.size(), plane);
    channels_.resize(plan.channels.size());
    for (const Pass& pass : plan.passes)
        for (const Share& share : pass.shares) ++channels_[share.channel].shares;
    // What several passes make up together has one error: each texel's, once all are in.
    for (ChannelState& channel : channels_)
        if (channel.shares > 1) channel.variances.resize(plane.size());
}

void Account::store(const Pass& pass, std::size_t share, std::size_t place,
                    const Estimate& estimate, Stored& stored) {
    const std::size_t channel = pass.shares[share].channel;
    stored.errors[share].add(estimate.variance, pass.slices.size());
    for (const std::size_t slice : pass.slices)
        texels_.each(pass.what.material.averaged != 0, slice, place,
                     [&](std::size_t texel) { add_texel(channel, texel, estimate); });
}

void Account::add(const Pass& pass, const Stored& stored) {
    suspected.add(stored.suspected);
    for (std::size_t share = 0; share < pass.shares.size(); ++share) {
        ChannelState& channel = channels_[pass.shares[share].channel];
        if (channel.shares == 1) channel.error.add(stored.errors[share]);
    }
}

void Account::add_texel(std::size_t channel, std::size_t texel, const Estimate& estimate) {
    std::vector<double>& variances = channels_[channel].variances;
    double variance = estimate.variance;
    if (!variances.empty()) variance = variances[texel] += variance;
    float& at = outcome_.table.planes[channel][texel];
    at = static_cast<float>(at + estimate.value);
    if (!outcome_.standard_errors.empty())
        outcome_.standard_errors[channel][texel] = static_cast<float>(std::sqrt(variance));
}

void Account::count_work(const Specialisation& what, std::uint64_t samples) {
    Work& work = outcome_.report.work;
    const int terms = what.material.terms;
    work.brdf_evaluations += samples;
    const int per_channel[] = {1 << kSchlick,     1 << kColour,      2 << kColour,     4 << kColour,
                               1 << kTransmitted, 2 << kTransmitted, 4 << kTransmitted};
    for (const int term : per_channel)
        if (terms & term) work.fresnel_evaluations += samples;
    if (terms & 1 << kDeficit) work.multiscatter_evaluations += samples;
}

void Account::count_samples(std::uint64_t samples, std::uint64_t a_texel) {
    outcome_.report.samples_total += samples;
    samples_a_texel_ = std::max(samples_a_texel_, a_texel);
}

void Account::add_trace(std::vector<TraceLevel> levels) {
    if (!levels.empty()) traces_.push_back(std::move(levels));
}

void Account::report_progress(double fraction, std::optional<double> error_max) {
    if (error_max) error_so_far_ = error_max;
    fraction_ = std::clamp(fraction, fraction_, 1.0);
    control_.progress({fraction_, error_so_far_});
    if (control_.cancelled()) throw Cancelled();
}

void Account::fill_errors(bool known) {
    for (std::size_t channel = 0; channel < channels_.size(); ++channel) {
        ChannelError error{outcome_.table.channels[channel], {}, {}, {}, {}, {}, {}};
        ErrorSummary& summary = channels_[channel].error;
        for (const double variance : channels_[channel].variances) summary.add(variance, 1);
        if (known) {
            error.standard_error_rms = summary.rms();
            error.standard_error_max = summary.max;
        }
        outcome_.report.error.push_back(std::move(error));
    }
}

void Account::fill_trace(bool known) {
    std::set<std::uint64_t> counts;
    for (const auto& levels : traces_)
        for (const TraceLevel& level : levels) counts.insert(level.samples);
    for (const std::uint64_t samples : counts) {
        TraceLevel whole;
        for (const auto& levels : traces_) {  // what needed fewer samples stands where it stopped
            auto at = std::upper_bound(
                levels.begin(), levels.end(), samples,
                [](std::uint64_t n, const TraceLevel& level) { return n < level.samples; });
            if (at != levels.begin()) --at;
            whole.elapsed_s += at->elapsed_s;
            whole.error.add(at->error);
        }
        TraceRow row{static_cast<std::int64_t>(samples), whole.elapsed_s, {}, {}};
        if (known) {
            row.standard_error_rms = whole.error.rms();
            row.standard_error_max = whole.error.max;
        }
        outcome_.report.trace.push_back(row);
    }
}

void Account::fill_status() {
    Report& report = outcome_.report;
    const auto warn = [&](const std::string& text) { report.warnings.push_back(text); };
    const bool aims = job_.target_error.has_value();
    report.status = aims ? "converged" : "done";
    if (at_roundoff.count != 0) {
        report.status = "roundoff_floor";
        warn("target_error is below what rounding leaves (" +
             number(rounding_floor(job_.precision)) + "): " + at_roundoff.words() +
             " were sampled down to that");
    }
    if (out_of_time || unconverged.count != 0) {
        report.status = "budget_exhausted";
        std::string text =
            out_of_time ? "time_budget_s ended the sampling" : "sample_count ended the sampling";
        if (unconverged.count != 0)
            text += " before " + unconverged.words() +
                    " reached target_error; the largest bound of an error there is " +
                    number(bound_max) + ", which has to hold at two sample counts in turn";
        warn(text);
    }
    if (suspected.count != 0) {
        report.status = "rare_event_suspected";
        warn("rare events: at " + suspected.words() +
             " the error may be larger than the standard error says; more samples, importance "
             "vndf or integrator quadrature help");
    }
    if (trace_is_flat && unconverged.count != 0) {
        report.status = "rare_event_suspected";
        warn(
            "rare events: the error hardly fell over the last three doublings of the samples; "
            "importance vndf or integrator quadrature help");
    }
    if (at_quantum)
        report.left_out.push_back(
            {"sampling below a quarter of the pixel's quantum",
             "target_error is finer than " + std::string(to_word(job_.pixel)) +
                 " pixels can show: their rounding is at least twice the error that was left"});
}

Outcome Account::finish() {
    Report& report = outcome_.report;
    for (const Exact& exact : plan_.exact)
        texels_.fill(outcome_.table.planes[exact.channel], exact.value);
    report.warnings = plan_.warnings;
    report.samples_per_texel =
        plan_.passes.empty() ? job_.sample_count : static_cast<std::int64_t>(samples_a_texel_);
    report.replicates = replicates;
    report.run_time_s.integrate = integrate_s;
    const bool known = plan_.passes.empty() || replicates > 1;
    if (!known)
        report.warnings.push_back(
            "one sample a texel leaves no replicates to compare: no error can be estimated");
    fill_errors(known);
    fill_trace(known);
    fill_status();
    return std::move(outcome_);
}

}  // namespace kiln
