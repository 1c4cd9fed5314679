// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <vector>

#include "server/compute/measured_launch.h"

namespace kiln::measured {

class Material;

/// The regular form of a material that kernels/measured.h reads: a table about the mirror direction
/// for each measured incidence, and for those that stand between them (between.h), which are made
/// of the measured ones node by node. Cells are half as wide as the triangles between the measured
/// points (their lower quartiles), so that what they lose is a quarter of what the points leave
/// open; within kLobeRingsMax and kLobeSpokesMax.
struct LobeTables {
    MeasuredShape shape;
    std::vector<float> nodes;           ///< [lobe][ring][spoke][R, G, B, origin]
    std::vector<float> curves;          ///< kernels/measured.h
    std::vector<double> theta_in;       ///< degrees
    std::vector<std::size_t> measured;  ///< which of these were measured

    /// Asks for the mean of f(i, o) and f(o, i) times scale(theta_i) scale(theta_o), which is
    /// reciprocal whatever was measured. One scale a degree from 0.
    void make_symmetric(const std::vector<double>& scale);
};

inline constexpr unsigned kLobeRingsMin = 65, kLobeRingsMax = 257;
inline constexpr unsigned kLobeSpokesMin = 97, kLobeSpokesMax = 513;

LobeTables make_lobe_tables(const Material& material);

}  // namespace kiln::measured
