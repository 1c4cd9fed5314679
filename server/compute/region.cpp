// SPDX-License-Identifier: Apache-2.0
#include "server/compute/region.h"

#include <algorithm>
#include <array>
#include <set>

#include "server/compute/fresnel.h"
#include "server/compute/one_lane.h"
#include "server/compute/rare_events.h"

namespace kiln {

namespace {

constexpr std::size_t kPlacesATask = 1024;

constexpr int kDeficitTerms = 1 << kWeight | 1 << kDeficit;
constexpr int kSpecularTerms = kDeficitTerms | 1 << kSchlick | 7 << kColour;

/// A draw for the deficit alone costs as much as the first, so it is for averages, which need no
/// other, and for those who ask for it: of E, A and B, whose errors they hardly change (an rms
/// of 9.5e-4 falls to 9.1e-4 over a split sum), the missed share of 1 − E is in the standard error
/// (rare_events.h).
bool draws_deficit_apart(const KernelMaterial& what) {
    // The mirror's value is one number a place: averages have it for the deficit alone.
    const int known = what.averaged ? kDeficitTerms : kSpecularTerms;
    return (what.averaged || what.terms & 1 << kDeficit) && (what.terms & ~known) == 0 &&
           static_cast<Distribution>(what.distribution) == Distribution::ggx &&
           static_cast<Masking>(what.masking) <= Masking::smith_separable &&
           static_cast<Importance>(what.importance) == Importance::vndf;
}

bool takes_deficit_apart(const Pass& pass, std::size_t place) {
    const KernelMaterial& what = pass.what.material;
    const double alpha = pass.places.alpha(place);
    return better_apart(alpha, expected_deficit(what, pass.places.NoV(place), alpha),
                        what.averaged != 0);
}

/// Visible lights cost nearly twice what visible normals do. At 256 points a replicate their error
/// of E is a third to a tenth where α < 1/2 and NoV > α / 2, from there on it falls as N^-1.3 and
/// more; of 64 points it is not worth the price. Where NoV < α / 2 their weights spread: under
/// correlated masking E and B err less from 2^17 samples on, and by N^-0.94 without them; under
/// separable masking the error is up to ten times as large.
constexpr std::int64_t kVisibleLightsSamplesLeast = 4096, kVisibleLightsGrazing = 1 << 17;
constexpr double kVisibleLightsAlphaMost = 0.5;
/// Where fewer are expected below the horizon in all samples, visible normals err by less than the
/// densities of visible lights do.
constexpr double kVisibleLightsEventsLeast = 0.5;

bool knows_visible_lights(const KernelMaterial& what, std::int64_t sample_count) {
    constexpr int known = 1 << kWeight | 1 << kSchlick | 7 << kColour;
    return sample_count >= kVisibleLightsSamplesLeast && !what.averaged &&
           (what.terms & ~known) == 0 &&
           static_cast<Distribution>(what.distribution) == Distribution::ggx &&
           static_cast<Masking>(what.masking) <= Masking::smith_separable &&
           static_cast<Importance>(what.importance) == Importance::vndf;
}

bool takes_visible_lights(const Pass& pass, std::size_t place, std::int64_t sample_count) {
    const double alpha = pass.places.alpha(place), NoV = pass.places.NoV(place);
    const bool correlated =
        static_cast<Masking>(pass.what.material.masking) == Masking::smith_correlated;
    const bool pays = NoV >= alpha / 2 || (correlated && sample_count >= kVisibleLightsGrazing);
    return alpha < kVisibleLightsAlphaMost && pays &&
           expected_deficit(pass.what.material, NoV, alpha) * static_cast<double>(sample_count) >=
               kVisibleLightsEventsLeast;
}

Draw visible_lights(Specialisation what) {
    what.material.importance = kVisibleLights;
    return {what, PointKind::visible_lights};
}

/// Parted lights take 3.2 times as long as other samples do, on PoCL 5. At 256 points a replicate
/// their error is a quarter, at 1024 a sixth, at 131072 a tenth with the rounding of float, a
/// thirtieth without.
constexpr std::int64_t kPartedLightsSamplesLeast = 4096;
/// Below, a float does not know the rim from its place among such normals to 1e-6 of their number.
constexpr double kPartedLightsAlphaLeast = 1e-4;
/// Of a diffuse lobe, from ior .95 down: the nearer to 1, the less the kink weighs.
constexpr double kPartedLightsRimLeast = 0.1;

constexpr int kColourTerms = 7 << kColour, kTransmittedTerms = 7 << kTransmitted;

/// Of the terms of a pass those that F weighs with a kink, where total reflection begins.
int terms_with_rim(const Pass& pass, std::int64_t sample_count) {
    const KernelMaterial& what = pass.what.material;
    if (what.fresnel != KILN_FRESNEL_DIELECTRIC || sample_count < kPartedLightsSamplesLeast)
        return 0;
    int terms = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const double rim = -pass.parameters[c * kFresnelParameters];
        if (rim > 0 && static_cast<Importance>(what.importance) == Importance::vndf)
            terms |= 1 << (kColour + c);
        if (rim >= kPartedLightsRimLeast) terms |= 1 << (kTransmitted + c);
    }
    return terms & what.terms;
}

bool takes_parted_lights(const Pass& pass, std::size_t place) {
    return pass.lobe == Lobe::diffuse || pass.places.alpha(place) >= kPartedLightsAlphaLeast;
}

Draw parted_lights(const Pass& pass, int terms) {
    Specialisation what = pass.what;
    what.material.importance = kPartedLights;
    what.material.terms = terms;
    return {what, point_kind(what.material)};
}

/// The kernel of a pass for what the deficit's own draw does not have; with E, which puts it right.
Specialisation beside_deficit(Specialisation what) {
    what.material.terms |= 1 << kWeight;
    return what;
}

/// The kernel of a pass without some of its terms.
Specialisation without(Specialisation what, int terms) {
    if (!terms) return what;
    KernelMaterial& material = what.material;
    material.terms &= ~terms;
    if (!(material.terms & (kColourTerms | kTransmittedTerms)))
        material.fresnel = KILN_FRESNEL_NONE;
    if (is_on_fast_path(material)) material.general = 0;
    return what;
}

/// How a place is sampled: a set of these.
enum Way : unsigned { kByPartedLights = 1, kByVisibleLights = 2, kByDeficitApart = 4, kWays = 8 };

/// The ways that a pass knows, and which of them its places take.
class Ways {
  public:
    Ways(const Pass& pass, std::int64_t sample_count)
        : pass_(pass),
          sample_count_(sample_count),
          parted_terms_(terms_with_rim(pass, sample_count)),
          visible_lights_(knows_visible_lights(pass.what.material, sample_count)),
          deficit_apart_(draws_deficit_apart(pass.what.material)) {}

    /// Of all places together.
    unsigned count() const {
        return (parted_terms_ ? 2 : 1) * (1U + visible_lights_ + deficit_apart_);
    }

    unsigned of(std::size_t place) const {
        unsigned ways = 0;
        if (parted_terms_ && takes_parted_lights(pass_, place)) ways = kByPartedLights;
        if (!other_terms(ways)) return ways;
        if (deficit_apart_ && takes_deficit_apart(pass_, place)) return ways | kByDeficitApart;
        if (visible_lights_ && takes_visible_lights(pass_, place, sample_count_))
            return ways | kByVisibleLights;
        return ways;
    }

    Region region(unsigned ways) const {
        Region region;
        region.deficit_apart = ways & kByDeficitApart;
        region.parted_terms = pass_.what.material.terms & ~other_terms(ways);
        const Specialisation what = without(pass_.what, region.parted_terms);
        const Draw others = ways & kByVisibleLights ? visible_lights(what)
                            : region.deficit_apart  ? Draw{beside_deficit(what), pass_.points}
                                                    : Draw{what, pass_.points};
        if (what.material.terms & ~(region.deficit_apart ? kDeficitTerms : 0))
            region.draws.push_back(others);
        if (region.parted_terms) region.draws.push_back(parted_lights(pass_, region.parted_terms));
        if (region.deficit_apart) {
            const Specialisation kernel = deficit_kernel(pass_.what);
            region.draws.push_back({kernel, point_kind(kernel.material)});
        }
        return region;
    }

  private:
    int other_terms(unsigned ways) const {
        return pass_.what.material.terms & ~(ways & kByPartedLights ? parted_terms_ : 0);
    }

    const Pass& pass_;
    std::int64_t sample_count_;
    int parted_terms_;
    bool visible_lights_, deficit_apart_;
};

}  // namespace

Specialisation deficit_kernel(const Specialisation& what) {
    Specialisation kernel;
    kernel.precision = what.precision;
    kernel.material.masking = what.material.masking;
    kernel.material.importance = what.material.averaged ? kHorizonNormals : kLogTangents;
    kernel.material.averaged = what.material.averaged;
    kernel.material.terms = 1 << kDeficit;
    return kernel;
}

std::vector<Region> regions_of(const Pass& pass, std::int64_t sample_count, ThreadPool& pool) {
    const Ways ways(pass, sample_count);
    const std::size_t count = pass.places.count();
    std::vector<unsigned> of(count, 0);
    if (ways.count() > 1)
        pool.parallel_for((count + kPlacesATask - 1) / kPlacesATask, [&](std::size_t task) {
            const std::size_t end = std::min((task + 1) * kPlacesATask, count);
            for (std::size_t place = task * kPlacesATask; place < end; ++place)
                of[place] = ways.of(place);
        });
    std::array<std::vector<std::uint32_t>, kWays> places;
    for (std::size_t place = 0; place < count; ++place)
        places[of[place]].push_back(static_cast<std::uint32_t>(place));
    std::vector<Region> regions;
    for (unsigned way = kWays; way-- > 0;) {
        if (places[way].empty()) continue;
        regions.push_back(ways.region(way));
        regions.back().places = std::move(places[way]);
    }
    return regions;
}

std::vector<Specialisation> kernels_of(const Pass& pass, std::int64_t sample_count) {
    const Ways ways(pass, sample_count);
    std::set<unsigned> seen;
    for (std::size_t place = 0; place < pass.places.count() && seen.size() < ways.count(); ++place)
        seen.insert(ways.of(place));
    std::vector<Specialisation> kernels;
    for (const unsigned way : seen)
        for (const Draw& draw : ways.region(way).draws) kernels.push_back(draw.what);
    return kernels;
}

template <typename Scalar>
Launches<Scalar>::Launches(Backend& backend, ThreadPool& pool, const Pass& pass,
                           const Region& region)
    : backend_(backend),
      pool_(pool),
      pass_(pass),
      region_(region),
      parameters_(pass.parameters.begin(), pass.parameters.end()),
      points_(region.draws.size()),
      sums_(region.draws.size()) {}

template <typename Scalar>
void Launches<Scalar>::set_points(std::size_t draw, const PointSet& set) {
    points_[draw].assign(set.values.begin(), set.values.end());
}

template <typename Scalar>
void Launches<Scalar>::set_places(std::span<const std::uint32_t> places) {
    stride_ = (places.size() + kLanesMax - 1) / kLanesMax * kLanesMax;
    texels_.resize(2 * stride_);
    pool_.parallel_for((stride_ + kPlacesATask - 1) / kPlacesATask, [&](std::size_t task) {
        const std::size_t end = std::min((task + 1) * kPlacesATask, stride_);
        for (std::size_t i = task * kPlacesATask; i < end; ++i) {
            const std::size_t place = places[std::min(i, places.size() - 1)];
            texels_[i] = static_cast<Scalar>(pass_.places.NoV(place));
            texels_[stride_ + i] = static_cast<Scalar>(pass_.places.alpha(place));
        }
    });
}

template <typename Scalar>
TermSums<Scalar> Launches<Scalar>::run(std::span<const BatchRange> batches) {
    TermSums<Scalar> found;
    for (std::size_t d = 0; d < region_.draws.size(); ++d) {
        const Specialisation& what = region_.draws[d].what;
        const int terms = what.material.terms;
        const auto planes =
            static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(terms)));
        const std::size_t count = batches.size() * planes * stride_;
        Sums& sums = sums_[d];
        if (sums.count < count) sums = {std::make_unique_for_overwrite<Scalar[]>(count), count};
        backend_.run(Launch<Scalar>{what, stride_, texels_, points_[d], parameters_, batches,
                                    std::span(sums.data.get(), count)});
        std::size_t plane = 0;
        for (std::size_t t = 0; t < kTermCount; ++t) {
            if (!(terms >> t & 1)) continue;
            found.data[t] = sums.data.get() + plane++ * stride_;  // the last draw's, of several
            found.step[t] = planes * stride_;
        }
    }
    return found;
}

template class Launches<float>;
template class Launches<double>;

}  // namespace kiln
