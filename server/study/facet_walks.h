// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <random>

#include "server/study/reflectance.h"

namespace kiln {

/// A mean over walks and the standard deviation of that mean.
struct WalkedValue {
    double value = 0, standard_error = 0;
};

/// f(V, L), 1/sr, of the surface of Lambertian GGX facets (diffuse model ggx_lambert), which has no
/// closed form: walks from V at explicit heights, each facet of which is connected with L. No term
/// is negative and the mean is exact, so that what is asked of a function can be asked of it, to a
/// standard error. Nothing of it is shared by V and L: reciprocity is found, not built in.
class FacetWalks {
  public:
    /// alpha in (0, 1], albedo in [0, 1].
    FacetWalks(double alpha, double albedo, std::uint64_t seed);

    /// Of `walks` >= 2 independent walks; both cosines above 0.
    WalkedValue value(const Directions& d, int walks);

  private:
    struct Vector {
        double x, y, z;
    };
    double walk(const Vector& view, const Vector& light);
    Vector normal(const Vector& seen_from);
    Vector about(const Vector& normal);
    double reach(double cosine) const;
    double uniform();

    double alpha_, albedo_;
    std::mt19937_64 random_;
};

}  // namespace kiln
