// SPDX-License-Identifier: Apache-2.0
#include "server/compute/region.h"

#include <algorithm>

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
/// of E is a third to a tenth where α < .35 and NoV > α / 2, from there on it falls as N^-1.3 and
/// more; elsewhere, and of 64 points, it is not worth the price.
constexpr std::int64_t kVisibleLightsSamplesLeast = 4096;
constexpr double kVisibleLightsAlphaMost = 0.35;
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
    return alpha < kVisibleLightsAlphaMost && NoV >= alpha / 2 &&
           expected_deficit(pass.what.material, NoV, alpha) * static_cast<double>(sample_count) >=
               kVisibleLightsEventsLeast;
}

Draw visible_lights(Specialisation what) {
    what.material.importance = kVisibleLights;
    return {what, PointKind::visible_lights};
}

/// The kernel of a pass for what the deficit's own draw does not have; with E, which puts it right.
Specialisation beside_deficit(Specialisation what) {
    what.material.terms |= 1 << kWeight;
    return what;
}

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
    Region usual, rare, low;
    usual.draws = {{pass.what, pass.points}};
    const bool lights = knows_visible_lights(pass.what.material, sample_count);
    const std::size_t count = pass.places.count();
    std::vector<char> is_rare(count);
    if (draws_deficit_apart(pass.what.material)) {
        pool.parallel_for((count + kPlacesATask - 1) / kPlacesATask, [&](std::size_t task) {
            const std::size_t end = std::min((task + 1) * kPlacesATask, count);
            for (std::size_t place = task * kPlacesATask; place < end; ++place)
                is_rare[place] = takes_deficit_apart(pass, place);
        });
    }
    for (std::size_t place = 0; place < count; ++place)
        (is_rare[place]                                              ? rare
         : lights && takes_visible_lights(pass, place, sample_count) ? low
                                                                     : usual)
            .places.push_back(static_cast<std::uint32_t>(place));
    std::vector<Region> regions;
    if (!rare.places.empty()) {
        if (pass.what.material.terms & ~kDeficitTerms) {
            rare.draws = usual.draws;
            rare.draws[0].what = beside_deficit(pass.what);
        }
        const Specialisation kernel = deficit_kernel(pass.what);
        rare.draws.push_back({kernel, point_kind(kernel.material)});
        rare.deficit_apart = true;
        regions.push_back(std::move(rare));
    }
    if (!low.places.empty()) {
        low.draws = {visible_lights(pass.what)};
        regions.push_back(std::move(low));
    }
    if (!usual.places.empty()) regions.push_back(std::move(usual));
    return regions;
}

std::vector<Specialisation> kernels_of(const Pass& pass, std::int64_t sample_count) {
    std::vector<Specialisation> kernels{pass.what};
    if (knows_visible_lights(pass.what.material, sample_count))
        for (std::size_t place = 0; place < pass.places.count(); ++place)
            if (takes_visible_lights(pass, place, sample_count)) {
                kernels.push_back(visible_lights(pass.what).what);
                break;
            }
    if (!draws_deficit_apart(pass.what.material)) return kernels;
    for (std::size_t place = 0; place < pass.places.count(); ++place)
        if (takes_deficit_apart(pass, place)) {
            if (pass.what.material.terms & ~kDeficitTerms)
                kernels.push_back(beside_deficit(pass.what));
            kernels.push_back(deficit_kernel(pass.what));
            break;
        }
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
