// SPDX-License-Identifier: Apache-2.0
// Random extreme inputs through the kernels: nothing that is not finite, nothing outside its proven
// range. KILN_EXTREME_INPUTS=100000000 is the long form, half an hour of two cores.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "server/compute/fresnel.h"
#include "server/compute/native.h"
#include "server/compute/plan.h"
#include "tests/compute/every_lobe.h"

namespace kiln {
namespace {

/// Places that share one launch, its material and its points.
constexpr std::size_t kPlaces = 2048;
constexpr std::int64_t kSamples = 32;

std::size_t input_count() {
    const char* text = std::getenv("KILN_EXTREME_INPUTS");
    return text == nullptr ? 1000000 : std::strtoull(text, nullptr, 10);
}

class Draw {
  public:
    explicit Draw(unsigned seed) : engine_(seed) {}
    std::size_t below(std::size_t count) { return engine_() % count; }
    double unit() { return std::uniform_real_distribution<>(0, 1)(engine_); }
    double log(double lo, double hi) { return lo * std::pow(hi / lo, unit()); }
    /// In [0, 1], with the ends, what is next to them, and denormals of a float.
    double zero_to_one() {
        switch (below(8)) {
            case 0:
                return 0;
            case 1:
                return 1;
            case 2:
                return 1 - log(6e-8, 1e-3);
            case 3:
                return log(1e-45, 1e-38);
            case 4:
                return log(1e-38, 1e-6);
            case 5:
                return 1e-6;
            case 6:
                return log(1e-6, 1);
            default:
                return unit();
        }
    }

  private:
    std::mt19937 engine_;
};

std::vector<double> one_or_three(Draw& draw, double (*of)(Draw&)) {
    std::vector<double> values;
    for (std::size_t c = draw.below(2) == 0 ? 1 : 3; c > 0; --c) values.push_back(of(draw));
    return values;
}

FresnelModel any_fresnel(Draw& draw) {
    constexpr Fresnel kModels[] = {Fresnel::none,      Fresnel::schlick,   Fresnel::dielectric,
                                   Fresnel::conductor, Fresnel::edge_tint, Fresnel::f82_tint};
    FresnelModel model;
    model.model = kModels[draw.below(std::size(kModels))];
    const auto unit = [](Draw& d) { return d.zero_to_one(); };
    const auto index = [](Draw& d) {
        return d.below(3) == 0 ? 1 + (d.below(2) == 0 ? 1 : -1) * d.log(1e-7, 1e-2)
                               : d.log(1e-4, 1e6);
    };
    model.f0 = one_or_three(draw, unit);
    model.f90 = one_or_three(draw, unit);
    model.exponent = draw.below(2) == 0 ? 5 : draw.log(1e-3, 1e3);
    model.ior = one_or_three(draw, index);
    model.eta = one_or_three(draw, index);
    model.k = one_or_three(draw, [](Draw& d) { return d.below(4) == 0 ? 0 : d.log(1e-6, 1e6); });
    model.reflectivity =
        one_or_three(draw, [](Draw& d) { return std::min(d.zero_to_one(), 0.99999); });
    model.edge_tint = one_or_three(draw, unit);
    model.f82 = one_or_three(draw, unit);
    return model;
}

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
        return {F_min < 0 ? -infinite : 0, infinite};                 // 1 / NoL at grazing views
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

template <typename Scalar>
void check_launch(Backend& backend, Draw& draw) {
    KernelMaterial what = any_material(draw);
    FresnelModel fresnel = any_fresnel(draw);
    if (what.importance == kPartedLights) fresnel.model = Fresnel::dielectric;
    what.fresnel = what.general ? fresnel_function(fresnel) : 0;
    std::vector<Scalar> parameters(kParameterCount), texels(2 * kPlaces);
    for (int c = 0; c < 3; ++c) {
        std::size_t at = static_cast<std::size_t>(c) * kAlbedoParameter / 3;
        for (const double number : fresnel_parameters(fresnel, c))
            parameters[at++] = static_cast<Scalar>(number);
        parameters[kAlbedoParameter + static_cast<std::size_t>(c)] =
            static_cast<Scalar>(draw.zero_to_one());
    }
    parameters[kExponentParameter] = static_cast<Scalar>(draw.log(1e-3, 1e3));
    for (std::size_t i = 0; i < kPlaces; ++i) {
        texels[i] = static_cast<Scalar>(is_charlie_fit(what.masking) ? draw.log(1e-6, 1)
                                                                     : draw.zero_to_one());
        const bool no_zero = what.importance >= kLogTangents || evaluates_D(what);
        const double least = what.importance == kPartedLights ? 1e-4 : 1e-8;
        texels[kPlaces + i] =
            static_cast<Scalar>(no_zero ? draw.log(least, 1) : draw.zero_to_one());
    }
    const PointSet set = make_points(static_cast<Sampler>(draw.below(4)), point_kind(what),
                                     draw.below(1u << 30), kSamples);
    const std::vector<Scalar> points(set.values.begin(), set.values.end());
    const auto planes =
        static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(what.terms)));
    std::vector<Scalar> sums(set.batches.size() * planes * kPlaces);
    const Precision precision =
        sizeof(Scalar) == sizeof(float) ? Precision::float32 : Precision::float64;
    backend.run(
        Launch<Scalar>{{what, precision}, kPlaces, texels, points, parameters, set.batches, sums});
    std::size_t row = 0;
    for (const BatchRange& batch : set.batches)
        for (std::size_t term = 0; term < kTermCount; ++term) {
            if (!(what.terms >> term & 1)) continue;
            const Range range = range_of(what, term);
            for (std::size_t i = 0; i < kPlaces; ++i) {
                const double mean = static_cast<double>(sums[row * kPlaces + i]) /
                                    static_cast<double>(batch.point_count);
                if (mean >= range.lo - 2e-6 && mean <= range.hi + 2e-6) continue;
                // A mean of two draws for the deficit alone may be any weight that is not negative.
                if (what.terms == 1 << kDeficit && mean > 0 && std::isfinite(mean)) continue;
                ADD_FAILURE() << mean << " of term " << term << " at NoV " << texels[i] << " alpha "
                              << texels[kPlaces + i] << ", masking " << what.masking
                              << ", importance " << what.importance << ", averaged "
                              << what.averaged << ", general " << what.general << ", distribution "
                              << what.distribution << ", Fresnel " << what.fresnel << ", diffuse "
                              << what.diffuse;
                return;
            }
            ++row;
        }
}

TEST(Extremes, RandomInputsStayFiniteAndInRange) {
    ThreadPool pool(2);
    const auto backend = make_native_backend(pool, usable_instruction_sets().front());
    Draw draw(20260);
    for (std::size_t done = 0; done < input_count(); done += 2 * kPlaces) {
        check_launch<float>(*backend, draw);
        check_launch<double>(*backend, draw);
        if (HasFailure()) return;
    }
}

}  // namespace
}  // namespace kiln
