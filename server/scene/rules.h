// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/scene/scene.h"
#include "server/spec/job_spec.h"

/// What may be left out, one small function a rule. Each is true or exact for every renderer that
/// reads tables as the plan's manifest says; none knows of another.
namespace kiln::rules {

/// F0 and F90 of Schlick's term, of one colour channel.
struct Reflectance {
    double f0 = 0, f90 = 1;
    bool operator==(const Reflectance&) const = default;
};

/// What one lobe of one material reads.
struct Need {
    Lobe lobe = Lobe::metal;
    std::size_t material = 0;  ///< position in SceneUse::materials
    Range roughness;
    ColourRange f0{};
    Range f90{1, 1};
    bool f0_known = true;  ///< false where F0 depends on more than the colours (a thin film)
};

/// An unlit material is its colour, and measured data takes the place of lobes: neither reads a
/// table.
bool reads_tables(const MaterialUse& material);

/// Every lobe that a table can serve, material by material, of those that read tables.
std::vector<Need> needs_of(const SceneUse& scene);

/// "No sheen in the scene, no table of sheen": the needs that have one of the lobes.
std::vector<Need> needs_with(const std::vector<Need>& needs, std::initializer_list<Lobe> lobes);

/// Diffuse models whose albedo is their colour at every angle need no table.
bool diffuse_needs_table(DiffuseModel model);

/// At roughness 0 the lobe is a mirror: its albedo is F(NoV) in closed form.
bool is_mirror(const Range& roughness);

/// What of the roughness axis is used: ranges that overlap are one ("equal tables are one"), a
/// value within a range is part of it, one that stands alone is a row. Isolated values become one
/// range where they are more than kRowsMax or than the rows that a range of `rows_full` takes.
std::vector<Range> roughness_pieces(std::vector<Range> used, std::int64_t rows_full);

/// One roughness: a row takes the place of the table.
bool is_row(const Range& piece);

/// The axis runs over a range, and ends before the full one does, which starts at `full_lo`.
bool is_part(const Range& piece, double full_lo);

/// Tables that lobes would have for themselves alone and that are pieces which others read too.
std::size_t equal_tables(std::size_t need_count, std::size_t piece_count);

/// Rows that keep the step of a full axis of `rows_full` nodes over [0, 1]: 1 for a value.
std::int64_t rows_of(const Range& piece, std::int64_t rows_full);

/// The one pair that all colour channels of all needs share, if there is one: then one channel
/// holds F0 A + F90 B.
std::optional<Reflectance> one_reflectance(const std::vector<Need>& needs);

/// Half of the largest step of a pixel type in 0…1.
double half_quantum(PixelType pixel);

/// At least 1 − E(NoV) of GGX under correlated Smith for every NoV and every roughness up to this
/// one.
double deficit_most(double roughness);

/// At least what compensation adds to any of these needs at any NoV.
double multiscatter_most(const std::vector<Need>& needs, Multiscatter model);

/// What compensation adds to these needs is at most half a step of the pixel type.
bool compensation_is_invisible(const std::vector<Need>& needs, Multiscatter model, PixelType pixel);

/// E_avg is read by Kulla and Conty's compensation of tables that hold A and B: where one channel
/// holds a reflectance, the compensation is in it, or, at F = 1, gives back all that is missing.
bool reads_average(Multiscatter model, const std::optional<Reflectance>& one);

/// Ids of measured materials that something uses, each once, and of those that nothing does.
struct MeasuredUse {
    std::vector<std::string> used, unused;
};
MeasuredUse measured_use(const SceneUse& scene);

}  // namespace kiln::rules
