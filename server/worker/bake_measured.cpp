// SPDX-License-Identifier: Apache-2.0
#include "server/worker/bake_measured.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "server/base/sha256.h"
#include "server/compute/kernel_digest.h"
#include "server/compute/opencl.h"
#include "server/image/image.h"
#include "server/measured/atlas.h"
#include "server/measured/fits.h"
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
            .gutter = size(job.measured.gutter),
            .conserve = job.measured.conserve};
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

std::string key_of(const JobSpec& job, const std::string& numerics) {
    return sha256_hex(image_key(job, numerics) + "/" + std::to_string(kReaderRevision));
}

/// What was made of a job's measurements.
struct Made {
    JobSpec kept;  ///< the job of what the image holds
    std::optional<Atlas> atlas;
    std::vector<MaterialNote> notes;
    std::vector<FittedMaterial> fitted;
    std::vector<kiln::LeftOut> left_out;
};

/// Takes the materials that parameters stand for out of an atlas; it keeps one cell at least.
void fit_materials(const JobSpec& job, const MeasurementSource& measurements, Backend& backend,
                   Teller& teller, Made& made) {
    made.kept = job;
    if (!job.measured.fit_error_max) return;
    std::vector<MeasuredMaterial> kept;
    Resampler resampler(&backend);
    const std::vector<MeasuredMaterial>& all = job.measured.materials;
    for (std::size_t m = 0; m < all.size(); ++m) {
        teller.at(m, 0);
        MaterialNote note;
        const LobeTables tables = make_lobe_tables(read_material(all[m], measurements, note));
        const auto fit = offered(tables, *job.measured.fit_error_max, resampler);
        const bool last = m + 1 == all.size() && kept.empty();
        const bool leave = fit && job.kind == Kind::atlas && !last;
        if (fit) made.fitted.push_back({all[m], *fit, leave});
        if (!leave)
            kept.push_back(all[m]);
        else
            made.left_out.push_back(
                {all[m].name, "GGX over a diffuse base is within " + in_words(fit->error_worst) +
                                  " of it at its worst incidence, at most " +
                                  in_words(*job.measured.fit_error_max) +
                                  " was asked for: its parameters are in the side-car"});
    }
    made.kept.measured.materials = std::move(kept);
    // Of what is left the image is made as if it alone had been asked for.
    if (!made.left_out.empty()) made.kept.measured.fit_error_max.reset();
}

Made make(const JobSpec& job, const Control& control, const MeasurementSource& measurements,
          Backend& backend) {
    Made made;
    const std::size_t count = job.measured.materials.size();
    const std::size_t fits = job.measured.fit_error_max ? count : 0;
    Teller teller(control, fits + count);
    fit_materials(job, measurements, backend, teller, made);
    const std::vector<MeasuredMaterial>& materials = made.kept.measured.materials;
    made.atlas.emplace(layout_of(job), materials.size(), &backend);
    made.notes.resize(materials.size());
    Atlas& atlas = *made.atlas;
    for (std::size_t m = 0; m < materials.size(); ++m) {
        teller.at(fits + m, 0);
        const Material material = read_material(materials[m], measurements, made.notes[m]);
        atlas.add(material, [&](double fraction) { teller.at(fits + m, fraction); });
        for (std::size_t s = 0; s < atlas.layout().theta_in.size(); ++s)
            made.notes[m].lookup_error.push_back(
                lookup_error(atlas.layout(), atlas.made(), m, s, material));
    }
    return made;
}

Encoded encode_atlas(const JobSpec& job, const SliceTable& made, const Metadata& metadata,
                     const Control& control, std::vector<std::string>& channels) {
    Table colours;
    if (job.format == ImageFormat::png) colours = colours_of(made.table);
    const Table& stored = job.format == ImageFormat::png ? colours : made.table;
    channels = stored.channels;
    return encode(stored, job.format, job.pixel, metadata, /*thread_count=*/0, [&] {
        control.progress({.fraction = 1, .standard_error_max = {}});
        if (control.cancelled()) throw Cancelled();
    });
}

}  // namespace

Baked bake_measured(Engine& engine, const JobSpec& job, const Control& control,
                    const MeasurementSource& measurements) {
    const Clock::time_point start = Clock::now();
    Made work;
    const Engine::Place place =
        engine.run_on(job.device, resampler_kernels(), control,
                      [&](Backend& backend) { work = make(job, control, measurements, backend); });
    const SliceTable& made = work.atlas->made();
    Baked baked;
    Report& report = baked.report;
    report.job = job_id(job);
    report.device = place.device;
    report.device.numerics = place.device.numerics == kStrictNumerics
                                 ? kNumerics
                                 : std::string(kNumerics) + ", " + place.device.numerics;
    report.left_out = work.left_out;
    report.run_time_s.compile = place.compile_s;
    report.run_time_s.integrate = seconds_since(start) - place.compile_s;

    const Clock::time_point encode_start = Clock::now();
    const Metadata metadata =
        describe(work.kept, Provenance{.kernel_digest = kernel_digest(),
                                       .numerics = report.device.numerics,
                                       .key = key_of(work.kept, report.device.numerics),
                                       .standard_error_max = {}});
    std::vector<std::string> channels;
    Encoded encoded = encode_atlas(job, made, metadata, control, channels);
    report.run_time_s.encode = seconds_since(encode_start);
    report.run_time_s.total = seconds_since(start);
    tell_pixel_losses(report, channels, job.pixel, encoded);
    for (std::size_t m = 0; m < made.accounts.size(); ++m)
        for (const std::string& warning : made.accounts[m].warnings)
            report.warnings.push_back(work.kept.measured.materials[m].name + ": " + warning);
    baked.sidecar = job_sidecar(work.kept, work.atlas->layout(), made, work.notes, work.fitted);
    baked.image_digest = sha256_hex(encoded.bytes);
    baked.image = std::move(encoded.bytes);
    baked.extension = std::move(encoded.extension);
    return baked;
}

}  // namespace kiln
