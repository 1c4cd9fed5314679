// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <vector>

namespace kiln::measured {

class Material;

/// How f goes on between measured incidences, at equal places about the mirror direction.
enum class Between {
    linear,  ///< of f, between two incidences (Cezner 2024)
    cubic,   ///< of asinh(f / floor), through up to four: slopes are those of parabolas
};
std::string to_string(Between between);

/// A measured incidence in a sum. Of an isotropic material the light at -theta_in is known too: the
/// same lobe, turned by half a turn.
struct Tap {
    std::size_t lobe = 0;
    bool turned = false;
    double weight = 0;
};
/// Weights, of sum 1, for theta_in in degrees within the incidences, which rise; the two around it
/// come first. One tap at an incidence itself.
std::vector<Tap> taps_at(std::span<const double> incidences, double theta_in, Between between);

/// Where incidences are put between measured ones, so that what reads the table may go on linearly:
/// at most kStationStep apart, in even steps.
inline constexpr double kStationStep = 5;  // degrees
struct Station {
    double theta_in = 0;
    std::vector<Tap> taps;
};
std::vector<Station> stations(std::span<const double> incidences, Between between);

/// An inner incidence predicted from the others.
struct IncidenceError {
    std::size_t lobe = 0;
    /// Mean |prediction - f| cos(theta_o) relative to the mean of |f| cos(theta_o), of the
    /// channels' sum, where all that take part were measured.
    double error = 0;
    double reach = 0;  ///< Reach::length of the incidences that it was predicted from
};
std::vector<IncidenceError> leave_incidences_out(const Material& material, Between between);

/// The product of the distances to the incidences that are read at theta_in, to the power of one
/// over their number: a length in degrees, to whose power the error of an interpolation goes.
struct Reach {
    double length = 0;
    double order = 0;  ///< how many they are
};
Reach reach_of(std::span<const double> incidences, double theta_in, Between between);

/// What predicts left-out incidences better; linear where there are fewer than three.
Between better_between(const Material& material);

}  // namespace kiln::measured
