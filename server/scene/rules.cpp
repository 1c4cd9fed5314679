// SPDX-License-Identifier: Apache-2.0
#include "server/scene/rules.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/scene/bounds.h"

namespace kiln::rules {

namespace {

constexpr Range kCoatF0{0.04, 0.04};  // glTF: the coat's index is 1.5 whatever the base's

/// Numbers that a 32-bit exporter cannot tell apart are one: 0.03 and 0.029999999329447746.
double tidy(double value) { return std::round(value * 1e6) / 1e6; }
Range tidy(const Range& range) { return {tidy(range.lo), tidy(range.hi), range.origin}; }

void add_needs(std::vector<Need>& needs, std::size_t index, const MaterialUse& material) {
    const bool film = material.lobes.has(Lobe::iridescence);
    const auto add = [&](Lobe lobe, const Range& roughness, const ColourRange& f0,
                         const Range& f90) {
        if (material.lobes.has(lobe))
            needs.push_back({lobe,
                             index,
                             tidy(roughness),
                             {tidy(f0[0]), tidy(f0[1]), tidy(f0[2])},
                             tidy(f90),
                             !film || lobe == Lobe::clearcoat});
    };
    constexpr Range kOne{1, 1};
    constexpr ColourRange kCoat{kCoatF0, kCoatF0, kCoatF0};
    add(Lobe::metal, material.roughness, material.metal_f0, kOne);
    add(Lobe::dielectric, material.roughness, material.f0, material.f90);
    add(Lobe::specular_glossiness, material.roughness, material.f0, material.f90);
    add(Lobe::diffuse, material.roughness, {}, {});
    add(Lobe::sheen, material.sheen_roughness, {}, {});
    add(Lobe::clearcoat, material.clearcoat_roughness, kCoat, kOne);
}

}  // namespace

bool reads_tables(const MaterialUse& material) {
    return !material.unlit && material.measured.empty();
}

std::vector<Need> needs_of(const SceneUse& scene) {
    std::vector<Need> needs;
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const MaterialUse& material = scene.materials[i];
        if (reads_tables(material)) add_needs(needs, i, material);
    }
    return needs;
}

std::vector<Need> needs_with(const std::vector<Need>& needs, std::initializer_list<Lobe> lobes) {
    std::vector<Need> found;
    for (const Need& need : needs)
        if (std::find(lobes.begin(), lobes.end(), need.lobe) != lobes.end()) found.push_back(need);
    return found;
}

bool diffuse_needs_table(DiffuseModel model) { return model > DiffuseModel::lambert; }

bool is_mirror(const Range& roughness) { return roughness.lo == 0 && roughness.hi == 0; }

bool is_row(const Range& piece) { return piece.fixed(); }

bool is_part(const Range& piece, double full_lo) {
    return !is_row(piece) && (piece.lo > full_lo || piece.hi < 1);
}

std::size_t equal_tables(std::size_t need_count, std::size_t piece_count) {
    return need_count > piece_count ? need_count - piece_count : 0;
}

std::int64_t rows_of(const Range& piece, std::int64_t rows_full) {
    if (is_row(piece)) return 1;
    const double steps = (piece.hi - piece.lo) * static_cast<double>(rows_full - 1);
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::ceil(steps)) + 1, 2,
                                    std::max<std::int64_t>(rows_full, 2));
}

std::vector<Range> roughness_pieces(std::vector<Range> used, std::int64_t rows_full) {
    std::sort(used.begin(), used.end(), [](const Range& a, const Range& b) {
        return std::pair(a.lo, -a.hi) < std::pair(b.lo, -b.hi);
    });
    std::vector<Range> pieces;
    for (const Range& range : used) {
        if (!pieces.empty() && range.lo <= pieces.back().hi)
            pieces.back().hi = std::max(pieces.back().hi, range.hi);
        else
            pieces.push_back({range.lo, range.hi});
    }
    const auto first = std::find_if(pieces.begin(), pieces.end(), is_row);
    const auto count = std::count_if(pieces.begin(), pieces.end(), is_row);
    if (count < 2) return pieces;
    const auto last = std::find_if(pieces.rbegin(), pieces.rend(), is_row);
    const Range all{first->lo, last->hi};
    if (count <= static_cast<std::ptrdiff_t>(kRowsMax) && count <= rows_of(all, rows_full))
        return pieces;
    pieces.push_back(all);
    return roughness_pieces(std::move(pieces), rows_full);
}

std::optional<Reflectance> one_reflectance(const std::vector<Need>& needs) {
    std::optional<Reflectance> one;
    for (const Need& need : needs) {
        for (const Range& f0 : need.f0) {
            if (!need.f0_known || !f0.fixed() || !need.f90.fixed()) return std::nullopt;
            const Reflectance pair{f0.lo, need.f90.lo};
            if (one && *one != pair) return std::nullopt;
            one = pair;
        }
    }
    return one;
}

double half_quantum(PixelType pixel) {
    switch (pixel) {
        case PixelType::half:  // 10 bits of fraction in [1/2, 1)
            return std::ldexp(1.0, -12);
        case PixelType::float32:
        case PixelType::rgb9e5:  // of measured kinds, which have no such figure
            return std::ldexp(1.0, -25);
        case PixelType::uint8:
            return 0.5 / 255;
        case PixelType::uint16:
            return 0.5 / 65535;
    }
    __builtin_unreachable();
}

double deficit_most(double roughness) {
    // The largest 1 − E over NoV by quadrature, rounded up; it rises with roughness from 0.1086,
    // where it lies at the horizon, to 1 − E = ln 2 at NoV = 1, roughness 1.
    struct Step {
        double roughness, most;
    };
    constexpr std::array<Step, 11> kSteps{{{0.1, 0.1087},
                                           {0.2, 0.1100},
                                           {0.3, 0.1157},
                                           {0.4, 0.1308},
                                           {0.5, 0.1621},
                                           {0.6, 0.2182},
                                           {0.7, 0.3099},
                                           {0.8, 0.4449},
                                           {0.9, 0.5801},
                                           {0.95, 0.6399},
                                           {1.0, 0.6932}}};
    if (roughness == 0) return 0;
    for (const Step& step : kSteps)
        if (roughness <= step.roughness) return step.most;
    return 1;
}

double multiscatter_most(const std::vector<Need>& needs, Multiscatter model) {
    if (model == Multiscatter::none) return 0;
    double most = 0;
    for (const Need& need : needs) {
        for (const Range& range : need.f0) {
            const double F0 = need.f0_known ? range.hi : 1;
            const double F90 = std::max(F0, need.f90.hi);
            // Schlick: F_avg = F0 + (F90 − F0) / 21. Kulla and Conty's factor rises with E_avg
            // towards F_avg² (F_avg in the linear form); Turquin's F0 S (1 − E) / E has
            // S ≤ F90 E.
            const double F_avg = F0 + (F90 - F0) / 21;
            double factor = F_avg * F_avg;
            if (model == Multiscatter::kulla_conty_linear) factor = F_avg;
            if (model == Multiscatter::turquin) factor = F0 * F90;
            most = std::max(most, factor * deficit_most(need.roughness.hi));
        }
    }
    return most;
}

bool compensation_is_invisible(const std::vector<Need>& needs, Multiscatter model,
                               PixelType pixel) {
    return multiscatter_most(needs, model) <= half_quantum(pixel);
}

bool reads_average(Multiscatter model, const std::optional<Reflectance>& one) {
    return (model == Multiscatter::kulla_conty || model == Multiscatter::kulla_conty_linear) &&
           !one;
}

MeasuredUse measured_use(const SceneUse& scene) {
    MeasuredUse use;
    const auto add = [](std::vector<std::string>& list, const std::string& id) {
        if (!id.empty() && std::find(list.begin(), list.end(), id) == list.end())
            list.push_back(id);
    };
    for (const MaterialUse& material : scene.materials) add(use.used, material.measured);
    for (const UnusedMaterial& material : scene.unused)
        if (std::find(use.used.begin(), use.used.end(), material.measured) == use.used.end())
            add(use.unused, material.measured);
    return use;
}

}  // namespace kiln::rules
