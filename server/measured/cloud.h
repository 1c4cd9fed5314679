// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kiln::measured {

/// What a point of a cloud is worth. Values of all states are kept as they were stored.
enum class PointState : std::uint8_t {
    kMeasured,
    kMirrored,      ///< the other side of the plane of incidence, by the file's symmetry
    kBelowHorizon,  ///< no direction of the upper hemisphere; the value means nothing
    kNotMeasured,   ///< above the horizon, but the file marks it or its instrument cannot reach it
    kRejected,      ///< measured, and impossible
};

inline bool usable(PointState state) {
    return state == PointState::kMeasured || state == PointState::kMirrored;
}

/// Scattered values of f_r in 1/sr. Directions point away from the surface; angles in degrees:
/// theta from the normal, phi an azimuth in [0, 360) in which the mirror direction of phi_i is
/// phi_i + 180. Index n is one pair of directions in all arrays; its values are
/// values[n * channels.size() + channel].
struct Cloud {
    std::vector<std::string> channels;  ///< "R", "G", "B"; "X", …; "650nm"; "value"
    std::vector<float> theta_i, phi_i, theta_o, phi_o;
    std::vector<PointState> state;
    std::vector<float> values;
    /// Projected solid angle in sr that a point stands for; empty where the file has no patches.
    std::vector<float> patch;

    std::size_t size() const { return state.size(); }
    const float* at(std::size_t n) const { return values.data() + n * channels.size(); }
};

/// Sizes of a table over Rusinkiewicz's angles in MERL's layout; 0 for every other cloud. Points
/// then lie in the order of the cells, phi_d fastest.
struct HalfDifferenceGrid {
    std::size_t theta_h = 0, theta_d = 0, phi_d = 0;
};

/// What leaves f as it is when surface and both directions are turned or mirrored together:
/// azimuths of the light that a file leaves out are known by it.
enum class TurnSymmetry {
    none,
    half_turn,
    two_planes,  ///< mirrored in x and in y; a half turn is both
    any_turn,    ///< isotropic, as the format has it: light from any azimuth is like any other
};

/// One side, direction of scattering and kind of spectrum of a file.
struct Component {
    std::string name;  ///< "reflection front", "transmission front, solar", …
    Cloud cloud;
    HalfDifferenceGrid grid;
    TurnSymmetry symmetry = TurnSymmetry::none;
};

/// Directions in degrees of one point.
struct Directions {
    double theta_i = 0, phi_i = 0, theta_o = 0, phi_o = 0;
};

/// Appends a point; values has channels.size() entries. Azimuths are brought into [0, 360), a
/// theta_o above 90 makes it kBelowHorizon. Throws Error past kPointsMax or kValuesMax.
void add_point(Cloud& cloud, const Directions& at, const double* values,
               PointState state = PointState::kMeasured);

/// Adds the other side of the plane of incidence to a cloud whose points all lie on one side.
/// Returns whether it did: not for points on both sides or all in the plane.
bool mirror_half(Cloud& cloud);

/// Degrees in [0, 360).
double wrapped_degrees(double degrees);

}  // namespace kiln::measured
