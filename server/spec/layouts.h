// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/spec/job_spec.h"

namespace kiln {

/// Quantities that a program reads from the channels R, G, … of one table.
struct ChannelSet {
    std::vector<Quantity> quantities;
    std::string table;  ///< the program's own word for that table, and what Kiln does not store
    std::optional<DiffuseModel> diffuse{};  ///< of diffuse_albedo, where it is one of them
    std::vector<double> added{};            ///< what its shader adds to each; empty: nothing
};

/// How one program reads its table. The name of a preset is what a job stores.
struct LayoutPreset {
    std::string name;
    std::string program;                ///< for people; empty for Kiln's own layout
    std::vector<Axis> axes;             ///< of two entries in resolution
    std::optional<Axis> single_axis{};  ///< of one entry, where the program has such a table
    /// Of the program's own table, where the document names none; empty where it takes any.
    std::vector<std::int64_t> resolution{};
    /// Of distribution ggx, where the document names none. Other distributions have their own.
    Masking masking = Masking::smith_correlated;
    std::vector<ChannelSet> channel_sets;  ///< empty where any will do
};

/// In the order of the contract's enum; "kiln" first.
std::span<const LayoutPreset> layout_presets();

/// Null for what is no preset's name ("custom").
const LayoutPreset* layout_preset(std::string_view name);

/// What the shader of the job's preset adds to a quantity: its table holds so much less. 0 where
/// the job asks for other quantities than that program reads.
double added_by_shader(const JobSpec& job, Quantity quantity);

/// What the job's preset is and which quantities its program reads from which channels, one line a
/// fact, ASCII; empty for "kiln" and "custom".
std::vector<std::string> layout_lines(const JobSpec& job);

/// Where the job departs from what the program of its preset reads: one sentence each.
std::vector<std::string> layout_warnings(const JobSpec& job);

}  // namespace kiln
