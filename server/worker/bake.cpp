// SPDX-License-Identifier: Apache-2.0
#include "server/worker/bake.h"

#include <algorithm>
#include <chrono>

#include "server/base/sha256.h"
#include "server/compute/kernel_digest.h"
#include "server/image/image.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"
#include "server/study/draw.h"
#include "server/study/studies.h"

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

/// A quantity without an entry of its own is the encoder's channel that nobody measured: it gets
/// one, so that the quantisation of every stored channel is told.
ChannelError& entry_of(Report& report, const std::string& quantity) {
    for (ChannelError& channel : report.error)
        if (channel.quantity == quantity) return channel;
    ChannelError& channel = report.error.emplace_back();
    channel.quantity = quantity;
    return channel;
}

void tell_pixel_losses(Report& report, const std::vector<std::string>& channels, PixelType pixel,
                       const Encoded& encoded) {
    for (std::size_t c = 0; c < channels.size(); ++c) {
        if (c < encoded.quantisation_max.size())
            entry_of(report, channels[c]).quantisation_max = encoded.quantisation_max[c];
        if (c < encoded.clamped.size() && encoded.clamped[c] != 0)
            report.warnings.push_back(channels[c] + ": " + std::to_string(encoded.clamped[c]) +
                                      " texels lay outside what " + std::string(to_word(pixel)) +
                                      " pixels hold and were clamped to it");
    }
    if (pixel == PixelType::uint8)
        report.warnings.push_back(
            "8-bit pixels hold 256 levels: expect visible banding; 16-bit PNG or half EXR avoids "
            "it");
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
            .study = std::move(made.study)};
}

}  // namespace

std::string report_json(const Baked& baked) {
    const std::string report = to_json(baked.report);
    return baked.study ? with_study(report, *baked.study) : report;
}

std::string image_key(const JobSpec& job, const std::string& numerics) {
    return sha256_hex("kiln/image/1\n" + kernel_digest() + "\n" + numerics + "\n" +
                      std::to_string(kEncoderRevision) + "\n" + canonical(job));
}

Baked bake(Engine& engine, const JobSpec& job, const Control& control) {
    if (job.kind != Kind::lut) return bake_study(engine, job, control);
    const Clock::time_point start = Clock::now();
    Outcome outcome = engine.run(job, control);
    Report& report = outcome.report;

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
            .study = {}};
}

}  // namespace kiln
