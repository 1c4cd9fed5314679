// SPDX-License-Identifier: Apache-2.0
#include "server/worker/measured_parts.h"

#include "server/base/sha256.h"
#include "server/compute/kernel_digest.h"
#include "server/compute/opencl.h"
#include "server/image/image.h"
#include "server/measured/reader.h"
#include "server/spec/spec.h"
#include "server/worker/bounds.h"
#include "server/worker/pixel_losses.h"

namespace kiln {

namespace {

using namespace measured;

/// What the kernels read is made in double on the host, with the C library's functions of angles.
constexpr const char* kNumerics = "host-double";
/// Between two words to whoever waits.
constexpr std::chrono::milliseconds kTellInterval{50}, kSignInterval{500};

std::string key_of(const JobSpec& job, const std::string& numerics) {
    return sha256_hex(image_key(job, numerics) + "/" + std::to_string(kReaderRevision));
}

Table colours_of(const Table& table) {
    return {.width = table.width,
            .height = table.height,
            .channels = {table.channels.begin(), table.channels.begin() + 3},
            .planes = {table.planes.begin(), table.planes.begin() + 3}};
}

}  // namespace

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

Teller::Teller(const Control& control, std::size_t count)
    : control_(control), count_(count), thread_([this] { keep_in_touch(); }) {}

Teller::~Teller() {
    {
        const std::lock_guard lock(mutex_);
        quit_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void Teller::at(std::size_t material, double fraction) {
    {
        const std::lock_guard lock(mutex_);
        sign_ = Clock::now();
        // 1 is what a result says that waits to be stored.
        fraction_ =
            0.999 * (static_cast<double>(material) + fraction) / static_cast<double>(count_);
        if (sign_ - told_ < kTellInterval) return;
        tell();
    }
    if (control_.cancelled()) throw Cancelled();
}

void Teller::tell() {
    told_ = Clock::now();
    control_.progress({.fraction = fraction_, .standard_error_max = {}});
}

void Teller::keep_in_touch() {
    std::unique_lock lock(mutex_);
    while (!quit_) {
        changed_.wait_for(lock, kSignInterval);
        if (!quit_ && Clock::now() - sign_ < kQuietStepMax) tell();
    }
}

Material read_material(const MeasuredMaterial& wanted, const MeasurementSource& measurements,
                       MaterialNote& note) {
    const std::string bytes = measurements(wanted.data);
    try {
        Reading reading = read_measurement(bytes);
        Material material(reading.components.front(), wanted.extrapolation, reading.understood,
                          wanted.phi_in);
        note.format = reading.understood.format;
        note.title = reading.understood.title;
        note.warnings = reading.understood.warnings;
        note.colour = material.colour();
        note.azimuths = material.azimuths();
        note.extrapolation = material.extrapolation();
        return material;
    } catch (const Error& error) {
        throw Error(error.code(), wanted.name + ": " + error.what());
    }
}

Report measured_report(const JobSpec& job, const Engine::Place& place, Clock::time_point start) {
    Report report;
    report.job = job_id(job);
    report.device = place.device;
    report.device.numerics = place.device.numerics == kStrictNumerics
                                 ? kNumerics
                                 : std::string(kNumerics) + ", " + place.device.numerics;
    report.run_time_s.compile = place.compile_s;
    report.run_time_s.integrate = seconds_since(start) - place.compile_s;
    return report;
}

void encode_measured(const JobSpec& job, const JobSpec& kept, const Table& table,
                     const Control& control, Clock::time_point start, Baked& baked) {
    const Clock::time_point encode_start = Clock::now();
    Report& report = baked.report;
    const Metadata metadata = describe(kept, Provenance{.kernel_digest = kernel_digest(),
                                                        .numerics = report.device.numerics,
                                                        .key = key_of(kept, report.device.numerics),
                                                        .standard_error_max = {}});
    Table colours;
    if (job.format == ImageFormat::png) colours = colours_of(table);
    const Table& stored = job.format == ImageFormat::png ? colours : table;
    Encoded encoded =
        encode(stored, job.format, job.pixel, metadata, /*thread_count=*/0, [&control] {
            control.progress({.fraction = 1, .standard_error_max = {}});
            if (control.cancelled()) throw Cancelled();
        });
    report.run_time_s.encode = seconds_since(encode_start);
    report.run_time_s.total = seconds_since(start);
    tell_pixel_losses(report, stored.channels, job.pixel, encoded);
    baked.image_digest = sha256_hex(encoded.bytes);
    baked.image = std::move(encoded.bytes);
    baked.extension = std::move(encoded.extension);
}

}  // namespace kiln
