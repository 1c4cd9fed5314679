// SPDX-License-Identifier: Apache-2.0
#include "server/worker/bake_measured.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "server/base/sha256.h"
#include "server/compute/kernel_digest.h"
#include "server/image/image.h"
#include "server/measured/atlas.h"
#include "server/measured/job_sidecar.h"
#include "server/spec/spec.h"
#include "server/worker/bounds.h"
#include "server/worker/pixel_losses.h"

namespace kiln {

namespace {

using namespace measured;
using Clock = std::chrono::steady_clock;

/// What the kernels read is made in double on the host, with the C library's functions of angles.
constexpr const char* kNumerics = "host-double";
/// Between two words to whoever waits.
constexpr std::chrono::milliseconds kTellInterval{50}, kSignInterval{500};

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

SliceLayout layout_of(const JobSpec& job) {
    const auto size = [](std::int64_t n) { return static_cast<std::size_t>(n); };
    return {.theta_in = job.measured.theta_in,
            .width = size(job.resolution[0]),
            .height = size(job.resolution[1]),
            .gutter = size(job.measured.gutter)};
}

/// Progress of one material among many, and the look for a cancel. Reading a file and integrating
/// its albedos say nothing for a while: a thread beside them gives signs of life, but of no step
/// for longer than kQuietStepMax.
class Teller {
  public:
    Teller(const Control& control, std::size_t count)
        : control_(control), count_(count), thread_([this] { keep_in_touch(); }) {}
    ~Teller() {
        {
            const std::lock_guard lock(mutex_);
            quit_ = true;
        }
        changed_.notify_all();
        thread_.join();
    }
    Teller(const Teller&) = delete;
    Teller& operator=(const Teller&) = delete;

    void at(std::size_t material, double fraction) {
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

  private:
    void tell() {
        told_ = Clock::now();
        control_.progress({.fraction = fraction_, .standard_error_max = {}});
    }
    void keep_in_touch() {
        std::unique_lock lock(mutex_);
        while (!quit_) {
            changed_.wait_for(lock, kSignInterval);
            if (!quit_ && Clock::now() - sign_ < kQuietStepMax) tell();
        }
    }

    const Control& control_;
    const std::size_t count_;
    std::mutex mutex_;
    std::condition_variable changed_;
    Clock::time_point told_{}, sign_ = Clock::now();
    double fraction_ = 0;
    bool quit_ = false;
    std::thread thread_;
};

Material read_material(const MeasuredMaterial& wanted, const MeasurementSource& measurements,
                       MaterialNote& note) {
    Reading reading = read_measurement(measurements(wanted.data));
    try {
        Material material(reading.components.front(), wanted.extrapolation, reading.understood);
        note.format = reading.understood.format;
        note.title = reading.understood.title;
        note.warnings = reading.understood.warnings;
        return material;
    } catch (const Error& error) {
        throw Error(error.code(), wanted.name + ": " + error.what());
    }
}

/// PNG has no channel for where values come from.
Table colours_of(const Table& table) {
    return {.width = table.width,
            .height = table.height,
            .channels = {table.channels.begin(), table.channels.begin() + 3},
            .planes = {table.planes.begin(), table.planes.begin() + 3}};
}

std::string key_of(const JobSpec& job) {
    return sha256_hex(image_key(job, kNumerics) + "/" + std::to_string(kReaderRevision));
}

}  // namespace

Baked bake_measured(Engine& engine, const JobSpec& job, const Control& control,
                    const MeasurementSource& measurements) {
    const Clock::time_point start = Clock::now();
    const std::vector<MeasuredMaterial>& materials = job.measured.materials;
    std::optional<Teller> teller(std::in_place, control, materials.size());
    Atlas atlas(layout_of(job), materials.size());
    std::vector<MaterialNote> notes(materials.size());
    for (std::size_t m = 0; m < materials.size(); ++m) {
        teller->at(m, 0);
        const Material material = read_material(materials[m], measurements, notes[m]);
        atlas.add(material, [&](double fraction) { teller->at(m, fraction); });
        for (std::size_t s = 0; s < atlas.layout().theta_in.size(); ++s)
            notes[m].lookup_error.push_back(
                lookup_error(atlas.layout(), atlas.made(), m, s, material));
    }
    teller.reset();
    Baked baked;
    Report& report = baked.report;
    report.job = job_id(job);
    report.device = {"native", engine.native_name(), kNumerics, {}};
    report.run_time_s.integrate = seconds_since(start);

    const Clock::time_point encode_start = Clock::now();
    const Metadata metadata = describe(job, Provenance{.kernel_digest = kernel_digest(),
                                                       .numerics = kNumerics,
                                                       .key = key_of(job),
                                                       .standard_error_max = {}});
    Table colours;
    if (job.format == ImageFormat::png) colours = colours_of(atlas.made().table);
    const Table& stored = job.format == ImageFormat::png ? colours : atlas.made().table;
    Encoded encoded = encode(stored, job.format, job.pixel, metadata, /*thread_count=*/0, [&] {
        control.progress({.fraction = 1, .standard_error_max = {}});
        if (control.cancelled()) throw Cancelled();
    });
    report.run_time_s.encode = seconds_since(encode_start);
    report.run_time_s.total = seconds_since(start);
    tell_pixel_losses(report, stored.channels, job.pixel, encoded);
    for (std::size_t m = 0; m < materials.size(); ++m)
        for (const std::string& warning : atlas.made().accounts[m].warnings)
            report.warnings.push_back(materials[m].name + ": " + warning);
    baked.sidecar = job_sidecar(job, atlas.layout(), atlas.made(), notes);
    baked.image_digest = sha256_hex(encoded.bytes);
    baked.image = std::move(encoded.bytes);
    baked.extension = std::move(encoded.extension);
    return baked;
}

}  // namespace kiln
