// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "server/compute/backend.h"
#include "server/spec/deficit.h"

namespace kiln {

/// expected_deficit, or its average, of a kernel's lobe.
inline double expected_deficit(const KernelMaterial& what, double NoV, double alpha) {
    return what.averaged ? expected_average_deficit(alpha)
                         : expected_deficit(static_cast<Masking>(what.masking), NoV, alpha);
}

/// What replicates of a mean may miss at a place: events of a chance in each sample, and the weight
/// of one. Their variance in N samples is weight² chance / N.
struct RareEvents {
    double chance = 0, weight = 0;
};

/// What a mean loses with the light of visible normals, where NoV ≪ α. Light below an elevation z
/// has the chance α z' + z'² / 8α² with z' = z + NoV, by slopes about 1 and about α: below the
/// horizon within a tenth of sums over 2^22 normals where NoV < α / 9. With a slope about 1 it
/// comes from all azimuths φ alike, at VoH = cos φ, the normal lying along the horizon too: so few
/// events carry nearly all of what a mean of Schlick's weight loses. With one about α it comes from
/// ahead, VoH ≈ 0.
class LostLights {
  public:
    /// of_VoH(x): what one sample is to the mean at VoH = x.
    template <typename OfVoH>
    explicit LostLights(OfVoH of_VoH) : ahead_(of_VoH(0.0)) {
        for (std::size_t i = 0; i < aside_.size(); ++i)
            aside_[i] = of_VoH(std::cos((static_cast<double>(i) + 0.5) / kAzimuths * M_PI_2));
    }

    /// Of a mean that has `control` less for each lost light. Correlated masking takes NoV / z' of
    /// what is above the horizon: by slopes about 1 as much of the squares as is lost below and
    /// half as much of the cubes, which all replicates meet. So the variance is that of light
    /// below, and it is as skewed as 2³ / 1.5² times as many equal events.
    RareEvents at(double NoV, double alpha, double control) const {
        const double part = NoV / (2 * alpha), from_ahead = part * part / 2;
        const double lost_ahead = std::abs(ahead_ - control);
        double square = 0, cube = 0;
        for (const double aside : aside_) {
            const double lost = std::abs(aside - control);
            square += lost * lost;
            cube += lost * lost * lost;
        }
        const double each_azimuth = alpha * NoV / kAzimuths;
        square = each_azimuth * square + from_ahead * lost_ahead * lost_ahead;
        cube = each_azimuth * cube + from_ahead * lost_ahead * lost_ahead * lost_ahead;
        if (!(cube > 0)) return {};
        const double chance = 32 / 9.0 * square * square * square / (cube * cube);
        return {chance, std::sqrt(square / chance)};
    }

  private:
    static constexpr std::size_t kAzimuths = 16;
    double ahead_;
    std::array<double, kAzimuths> aside_{};
};

/// The VoH at which light is lost, in the mean over the visible normals that lose it below the
/// horizon or to masking: from 0.4 to 0.8 α where NoV ≪ α and 0.45 to 0.67 NoV where α ≪ NoV, by a
/// sum over such normals. Estimates have no bias whatever it is.
inline double lost_VoH(double NoV, double alpha) {
    return std::min(std::hypot(0.65 * NoV, 0.6 * alpha), 1.0);
}

/// Samples that hold fewer rare events than this say too little about them.
inline constexpr double kRareEventsSeen = 30;

/// Replicates that saw none of an integral's rare events agree with each other, and their spread
/// knows nothing of what all of them missed. It has it on average, but not often enough: of
/// `events` in 16 replicates, Student's interval holds 95 % - 0.24 / events (Hall 1992, eq. 2.56,
/// with the skewness and kurtosis of Poisson's distribution). So it is no less than the variance of
/// their number, `rare`, below the 8 events that leave it 92 %.
inline double with_rare_events(double spread, double rare, double events) {
    constexpr double kEventsSkewed = 8;
    return events < kEventsSkewed ? std::max(spread, rare) : spread;
}

}  // namespace kiln
