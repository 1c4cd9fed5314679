// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "server/measured/azimuths.h"
#include "server/measured/between.h"
#include "server/measured/hemisphere.h"
#include "server/measured/reader.h"
#include "server/spec/measured_spec.h"

namespace kiln::measured {

using kiln::Extrapolation;
using kiln::ThetaInBeyond;

/// y at x of the quadratic Bezier curve (0,0), (l, 1-l), (1,1); x and l in [0, 1].
double bezier(double x, double l);

using Colour = std::array<double, 3>;

/// A material as a function of any theta_in and view, made of one component of a file.
/// Values are linear sRGB or, of a file without colour, one value three times; colours outside
/// sRGB are negative.
class Material {
  public:
    /// Of several azimuths of the light what at_azimuth() makes of them. Throws
    /// Error("unfit_measurement") if no incidence has an area, and what colouring_of() and
    /// at_azimuth() throw.
    Material(const Component& component, Extrapolation extrapolation, Understood& account,
             PhiIn phi_in = {});

    const std::string& colour() const { return colour_; }  ///< Colouring::words
    const AzimuthAccount& azimuths() const { return azimuths_; }

    /// f_r in 1/sr for light at theta_in degrees and azimuth 0. Views below the horizon get the
    /// value at the horizon under the same azimuth, so that tables can be interpolated across it.
    Colour value(double theta_in, Vec out, Origin& origin) const;

    /// One measured incidence: its own values, and beyond its edge and below the horizon the one at
    /// the edge under the same azimuth; origin is kExtrapolated there where no measurement is near.
    Colour edge_value(std::size_t lobe, Vec out, std::uint32_t& hint, Origin& origin) const;
    /// Largest measured theta_o at an azimuth, degrees.
    double edge(std::size_t lobe, double azimuth) const;
    /// Factor of the last lobe at theta_in beyond it.
    double level(double theta_in) const;
    bool goes_on_by_reciprocity() const { return !levels_.empty(); }
    const Extrapolation& extrapolation() const { return extrapolation_; }
    std::size_t lobe_count() const { return lobes_.size(); }
    const Hemisphere& hemisphere(std::size_t lobe) const { return lobes_[lobe].hemisphere; }
    /// One incidence with the tail beyond its edge.
    Colour lobe_value(std::size_t lobe, Vec out, Origin& origin) const;

    /// Of incidences together, at a place about the mirror direction: see Between. Without the tail
    /// beyond the edges; origin is that of the first two.
    Colour tapped(const std::vector<Tap>& taps, Vec about, Origin& origin) const;
    /// The measured incidences and those that stand between them.
    const std::vector<Station>& stations() const { return stations_; }
    /// What edge() is of a station: beyond it f follows the tail.
    double station_edge(const Station& station, double azimuth) const;
    Between between() const { return between_; }
    /// Below which asinh(f / floor) is linear in f: a hundredth of the mean of f.
    double floor() const { return floor_; }

    std::vector<double> theta_in() const;  ///< of the measured incidences, degrees
    double theta_in_max() const { return lobes_.back().theta_i; }

    struct Albedo {
        Colour value{};
        double extrapolated = 0;  ///< share of the green (or only) channel
    };
    /// Directional albedo: integral of max(0, f) cos(theta_o) over the whole hemisphere, from the
    /// regular form in the native kernels. For many angles a Resampler is faster.
    Albedo albedo(double theta_in) const;
    /// 2 * integral of E(mu) mu d mu, the cosine-weighted mean of directional albedos.
    Albedo average_albedo() const;

  private:
    struct Lobe {
        double theta_i = 0;
        Hemisphere hemisphere;
        std::vector<double> reach;  ///< theta_o in degrees, one a degree of azimuth
    };
    /// Between measured incidences, or clamped to the last.
    Colour aligned_value(double theta_in, Vec out, Origin& origin) const;
    Colour beyond_value(double theta_in, Vec out, Origin& origin) const;
    Colour station_value(const Station& station, Vec about, Origin& origin) const;
    double tail(double theta_o, double edge) const;
    void find_levels();
    void find_floor();

    Extrapolation extrapolation_;
    std::string colour_;
    AzimuthAccount azimuths_;
    std::vector<Lobe> lobes_;
    Between between_ = Between::linear;
    std::vector<Station> stations_;
    double floor_ = 1;
    std::vector<double> levels_;  ///< of the last lobe, one a degree beyond theta_in_max()
};

}  // namespace kiln::measured
