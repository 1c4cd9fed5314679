// SPDX-License-Identifier: Apache-2.0
// Random extreme inputs through the kernels: nothing that is not finite, nothing outside its proven
// range, and of a part the same bits from OpenCL. KILN_EXTREME_INPUTS=100000000 is the long form,
// some 25 minutes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "server/compute/fresnel.h"
#include "server/compute/plan.h"
#include "tests/compute/every_lobe.h"
#include "tests/compute/extremes.h"

namespace kiln {
namespace {

/// Places that share one launch, its material and its points.
constexpr std::size_t kPlaces = 256;
constexpr std::int64_t kSamples = 32;

using namespace extremes;

struct Range {
    double lo, hi;
};

/// What the mean of a term lies in, whatever the points. Rounding adds some 1e-6.
Range range_of(const KernelMaterial& what, std::size_t term) {
    const double infinite = std::numeric_limits<double>::max();
    // Hoffman's tint may take F below 0 on either side of 82 degrees.
    constexpr int kTint82 = 5;
    const double F_min = what.fresnel == kTint82 && term >= kColour ? -1 : 0;
    // A parted light stands for at most twice the normals of a hemisphere, where points are two
    // thirds as dense, or for 6 π times its cosine; what F weighs may be too much of F = 1.
    if (what.importance == kPartedLights) {
        if (term < kDiffuse) return {-3, 6};
        return {0, what.diffuse == 0 ? 6.0 : infinite};
    }
    if (term >= kDiffuse) {
        if (what.diffuse == 0) return {0, 1 - F_min};                 // Lambert
        if (what.diffuse == 1) return {F_min, 6.25 * (1 - F_min)};    // Burley: (1 + 3/2)²
        if (what.diffuse == KILN_DIFFUSE_GGX_LAMBERT) return {0, 1};  // a walk's shares
        // The full Oren-Nayar lobe is negative between grazing directions on opposite sides: albedo
        // times C1 - .45 (6 / π) σ² / (σ² + .09) and albedo² times what is thrown back are -.1644
        // and .3009 at σ = 1, in sum -.0225 at an albedo of .27; 1 / NoL at grazing views.
        const double least = what.diffuse == KILN_DIFFUSE_OREN_NAYAR_FULL ? -0.0225 : 0;
        return {F_min < 0 ? -infinite : least, infinite};
    }
    // G2 / G1 of the view is a probability under both Smith forms; Beckmann's D is at most 4 / e
    // times GGX's where its visible normals are drawn, and its G1 need not be less. By other
    // samplers, or under other maskings, the weight is a ratio of densities without a bound.
    const bool probability =
        what.importance == 0 && what.masking <= 1 && what.distribution == KILN_DISTRIBUTION_GGX;
    // A visible light stands for at most twice the normals of a hemisphere, where points are half
    // as dense.
    if (what.importance == kVisibleLights && F_min >= 0) return {0, 4};
    if (term == kDeficit) return probability ? Range{0, 1} : Range{-infinite, 1};
    if (F_min < 0) return {-infinite, infinite};
    return {0, probability ? 1.0 : infinite};
}

/// Where D itself is evaluated (cosine, uniform) it is infinite at α = 0 on purpose, and so are
/// Charlie's maskings at NoV = 0: of these the places lie beside the pole.
bool evaluates_D(const KernelMaterial& what) {
    return !(what.terms & (7 << kDiffuse)) && (what.importance == KILN_IMPORTANCE_COSINE ||
                                               what.importance == KILN_IMPORTANCE_UNIFORM);
}

KernelMaterial any_material(Draw& draw) {
    static const std::vector<KernelMaterial> lobes = every_lobe();
    KernelMaterial what;
    if (draw.below(4) == 0) {
        what.importance = KILN_IMPORTANCE_COSINE;
        what.diffuse = static_cast<int>(draw.below(KILN_DIFFUSE_COUNT));
        what.averaged = static_cast<int>(draw.below(2));
        what.terms = 7 << kDiffuse;
        if (what.diffuse != KILN_DIFFUSE_GGX_LAMBERT) what.terms |= 7 << kTransmitted;
        what.general = 1;
        return what;
    }
    if (draw.below(8) == 0) {
        what.importance = kPartedLights;
        what.masking = static_cast<int>(draw.below(2));
        what.diffuse = static_cast<int>(draw.below(2));
        what.terms = 7 << (draw.below(2) == 0 ? kColour : kTransmitted);
        what.general = 1;
        return what;
    }
    if (draw.below(2) == 0) {
        what = lobes[draw.below(lobes.size())];
        what.averaged = static_cast<int>(draw.below(2));
        what.terms = 7 | 7 << kColour;
        what.general = 1;
        return what;
    }
    what.masking = static_cast<int>(draw.below(2));
    what.importance = static_cast<int>(draw.below(2));
    what.terms = 7;
    what.averaged = static_cast<int>(draw.below(2));
    if (draw.below(4) == 0) {
        what.importance = what.averaged ? kHorizonNormals : kLogTangents;
        what.terms = 1 << kDeficit;
    } else if (draw.below(4) == 0) {
        what.importance = kVisibleLights;
        what.averaged = 0;
        what.terms = 3;
    }
    if (what.terms != 1 << kDeficit && draw.below(2) == 0) {
        what.general = 1;
        what.terms |= 7 << kColour;
    }
    return what;
}

/// One launch with what it points to.
template <typename Scalar>
struct Extreme {
    KernelMaterial what;
    std::vector<Scalar> parameters, texels, points, sums;
    PointSet set;

    Extreme(Draw& draw, const KernelMaterial& material)
        : what(material), parameters(kParameterCount), texels(2 * kPlaces) {
        draw_parameters(draw);
        draw_places(draw);
        set = make_points(static_cast<Sampler>(draw.below(4)), point_kind(what),
                          draw.below(1u << 30), kSamples);
        points.assign(set.values.begin(), set.values.end());
        const auto planes =
            static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(what.terms)));
        sums.resize(set.batches.size() * planes * kPlaces);
    }

    Launch<Scalar> launch() {
        const Precision precision =
            sizeof(Scalar) == sizeof(float) ? Precision::float32 : Precision::float64;
        return {{what, precision}, kPlaces, texels, points, parameters, set.batches, sums};
    }

  private:
    void draw_parameters(Draw& draw) {
        FresnelModel fresnel = any_fresnel(draw);
        if (what.importance == kPartedLights) fresnel.model = Fresnel::dielectric;
        what.fresnel = what.general ? fresnel_function(fresnel) : 0;
        for (int c = 0; c < 3; ++c) {
            std::size_t at = static_cast<std::size_t>(c) * kAlbedoParameter / 3;
            for (const double number : fresnel_parameters(fresnel, c))
                parameters[at++] = static_cast<Scalar>(number);
            parameters[kAlbedoParameter + static_cast<std::size_t>(c)] =
                static_cast<Scalar>(draw.zero_to_one());
        }
        parameters[kExponentParameter] = static_cast<Scalar>(draw.log(1e-3, 1e3));
    }

    void draw_places(Draw& draw) {
        const bool no_zero = what.importance >= kLogTangents || evaluates_D(what);
        const double least = what.importance == kPartedLights ? 1e-4 : 1e-8;
        for (std::size_t i = 0; i < kPlaces; ++i) {
            texels[i] = static_cast<Scalar>(is_charlie_fit(what.masking) ? draw.log(1e-6, 1)
                                                                         : draw.zero_to_one());
            texels[kPlaces + i] =
                static_cast<Scalar>(no_zero ? draw.log(least, 1) : draw.zero_to_one());
        }
    }
};

std::string name_of(const KernelMaterial& what) {
    return "masking " + std::to_string(what.masking) + ", importance " +
           std::to_string(what.importance) + ", averaged " + std::to_string(what.averaged) +
           ", general " + std::to_string(what.general) + ", distribution " +
           std::to_string(what.distribution) + ", Fresnel " + std::to_string(what.fresnel) +
           ", diffuse " + std::to_string(what.diffuse);
}

template <typename Scalar>
void hold_ranges(const Extreme<Scalar>& extreme) {
    const KernelMaterial& what = extreme.what;
    std::size_t row = 0;
    for (const BatchRange& batch : extreme.set.batches)
        for (std::size_t term = 0; term < kTermCount; ++term) {
            if (!(what.terms >> term & 1)) continue;
            const Range range = range_of(what, term);
            for (std::size_t i = 0; i < kPlaces; ++i) {
                const double mean = static_cast<double>(extreme.sums[row * kPlaces + i]) /
                                    static_cast<double>(batch.point_count);
                // Of 1 - F, which may be -6e-7 by rounding, times a lobe that has no bound.
                const bool beside_lobe = term >= kTransmitted && what.terms >> kDiffuse & 1;
                const double lobe =
                    beside_lobe ? static_cast<double>(extreme.sums[(row - 3) * kPlaces + i]) /
                                      static_cast<double>(batch.point_count)
                                : 0;
                const double rounding = 2e-6 * std::max(1.0, lobe);
                if (mean >= range.lo - rounding && mean <= range.hi + rounding) continue;
                // A mean of two draws for the deficit alone may be any weight that is not negative.
                if (what.terms == 1 << kDeficit && mean > 0 && std::isfinite(mean)) continue;
                ADD_FAILURE() << mean << " of term " << term << " at NoV " << extreme.texels[i]
                              << " alpha " << extreme.texels[kPlaces + i] << ", " << name_of(what);
                return;
            }
            ++row;
        }
}

class Extremes : public OnNative {
  protected:
    template <typename Scalar>
    void check(Draw& draw) {
        Extreme<Scalar> extreme(draw, any_material(draw));
        native_->run(extreme.launch());
        hold_ranges(extreme);
    }
};

TEST_F(Extremes, RandomInputsStayFiniteAndInRange) {
    Draw draw(20260);
    for (std::size_t done = 0; done < input_count(); done += 2 * kPlaces) {
        check<float>(draw);
        check<double>(draw);
        if (HasFailure()) return;
    }
}

class ExtremesOnOpenCl : public OnBoth {
  protected:
    /// The general path has one program for all materials, which takes 3 s to compile; each lobe of
    /// the fast path has one of its own, so they are held in float and under one masking alone.
    template <typename Scalar>
    static KernelMaterial compiled_material(Draw& draw) {
        for (;;) {
            KernelMaterial what = any_material(draw);
            if (what.general) what.general = kAnyMaterial;
            if (what.general || (sizeof(Scalar) == sizeof(float) && what.masking == 0)) return what;
        }
    }

    template <typename Scalar>
    void check(Draw& draw) {
        Extreme<Scalar> extreme(draw, compiled_material<Scalar>(draw));
        EXPECT_TRUE(have_equal_bits(extreme.launch(), extreme.sums)) << name_of(extreme.what);
    }
};

// An eighth of them.
TEST_F(ExtremesOnOpenCl, SampleToTheSameBits) {
    Draw draw(20261);
    for (std::size_t done = 0; done < input_count() / 8; done += 2 * kPlaces) {
        check<float>(draw);
        check<double>(draw);
        if (HasFailure()) return;
    }
}

}  // namespace
}  // namespace kiln
