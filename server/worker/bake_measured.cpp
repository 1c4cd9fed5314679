// SPDX-License-Identifier: Apache-2.0
#include "server/worker/bake_measured.h"

#include <optional>

#include "server/base/sha256.h"
#include "server/measured/atlas.h"
#include "server/measured/job_product.h"
#include "server/spec/kinds.h"
#include "server/worker/measured_parts.h"
#include "server/worker/pixel_losses.h"

namespace kiln {

namespace {

using namespace measured;

SliceLayout layout_of(const JobSpec& job) {
    const auto size = [](std::int64_t n) { return static_cast<std::size_t>(n); };
    return {.theta_in = job.measured.theta_in,
            .width = size(job.resolution[0]),
            .height = size(job.resolution[1]),
            .gutter = size(job.measured.gutter),
            .conserve = job.measured.conserve};
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

Baked bake_slices(Engine& engine, const JobSpec& job, const Control& control,
                  const MeasurementSource& measurements) {
    const Clock::time_point start = Clock::now();
    Made work;
    const Engine::Place place =
        engine.run_on(job.device, resampler_kernels(), control,
                      [&](Backend& backend) { work = make(job, control, measurements, backend); });
    const SliceTable& made = work.atlas->made();
    Baked baked;
    baked.report = measured_report(job, place, start);
    baked.report.left_out = work.left_out;
    for (std::size_t m = 0; m < made.accounts.size(); ++m)
        for (const std::string& warning : made.accounts[m].warnings)
            baked.report.warnings.push_back(work.kept.measured.materials[m].name + ": " + warning);
    baked.sidecar = job_sidecar(work.kept, work.atlas->layout(), made, work.notes, work.fitted);
    encode_measured(job, work.kept, made.table, control, start, baked);
    return baked;
}

Baked bake_product(Engine& engine, const JobSpec& job, const Control& control,
                   const MeasurementSource& measurements) {
    const Clock::time_point start = Clock::now();
    std::optional<JobProduct> product;
    const auto make_all = [&](Backend& backend) {
        product.emplace(job);  // afresh where a device failed and another goes on
        const std::vector<MeasuredMaterial>& all = job.measured.materials;
        Teller teller(control, all.size());
        Resampler resampler(&backend);
        for (std::size_t m = 0; m < all.size(); ++m) {
            teller.at(m, 0);
            MaterialNote note;
            const Material material = read_material(all[m], measurements, note);
            teller.at(m, 0.2);
            product->add(material, note, resampler);
        }
        teller.at(all.size(), 0);
    };
    const Engine::Place place = engine.run_on(job.device, resampler_kernels(), control, make_all);
    Baked baked;
    baked.report = measured_report(job, place, start);
    baked.report.warnings = product->warnings();
    baked.sidecar = product->sidecar();
    if (!is_view(job.kind)) {
        encode_measured(job, job, product->table(), control, start, baked);
        return baked;
    }
    const Clock::time_point encode_start = Clock::now();
    baked.image = product->picture();
    baked.extension = "png";
    baked.image_digest = sha256_hex(baked.image);
    baked.report.run_time_s.encode = seconds_since(encode_start);
    baked.report.run_time_s.total = seconds_since(start);
    return baked;
}

}  // namespace

Baked bake_measured(Engine& engine, const JobSpec& job, const Control& control,
                    const MeasurementSource& measurements) {
    return is_sliced(job.kind) ? bake_slices(engine, job, control, measurements)
                               : bake_product(engine, job, control, measurements);
}

}  // namespace kiln
