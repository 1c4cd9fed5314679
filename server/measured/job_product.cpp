// SPDX-License-Identifier: Apache-2.0
#include "server/measured/job_product.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/base/error.h"
#include "server/measured/lobe_sampler.h"
#include "server/measured/views.h"
#include "server/spec/kinds.h"
#include "server/spec/slice_grid.h"

namespace kiln::measured {
namespace {

using json = nlohmann::ordered_json;

json albedo_json(const Material::Albedo& albedo) {
    return {{"rgb", albedo.value}, {"extrapolated_share", albedo.extrapolated}};
}

json companion_words(const JobSpec& job) {
    const std::string width = std::to_string(job.resolution[0]);
    return {
        {"column", "NoV * " + width + ", in texels: texel x is NoV = (x + 0.5) / " + width},
        {"row", "index of the material + 0.5"},
        {"energy", "E(NoV) = R, G, B: what leaves towards the view under even light of 1"},
        {"split_sum",
         "diffuse * (mean of the environment over the cosine about the normal) + max(0, E(NoV) "
         "- diffuse) * (environment prefiltered for GGX of alpha, about the mirror direction)"}};
}

json sampling_words(const JobSpec& job) {
    const std::string n = std::to_string(job.resolution[0]), m = std::to_string(job.resolution[1]);
    return {{"ring",
             "the first row k of the slice whose R is above xi_1; s = (xi_1 - R of the "
             "row before) / (R - R of the row before)"},
            {"cell", "the first column c of that row whose G is above xi_2; t likewise"},
            {"phi_d", "2 pi (c + t) / " + n},
            {"theta_d", "2 asin(h v^2), v^4 = (k^4 + s ((k + 1)^4 - k^4)) / " + m +
                            "^4, h = sin(atan2(cos theta_in, sin theta_in cos phi_d) / 2)"},
            {"view",
             "v = S^T d, d of theta_d and phi_d, S = ((-c, 0, -s), (0, -1, 0), (-s, 0, "
             "c)), c and s of theta_in; the light's azimuth is 0"},
            {"pdf", "B / (4 pi h^2 ((k + 1)^4 - k^4) / " + m + "^4 / " + n +
                        "), per solid angle of the view"}};
}

}  // namespace

struct JobProduct::State {
    const JobSpec& job;
    SliceGrid grid;
    Table table;
    Picture picture;
    std::vector<Words> words;
    json materials = json::array();
    std::vector<std::string> warnings;

    explicit State(const JobSpec& of) : job(of), grid(slice_grid(of)) {
        if (is_view(job.kind)) {
            picture = {grid.width(), grid.height(), {}};
            picture.rgb.resize(3 * picture.width * picture.height);
            return;
        }
        table.width = grid.width();
        table.height = grid.height();
        table.channels = {"R", "G", "B", "extrapolated"};
        if (job.kind == Kind::sampling) table.channels = {"ring_sum", "cell_sum", "probability"};
        table.planes.assign(table.channels.size(), std::vector<float>(table.width * table.height));
    }

    void add_companion(json& entry, const LobeTables& tables, Resampler& resampler) {
        const Companion made = companion_of(tables, table.width, resampler);
        const std::size_t row = materials.size();
        for (std::size_t k = 0; k < table.planes.size(); ++k)
            std::copy(made.table.planes[k].begin(), made.table.planes[k].end(),
                      table.planes[k].begin() + static_cast<std::ptrdiff_t>(row * table.width));
        const Fit fit = fit_model(FitModel::ggx_diffuse, tables, resampler);
        json split = fit_json(fit);
        split["roughness"] = std::sqrt(fit.width);
        entry["row"] = row;
        entry["split_sum"] = std::move(split);
    }

    void add_sampling(json& entry, const LobeTables& tables, Resampler& resampler) {
        const auto spokes = static_cast<std::size_t>(job.resolution[0]);
        const auto rings = static_cast<std::size_t>(job.resolution[1]);
        entry["slices"] = json::array();
        const auto albedos = resampler.albedos(tables, job.measured.theta_in);
        for (std::size_t s = 0; s < job.measured.theta_in.size(); ++s) {
            const double theta_in = job.measured.theta_in[s];
            const LobeSampler sampler(tables, theta_in, resampler, rings, spokes);
            const SliceGrid::Place at = grid.place(s, 0, 0);
            for (std::size_t ring = 0; ring < rings; ++ring)
                for (std::size_t cell = 0; cell < spokes; ++cell) {
                    const std::size_t n = (at.y + ring) * table.width + at.x + cell;
                    table.planes[0][n] = static_cast<float>(sampler.cells().row_sum(ring));
                    table.planes[1][n] = static_cast<float>(sampler.cells().cell_sum(ring, cell));
                    table.planes[2][n] =
                        static_cast<float>(sampler.cells().probability(ring, cell));
                }
            entry["slices"].push_back({{"theta_in_deg", theta_in},
                                       {"x", at.x},
                                       {"y", at.y},
                                       {"directional_albedo", albedo_json(albedos[s])}});
        }
        add_normals(entry, tables, resampler);
    }

    /// For samplers of visible normals.
    static void add_normals(json& entry, const LobeTables& tables, Resampler& resampler) {
        entry["normals"] = nullptr;
        try {
            const NormalDistribution found = normals_of(tables, resampler);
            json degrees = json::array();
            for (const double theta : found.theta) degrees.push_back(theta / kDegree);
            entry["normals"] = {
                {"theta_h_deg", degrees}, {"d", found.value}, {"f0", 4 * found.eigenvalue}};
        } catch (const Error& error) {
            entry["warnings"].push_back(std::string("no distribution of normals: ") + error.what());
        }
    }

    void add_view(json& entry, const Material& material, const std::string& name,
                  const LobeTables& tables, Resampler& resampler) {
        const Frame frame{grid.cell_width, grid.cell_height, name};
        View view;
        if (job.kind == Kind::lobe_view) {
            const double theta_in = job.measured.theta_in.front();
            view = lobe_view(tables, theta_in, frame, resampler);
            entry["theta_in_deg"] = theta_in;
            entry["f_max"] = view.f_max;
            entry["lengths"] = view.cube_root ? "cube root of f" : "f";
            const auto albedo = resampler.albedos(tables, std::array{theta_in}).front();
            entry["directional_albedo"] = albedo_json(albedo);
            if (const std::string beyond = beyond_measured(material, theta_in); !beyond.empty())
                entry["warnings"].push_back(beyond);
        } else {
            view = sphere_view(tables, frame, resampler);
        }
        if (materials.empty())  // cells that no material takes go on from the first one's corner
            for (std::size_t n = 0; n < picture.rgb.size(); ++n)
                picture.rgb[n] = view.picture.rgb[n % 3];
        const SliceGrid::Place at = grid.place(0, materials.size(), 0);
        for (std::size_t y = 0; y < frame.height; ++y)
            std::copy_n(view.picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * y * frame.width),
                        3 * frame.width,
                        picture.rgb.begin() +
                            static_cast<std::ptrdiff_t>(3 * ((at.y + y) * picture.width + at.x)));
        for (Words& one : view.words) {
            one.x += static_cast<double>(at.x);
            one.y += static_cast<double>(at.y);
            words.push_back(std::move(one));
        }
        entry["x"] = at.x;
        entry["y"] = at.y;
    }

    json document() const {
        json made = sidecar_head(job);
        made["image"] = {{"width", grid.width()}, {"height", grid.height()}};
        made["conserved"] = job.measured.conserve;
        if (is_view(job.kind))
            made["cell"] = {{"width", grid.cell_width}, {"height", grid.cell_height}};
        if (!is_view(job.kind)) made["channels"] = table.channels;
        if (job.kind == Kind::companion) made["shader"] = companion_words(job);
        if (job.kind == Kind::sampling) {
            made["slice"] = {
                {"width", grid.cell_width}, {"height", grid.cell_height}, {"gutter", 0}};
            made["theta_in_deg"] = job.measured.theta_in;
            made["shader"] = sampling_words(job);
        }
        made["materials"] = materials;
        return made;
    }
};

JobProduct::JobProduct(const JobSpec& job) : state_(std::make_unique<State>(job)) {}
JobProduct::~JobProduct() = default;

void JobProduct::add(const Material& material, const MaterialNote& note, Resampler& resampler) {
    State& state = *state_;
    const std::size_t index = state.materials.size();
    const MeasuredMaterial& wanted = state.job.measured.materials[index];
    LobeTables tables = make_lobe_tables(material);
    if (state.job.measured.conserve) conserve(tables, resampler);
    json entry = {{"index", index}, {"name", wanted.name}, {"warnings", json::array()}};
    if (state.job.kind == Kind::companion) state.add_companion(entry, tables, resampler);
    if (state.job.kind == Kind::sampling) state.add_sampling(entry, tables, resampler);
    if (is_view(state.job.kind)) state.add_view(entry, material, wanted.name, tables, resampler);
    entry["average_albedo"] = albedo_json(resampler.average_albedo(tables));
    for (const json& warning : entry["warnings"])
        state.warnings.push_back(wanted.name + ": " + warning.get<std::string>());
    add_material(entry, wanted, note);
    state.materials.push_back(std::move(entry));
}

const Table& JobProduct::table() const { return state_->table; }
std::string JobProduct::picture() const { return png_of(state_->picture, state_->words); }
std::string JobProduct::sidecar() const {
    return state_->document().dump(-1, ' ', /*ensure_ascii=*/true);
}
const std::vector<std::string>& JobProduct::warnings() const { return state_->warnings; }

}  // namespace kiln::measured
