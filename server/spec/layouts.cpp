// SPDX-License-Identifier: Apache-2.0
#include "server/spec/layouts.h"

#include <algorithm>

#include "server/spec/channels.h"
#include "server/spec/words.h"

namespace kiln {
namespace {

using enum Quantity;

constexpr double kUnbounded = Axis{}.most;
constexpr Axis kNoV{.parameter = Parameter::NoV};
constexpr Axis kRoughness{.parameter = Parameter::roughness};
// Blender's generator and reader keep both parameters away from 0.
constexpr double kCyclesLeast = 1e-4;
constexpr Axis kCyclesRoughness{
    .parameter = Parameter::roughness, .grid = Grid::node, .least = kCyclesLeast};

/// r = (n − y + ½) / n in row y of n: one texel above the flipped centre (n − y − ½) / n.
constexpr Axis one_texel_high(double most) {
    return {.parameter = Parameter::roughness, .flip = true, .shift = 1, .most = most};
}

std::vector<LayoutPreset> make_presets() {
    const ChannelSet split{{split_sum_scale, split_sum_bias}, "the split sum"};
    // lerp(R, G, F0) = F0 A + F90 B with F90 = 1, and G alone is E.
    const ChannelSet lerped{{split_sum_bias, directional_albedo}, "B and A + B"};
    const std::vector<Quantity> cloth{split_sum_bias, directional_albedo, sheen_albedo};
    return {
        {.name = "kiln",
         .program = "",
         .axes = {kNoV, kRoughness},
         .single_axis = kRoughness,
         .channel_sets = {}},
        {.name = "unreal",
         .program = "Unreal Engine 4 (PreintegratedGF, 16-bit UNORM)",
         .axes = {kNoV, kRoughness},
         .resolution = {128, 32},
         .masking = Masking::unreal_joint,
         .channel_sets = {{split.quantities, "for F0 A + saturate(50 F0.g) B, not F90 B"}}},
        {.name = "unity",
         .program = "Unity HDRP (PreIntegratedFGD)",
         .axes = {{.parameter = Parameter::NoV, .mapping = Mapping::sqrt, .grid = Grid::node},
                  {.parameter = Parameter::roughness, .grid = Grid::node}},
         .resolution = {64, 64},
         .channel_sets = {lerped,
                          {{split_sum_bias, directional_albedo, diffuse_albedo},
                           "with Disney's diffuse (burley) minus 0.5",
                           DiffuseModel::burley,
                           {0, 0, 0.5}}}},
        {.name = "filament",
         .program = "Filament (cmgen --ibl-dfg: rows one texel high)",
         .axes = {kNoV, one_texel_high(1)},
         .resolution = {128, 128},
         .channel_sets = {{lerped.quantities, "--ibl-dfg-multiscatter"},
                          {cloth, "--ibl-dfg-multiscatter --ibl-dfg-cloth"},
                          {split.quantities, "without it"}}},
        {.name = "godot",
         .program = "Godot 4 (integrate_dfg: rows one texel high, row 0 beyond 1)",
         .axes = {kNoV, one_texel_high(kUnbounded)},
         .resolution = {128, 128},
         .masking = Masking::karis_ibl,
         .channel_sets = {{cloth, "with cloth; its A is 1"}, lerped}},
        {.name = "threejs",
         .program = "three.js (DFGLUTData)",
         .axes = {kRoughness, kNoV},
         .resolution = {16, 16},
         .channel_sets = {split}},
        {.name = "babylon",
         .program = "Babylon.js (environmentBRDF)",
         .axes = {kNoV, kRoughness},
         .resolution = {256, 256},
         .channel_sets = {{cloth,
                           "with sheen; its PNG is RGBD, which Kiln does not write, and lies a "
                           "texel lower than its shader reads it: row i at roughness "
                           "(i + 1.5)/256"},
                          lerped}},
        {.name = "cycles",
         .program = "Blender Cycles (table_ggx_E, table_ggx_Eavg)",
         .axes = {kCyclesRoughness,
                  {.parameter = Parameter::NoV, .grid = Grid::node, .least = kCyclesLeast}},
         .single_axis = kCyclesRoughness,
         .resolution = {32, 32},
         .channel_sets = {{{directional_albedo}, "table_ggx_E"},
                          {{average_albedo}, "table_ggx_Eavg, one entry in resolution"}}},
        {.name = "gltf",
         .program = "glTF-IBL-Sampler and glTF-Sample-Viewer (lut_ggx)",
         .axes = {kNoV, kRoughness},
         .channel_sets = {{{split_sum_scale, split_sum_bias, sheen_albedo}, "with Charlie"},
                          split}},
    };
}

std::string channels_of_set(const ChannelSet& set) {
    std::string text;
    for (std::size_t i = 0; i < set.quantities.size(); ++i)
        text += (i ? ", " : "") + std::string(1, "RGBA"[i]) + " = " +
                std::string(to_word(set.quantities[i]));
    return text;
}

/// Whether the job's channels are those of the set: none of them in three colours.
bool is_of(const ChannelSet& set, const JobSpec& job) {
    return set.quantities == job.quantities && channels_of(job).size() == set.quantities.size();
}

}  // namespace

std::span<const LayoutPreset> layout_presets() {
    static const std::vector<LayoutPreset> presets = make_presets();
    return presets;
}

const LayoutPreset* layout_preset(std::string_view name) {
    for (const LayoutPreset& preset : layout_presets())
        if (preset.name == name) return &preset;
    return nullptr;
}

double added_by_shader(const JobSpec& job, Quantity quantity) {
    const LayoutPreset* preset = layout_preset(job.layout);
    if (!preset) return 0;
    for (const ChannelSet& set : preset->channel_sets) {
        if (set.added.empty() || !is_of(set, job)) continue;
        const auto found = std::find(set.quantities.begin(), set.quantities.end(), quantity);
        if (found != set.quantities.end())
            return set.added[static_cast<std::size_t>(found - set.quantities.begin())];
    }
    return 0;
}

std::vector<std::string> layout_lines(const JobSpec& job) {
    const LayoutPreset* preset = layout_preset(job.layout);
    if (!preset || preset->program.empty()) return {};
    std::string size;
    for (const std::int64_t n : preset->resolution)
        if (size.empty() || job.axes.size() > 1)
            size += (size.empty() ? ", " : " x ") + std::to_string(n);
    std::vector<std::string> lines{"layout " + preset->name + ": as read by " + preset->program +
                                   size + ", masking " + std::string(to_word(preset->masking))};
    for (const ChannelSet& set : preset->channel_sets)
        lines.push_back("layout " + preset->name + " reads " + channels_of_set(set) + " (" +
                        set.table + ")");
    return lines;
}

std::vector<std::string> layout_warnings(const JobSpec& job) {
    const LayoutPreset* preset = layout_preset(job.layout);
    if (!preset || preset->program.empty()) return {};
    std::vector<std::string> warnings;
    const std::string start = "layout \"" + preset->name + "\": ";
    if (job.distribution == Distribution::ggx && job.masking != preset->masking)
        warnings.push_back(start + "the program was made for masking " +
                           std::string(to_word(preset->masking)) + ", this table has " +
                           std::string(to_word(job.masking)));
    const auto& sets = preset->channel_sets;
    const bool read = std::any_of(sets.begin(), sets.end(), [&](const ChannelSet& set) {
        return is_of(set, job) && (!set.diffuse || job.diffuse.model == *set.diffuse);
    });
    // Another distribution is a table of its own (cloth, sheen), for a channel of the program's.
    if (read || job.distribution != Distribution::ggx) return warnings;
    std::string expected;
    for (const ChannelSet& set : sets)
        expected += (expected.empty() ? "" : "; or ") + channels_of_set(set);
    warnings.push_back(start + "the program reads " + expected + ", this table has others");
    return warnings;
}

}  // namespace kiln
