// SPDX-License-Identifier: Apache-2.0
#include "server/worker/bake.h"

#include <algorithm>
#include <chrono>

#include "server/base/sha256.h"
#include "server/compute/kernel_digest.h"
#include "server/image/image.h"
#include "server/spec/channels.h"
#include "server/spec/kinds.h"
#include "server/spec/layouts.h"
#include "server/spec/spec.h"
#include "server/study/draw.h"
#include "server/study/studies.h"
#include "server/worker/bake_measured.h"
#include "server/worker/pixel_losses.h"

namespace kiln {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

std::optional<double> largest_standard_error(const Report& report) {
    std::optional<double> largest;
    for (const ChannelError& channel : report.error)
        if (channel.standard_error_max)
            largest = std::max(largest.value_or(0), *channel.standard_error_max);
    return largest;
}

/// What the table's program will read from the texels: its shader adds the rest.
void store_as_read(const JobSpec& job, Table& table) {
    const std::vector<Channel> channels = channels_of(job);
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const double added = added_by_shader(job, channels[c].quantity);
        if (added == 0) continue;
        for (float& value : table.planes[c]) value = static_cast<float>(value - added);
    }
}

Baked bake_study(Engine& engine, const JobSpec& job, const Control& control) {
    const Clock::time_point start = Clock::now();
    Studied made = make_study(engine, job, control);
    const Clock::time_point encode_start = Clock::now();
    std::string picture = draw_png(made.study);
    made.report.run_time_s.encode = seconds_since(encode_start);
    made.report.run_time_s.total = seconds_since(start);
    made.report.job = job_id(job);
    std::string digest = sha256_hex(picture);
    return {.image = std::move(picture),
            .extension = "png",
            .report = std::move(made.report),
            .image_digest = std::move(digest),
            .study = std::move(made.study),
            .sidecar = {}};
}

}  // namespace

std::string report_json(const Baked& baked) {
    const std::string report = to_json(baked.report);
    if (baked.study) return with_study(report, *baked.study);
    if (baked.sidecar.empty()) return report;
    return report.substr(0, report.size() - 1) + ",\"measured\":" + baked.sidecar + "}";
}

std::string image_key(const JobSpec& job, const std::string& numerics) {
    return sha256_hex("kiln/image/1\n" + kernel_digest() + "\n" + numerics + "\n" +
                      std::to_string(kEncoderRevision) + "\n" + canonical(job));
}

Baked bake(Engine& engine, const JobSpec& job, const Control& control,
           const MeasurementSource& measurements) {
    if (is_measured(job.kind)) return bake_measured(engine, job, control, measurements);
    if (job.kind != Kind::lut) return bake_study(engine, job, control);
    const Clock::time_point start = Clock::now();
    Outcome outcome = engine.run(job, control);
    Report& report = outcome.report;
    store_as_read(job, outcome.table);

    const Clock::time_point encode_start = Clock::now();
    const std::optional<double> standard_error_max = largest_standard_error(report);
    const Metadata metadata =
        describe(job, Provenance{.kernel_digest = kernel_digest(),
                                 .numerics = report.device.numerics,
                                 .key = image_key(job, report.device.numerics),
                                 .standard_error_max = standard_error_max});
    const auto stay_in_touch = [&] {
        control.progress({.fraction = 1, .standard_error_max = standard_error_max});
        if (control.cancelled()) throw Cancelled();
    };
    Encoded encoded =
        encode(outcome.table, job.format, job.pixel, metadata, /*thread_count=*/0, stay_in_touch);
    report.run_time_s.encode = seconds_since(encode_start);
    report.run_time_s.total = seconds_since(start);
    report.job = job_id(job);
    tell_pixel_losses(report, outcome.table.channels, job.pixel, encoded);

    std::string digest = sha256_hex(encoded.bytes);
    return {.image = std::move(encoded.bytes),
            .extension = std::move(encoded.extension),
            .report = std::move(report),
            .image_digest = std::move(digest),
            .study = {},
            .sidecar = {}};
}

}  // namespace kiln
