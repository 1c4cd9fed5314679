// SPDX-License-Identifier: Apache-2.0
#include "client/summary.h"

#include <optional>
#include <vector>

#include "client/terminal.h"
#include "server/spec/channels.h"
#include "server/spec/kinds.h"
#include "server/spec/slice_grid.h"
#include "server/spec/words.h"

namespace kiln::client {

namespace {

struct Column {
    const char* title;
    std::optional<double> ChannelError::*value;
};
/// Measured, at all texels or a lattice of them; quadrature tells a bound of its own instead.
constexpr const char *kOffExact = "off exact rms", *kWithin = "within exact rms";
constexpr Column kColumns[] = {
    {"standard error rms", &ChannelError::standard_error_rms},
    {"max", &ChannelError::standard_error_max},
    {kOffExact, &ChannelError::reference_rms},
    {"max", &ChannelError::reference_max},
    {"bilinear max", &ChannelError::reconstruction_max},
    {"pixel max", &ChannelError::quantisation_max},
};

/// One row a quantity in the job's order; a column that no quantity has a figure for is left out.
std::vector<std::string> error_table(const Report& report, const JobSpec& job) {
    std::vector<const ChannelError*> channels;
    if (is_measured(job.kind))
        for (const ChannelError& channel : report.error) channels.push_back(&channel);
    for (const Channel& expected : channels_of(job))
        for (const ChannelError& channel : report.error)
            if (channel.quantity == expected.name) channels.push_back(&channel);
    std::vector<std::vector<std::string>> rows(channels.size() + 1, {""});
    for (std::size_t i = 0; i < channels.size(); ++i) rows[i + 1][0] = channels[i]->quantity;
    for (const Column& column : kColumns) {
        bool any = false;
        for (const ChannelError* channel : channels) any |= (channel->*column.value).has_value();
        if (!any) continue;
        const bool bound = job.integrator == Integrator::quadrature && column.title == kOffExact;
        rows[0].push_back(bound ? kWithin : column.title);
        for (std::size_t i = 0; i < channels.size(); ++i) {
            const auto value = channels[i]->*column.value;
            rows[i + 1].push_back(value ? format_error(*value) : "-");
        }
    }
    if (rows[0].size() == 1) return {};  // of a view nothing is measured
    return columns(rows);
}

/// What was summed, and on what.
std::string work_of(const Report& report, const JobSpec& job) {
    if (is_measured(job.kind))
        return std::to_string(job.measured.materials.size()) + " measured material(s), ";
    const bool nodes = job.integrator == Integrator::quadrature;
    return std::to_string(report.samples_per_texel) + (nodes ? " nodes" : " samples") +
           " a texel on ";
}

std::string phases(const RunTime& time) {
    std::string text;
    const auto add = [&](const char* name, double seconds) {
        if (seconds >= 5e-4)  // less rounds to nothing beside the total
            text += (text.empty() ? "" : ", ") + std::string(name) + " " + format_seconds(seconds);
    };
    add("queued", time.queued);
    add("compile", time.compile);
    add("integrate", time.integrate);
    add("assemble", time.assemble);
    add("check", time.reference);
    add("encode", time.encode);
    return text.empty() ? "" : " (" + text + ")";
}

}  // namespace

std::string image_size(const JobSpec& job) {
    if (is_measured(job.kind)) {
        const SliceGrid grid = slice_grid(job);
        return format_size(grid.width(), grid.height());
    }
    if (job.kind != Kind::lut) return "";
    std::vector<std::size_t> extent(job.resolution.begin(), job.resolution.end());
    extent.resize(3, 1);
    return format_size(extent[0], extent[1] * extent[2], extent[2]);
}

void summarise(const Report& report, const JobSpec& job, const Written& written) {
    const Terminal terminal = standard_error();
    if (!written.brief) {
        const std::string name = written.output == "-" ? "standard output" : written.output;
        const std::string size = image_size(job);
        say(bold(terminal, printable(name)) + "  " + (size.empty() ? "" : size + " ") +
            std::string(to_word(job.pixel)) + ", " + format_bytes(written.byte_count) +
            (written.where.empty() ? "" : ", from " + printable(written.where)) +
            (written.cached ? ", cached" : ""));
        bool first = true;
        for (const std::string& line : error_table(report, job)) {
            say("  " + (first ? dim(terminal, line) : printable(line)));
            first = false;
        }
        say("  " + work_of(report, job) +
            printable(report.device.backend + ", " + report.device.name) + ": " +
            format_seconds(report.run_time_s.total) + phases(report.run_time_s));
        for (const LeftOut& left : report.left_out)
            say("  left out: " + printable(left.what) + " (" + printable(left.why) + ")");
    }
    const std::string head = written.brief ? "kiln: " : "  ";
    if (report.device.fallback) say(head + "fallback: " + printable(*report.device.fallback));
    for (const std::string& warning : report.warnings) say(head + "warning: " + printable(warning));
}

}  // namespace kiln::client
