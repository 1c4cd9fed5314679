// SPDX-License-Identifier: Apache-2.0
// `advise`: the smallest table whose errors stay within a bound.
#include <cstdio>
#include <optional>

#include "client/commands.h"
#include "client/files.h"
#include "client/interrupt.h"
#include "client/json.h"
#include "client/summary.h"
#include "server/compute/native.h"
#include "server/spec/channels.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln::client {

namespace {

constexpr std::size_t kShown = 10;

void print(const std::string& line) { std::printf("%s\n", line.c_str()); }

void refuse_what_quadrature_lacks(const JobSpec& job) {
    std::vector<Problem> problems;
    for (std::size_t i = 0; i < job.quantities.size(); ++i)
        if (const auto lack = quadrature_lacks(job, job.quantities[i]))
            problems.push_back(
                {"/quantities/" + std::to_string(i),
                 "advice takes exact values, and quadrature has no rule for " + *lack});
    if (!problems.empty()) throw InvalidJob(problems);
}

std::vector<std::string> row_of(const Candidate& candidate) {
    std::vector<std::string> row{image_size(candidate.job)};
    std::string mapping;
    for (const Axis& axis : candidate.job.axes)
        mapping += (mapping.empty() ? "" : ", ") + std::string(to_word(axis.parameter)) + " " +
                   std::string(to_word(axis.mapping));
    row.push_back(mapping);
    row.push_back(std::string(to_word(candidate.job.axes[0].grid)));
    row.push_back(std::string(to_word(candidate.job.pixel)));
    row.push_back(format_bytes(candidate.bytes));
    for (const double error : {candidate.reconstruction, candidate.quantisation,
                               candidate.integration, candidate.total()})
        row.push_back(format_error(error));
    return row;
}

void print_table(const std::vector<Candidate>& candidates, double max_error) {
    std::vector<std::vector<std::string>> rows{
        {"size", "axes", "grid", "pixel", "bytes", "bilinear", "rounding", "integration", "total"}};
    for (std::size_t i = 0; i < std::min(kShown, candidates.size()); ++i)
        rows.push_back(row_of(candidates[i]));
    for (const std::string& line : columns(rows)) print(line);
    if (candidates.size() > kShown)
        print("and " + std::to_string(candidates.size() - kShown) + " larger");
    print("");
    print("The smallest within " + format_error(max_error) + ":");
    print(canonical(candidates[0].job));
}

std::string in_words(const Closest& closest) {
    std::string where;
    for (std::size_t a = 0; a < closest.at.size(); ++a) {
        char value[32];
        std::snprintf(value, sizeof value, " %.3g", closest.at[a]);
        where += (a == 0 ? "" : ", ") + std::string(to_word(closest.table.job.axes[a].parameter)) +
                 value;
    }
    const std::vector<std::string> row = row_of(closest.table);
    return "; the closest is " + row[0] + " (" + row[1] + ", " + row[2] + ", " + row[3] +
           "): off by " + format_error(closest.table.total()) + " in " + closest.channel + " at " +
           where;
}

std::string pixels_in_words(ImageFormat format) {
    std::string text = std::string(to_word(format)) + " has ";
    for (const PixelType pixel : advised_pixels(format))
        text += (text.ends_with("has ") ? "" : ", ") + std::string(to_word(pixel));
    return text;
}

/// Why nothing is within a bound. The closest table has the finest pixel type of the job's format.
std::string refusal(const std::optional<Closest>& closest, double max_error) {
    const std::string start = "kiln: no table up to " +
                              std::to_string(*std::rbegin(kAdvisedSizes)) +
                              " texels a side stays within " + format_error(max_error);
    if (!closest) return start;
    const Candidate& table = closest->table;
    if (table.quantisation + table.integration <= max_error) return start + in_words(*closest);
    const std::string pixel(to_word(table.job.pixel));
    std::string why =
        "rounding to " + pixel + " alone is off by " + format_error(table.quantisation);
    if (table.quantisation <= max_error)
        why = "rounding to " + pixel + " (" + format_error(table.quantisation) +
              ") and integration in float32 (" + format_error(table.integration) +
              ") alone are above it";
    if (table.job.pixel != PixelType::float32)
        why += "; pixel types: " + pixels_in_words(table.job.format);
    if (table.job.format != ImageFormat::exr) why += ", " + pixels_in_words(ImageFormat::exr);
    return start + ", nor would a larger one: " + why;
}

}  // namespace

Exit advise(const AdviseOptions& options) {
    const JobSpec job = parse_job(read_job(options.job, options.settings));
    if (job.kind != Kind::lut)
        throw InvalidJob(
            std::vector<Problem>{{"/kind", "advice is on tables of models: kind lut alone"}});
    refuse_what_quadrature_lacks(job);
    const Interrupt interrupt(options.timeout_s);
    const Stop stop(interrupt, options.timeout_s);
    ThreadPool pool(0);
    const auto native = make_native_backend(pool, usable_instruction_sets().front());
    ProgressView view(options.progress);
    Control control;
    control.progress = [&view](const Progress& progress) {
        view.update({"running", progress.fraction, {}});
    };
    control.cancelled = [&stop] { return stop.requested(); };
    std::vector<Candidate> candidates;
    std::optional<Closest> closest;
    try {
        candidates = kiln::advise(job, options.max_error, *native, pool, control, &closest);
    } catch (const Cancelled&) {
        stop.leave();
    }
    view.clear();
    // As a reader of the job will see it: a layout that is Kiln's own is named so again.
    for (Candidate& candidate : candidates) candidate.job = parse_job(canonical(candidate.job));
    if (options.json)
        print(advice_json(candidates, options.max_error));
    else if (!candidates.empty())
        print_table(candidates, options.max_error);
    if (!candidates.empty()) return Exit::done;
    say(refusal(closest, options.max_error));
    return Exit::different;
}

}  // namespace kiln::client
