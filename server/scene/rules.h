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

/// Every lobe that a table can serve, material by material; none of an unlit or measured one.
std::vector<Need> needs_of(const SceneUse& scene);

/// "No sheen in the scene, no table of sheen": true where some need has one of the lobes.
bool any_of(const std::vector<Need>& needs, std::initializer_list<Lobe> lobes);

/// Diffuse models whose albedo is their colour at every angle need no table.
bool diffuse_needs_table(DiffuseModel model);

/// At roughness 0 the lobe is a mirror: its albedo is F(NoV) in closed form.
bool is_mirror(const Range& roughness);

/// What of the roughness axis is used: ranges that overlap are one ("equal tables are one"), a
/// value within a range is part of it, one that stands alone is a row. Isolated values become one
/// range where they are more than kRowsMax or than the rows that a range of `rows_full` takes.
std::vector<Range> roughness_pieces(std::vector<Range> used, std::int64_t rows_full);

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

/// Ids of measured materials that something uses, each once, and of those that nothing does.
struct MeasuredUse {
    std::vector<std::string> used, unused;
};
MeasuredUse measured_use(const SceneUse& scene);

}  // namespace kiln::rules
