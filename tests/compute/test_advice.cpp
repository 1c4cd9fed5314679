// SPDX-License-Identifier: Apache-2.0
// Advice on what is not E of GGX (that is in test_exactness.cpp): averages, diffuse lobes, Fresnel
// terms, compensation, materials, other distributions, three axes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "server/compute/advice.h"
#include "server/compute/exactness.h"
#include "server/compute/native.h"
#include "server/spec/axis_value.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"
#include "tests/reference/coupling_models.h"

namespace kiln {
namespace {

/// Rounded to 11 binary digits, as half holds values from 6e-5 on; below, to multiples of 2^-24.
float as_half(float value) {
    int exponent = 0;
    std::frexp(value, &exponent);
    const int digits = std::min(11 - exponent, 24);
    return static_cast<float>(std::ldexp(std::nearbyint(std::ldexp(value, digits)), -digits));
}

float as_pixel(float value, PixelType pixel) {
    switch (pixel) {
        case PixelType::half:
            return as_half(value);
        case PixelType::uint16:
            return std::nearbyint(value * 65535) / 65535;
        case PixelType::uint8:
            return std::nearbyint(value * 255) / 255;
        default:
            return value;
    }
}

/// The texel position at which an axis has a value, from the contract's words.
double position(const Axis& axis, std::int64_t count, double value) {
    const double low = mapped(axis, axis.lo);
    double t = (mapped(axis, value) - low) / (mapped(axis, axis.hi) - low);
    if (axis.flip) t = 1 - t;
    const auto n = static_cast<double>(count);
    return axis.grid == Grid::center ? t * n - 0.5 : t * (n - 1);
}

/// Where lookup is judged, as the contract has it: NoV and alpha from 1e-4.
double least_of(const Axis& axis) {
    const double least = axis.parameter == Parameter::NoV         ? 1e-4
                         : axis.parameter == Parameter::alpha     ? 1e-4
                         : axis.parameter == Parameter::roughness ? 1e-2
                                                                  : 0;
    return std::max(axis.lo, least);
}

using Positions = std::array<std::vector<double>, 3>;

/// Positions that have nothing to do with texels, both ends, and crowded towards the low one.
std::vector<double> scattered(const Axis& axis, std::int64_t count, int places) {
    const double low = least_of(axis);
    std::vector<double> at{position(axis, count, low), position(axis, count, axis.hi)};
    for (int i = 0; i < places; ++i) {
        const double u = std::fmod(0.5 + 0.7548776662466927 * i, 1);
        const double evenly = low + (axis.hi - low) * u;
        const double crowded = axis.hi * std::pow(std::max(low, 1e-4) / axis.hi, u);
        at.push_back(position(axis, count, i % 2 ? evenly : std::max(crowded, low)));
    }
    std::sort(at.begin(), at.end());
    at.erase(std::unique(at.begin(), at.end()), at.end());
    return at;
}

/// Around a position, within one and a half texels.
std::vector<double> around(const Axis& axis, std::int64_t count, double centre) {
    const double one = position(axis, count, least_of(axis)),
                 other = position(axis, count, axis.hi);
    const double low = std::min(one, other), high = std::max(one, other);
    std::vector<double> at;
    for (int i = -12; i <= 12; ++i) {
        const double place = std::clamp(centre + i / 8.0, low, high);
        if (at.empty() || place > at.back()) at.push_back(place);
    }
    return at;
}

/// The largest error of lookups, and where it is.
struct Worst {
    double error = 0;
    std::size_t plane = 0;
    std::array<double, 3> at{};  ///< positions
};

/// Linear lookup along up to three axes, the edge's texel beyond the outer ones.
double lookup(const std::vector<float>& plane, const JobSpec& job, std::array<double, 3> at) {
    double sum = 0;
    const std::size_t axes = job.axes.size();
    for (unsigned corner = 0; corner < 1u << axes; ++corner) {
        double weight = 1;
        std::size_t texel = 0, stride = 1;
        for (std::size_t a = 0; a < axes; ++a) {
            const auto last = static_cast<double>(job.resolution[a] - 1);
            const double held = std::clamp(at[a], 0.0, last), low = std::floor(held);
            const bool up = corner >> a & 1;
            weight *= up ? held - low : 1 - (held - low);
            texel += stride * static_cast<std::size_t>(std::min(low + up, last));
            stride *= static_cast<std::size_t>(job.resolution[a]);
        }
        sum += weight * static_cast<double>(plane[texel]);
    }
    return sum;
}

class Judge {
  public:
    Judge(Backend& native, ThreadPool& pool) : native_(native), pool_(pool) {}

    /// Channel `plane` at one place, in double.
    double exact(const JobSpec& named, std::size_t plane, const std::array<double, 3>& at) const {
        Positions positions;
        for (std::size_t a = 0; a < named.axes.size(); ++a) positions[a] = {at[a]};
        return exact_at(named, positions, 1e-8).planes[plane][0];
    }

    /// Of what was named, baked and rounded as its pixels are: first at places all over the table,
    /// then densely about the worst of them. `tolerance` of what they are held against.
    Worst worst(const JobSpec& named, double tolerance) const {
        Outcome outcome = Engine({}).run(named, Control{});
        for (auto& plane : outcome.table.planes)
            for (float& value : plane) value = as_pixel(value, named.pixel);
        Positions positions;
        for (std::size_t a = 0; a < named.axes.size(); ++a)
            positions[a] = scattered(named.axes[a], named.resolution[a], a < 2 ? 100 : 16);
        const Worst first = among(outcome.table.planes, named, positions, tolerance);
        for (std::size_t a = 0; a < named.axes.size(); ++a)
            positions[a] = around(named.axes[a], named.resolution[a], first.at[a]);
        const Worst near = among(outcome.table.planes, named, positions, tolerance);
        return near.error > first.error ? near : first;
    }

  private:
    Table exact_at(const JobSpec& named, const Positions& positions, double tolerance) const {
        JobSpec places = named;
        places.precision = Precision::float64;
        for (std::size_t a = 0; a < named.axes.size(); ++a) {
            places.axes[a].at = positions[a];
            places.axes[a].of = named.resolution[a];
            places.resolution[a] = static_cast<std::int64_t>(positions[a].size());
        }
        return exact_table(places, tolerance, native_, pool_, Control{});
    }

    Worst among(const std::vector<std::vector<float>>& planes, const JobSpec& named,
                const Positions& positions, double tolerance) const {
        const Table exact = exact_at(named, positions, tolerance);
        Worst worst;
        for (std::size_t p = 0; p < planes.size(); ++p)
            for (std::size_t i = 0; i < exact.planes[p].size(); ++i) {
                std::array<double, 3> at{};
                std::size_t rest = i;
                for (std::size_t a = 0; a < named.axes.size(); ++a) {
                    at[a] = positions[a][rest % positions[a].size()];
                    rest /= positions[a].size();
                }
                const double value = exact.planes[p][i];
                const double error = std::abs(lookup(planes[p], named, at) - value);
                if (!(error > worst.error)) continue;
                worst = {error, p, at};
            }
        return worst;
    }

    Backend& native_;
    ThreadPool& pool_;
};

/// The exact value of channel 0 where the axes have these values, by tests/reference.
using Truth = std::function<double(const std::array<double, 3>&)>;

struct Wish {
    const char* job;
    double bound;
    Truth truth;
};

reference::Microfacet ggx(double roughness) {
    return {reference::Distribution::ggx, reference::Visibility::smith_correlated,
            roughness * roughness};
}

std::vector<Wish> averages_and_diffuse_lobes() {
    using namespace reference;
    using At = std::array<double, 3>;
    return {
        {R"("quantities":["average_albedo"],"resolution":[64],)"
         R"("microfacet":{"distribution":"beckmann"})",
         1e-3,
         [](const At& at) {
             return microfacet_average(
                 {reference::Distribution::beckmann, Visibility::smith_correlated, at[0] * at[0]});
         }},
        {R"("quantities":["average_albedo"],"resolution":[64])", 1e-5,
         [](const At& at) { return microfacet_average(ggx(at[0])); }},
        {R"("quantities":["diffuse_albedo"],"resolution":[64,64],"diffuse":{"model":"burley"})",
         2e-3,
         [](const At& at) {
             return diffuse_albedo({reference::DiffuseModel::burley, at[1], 1}, at[0]);
         }},
        {R"("quantities":["diffuse_albedo"],"resolution":[64,64],"diffuse":{"model":"eon",)"
         R"("albedo":0.8})",
         1e-3,
         [](const At& at) {
             return diffuse_albedo({reference::DiffuseModel::eon, at[1], 0.8}, at[0]);
         }},
        {R"("quantities":["diffuse_albedo"],"resolution":[64,64],)"
         R"("diffuse":{"model":"oren_nayar_full"})",
         3e-3,
         [](const At& at) {
             return diffuse_albedo({reference::DiffuseModel::oren_nayar_full, at[1], 1}, at[0]);
         }},
        {R"("quantities":["diffuse_average_albedo"],"resolution":[64],)"
         R"("diffuse":{"model":"oren_nayar"})",
         1e-3,
         [](const At& at) {
             return diffuse_average({reference::DiffuseModel::oren_nayar, at[0], 1});
         }},
    };
}

std::vector<Wish> specular_terms() {
    using namespace reference;
    using At = std::array<double, 3>;
    return {
        {R"("quantities":["split_sum_bias"],"resolution":[64,64])", 6e-2,
         [](const At& at) { return microfacet_split_sum(ggx(at[1]), at[0]).bias; }},
        {R"("quantities":["specular_albedo"],"resolution":[64,64],)"
         R"("fresnel":{"model":"dielectric"})",
         4e-2,
         [](const At& at) {
             return microfacet_albedo(ggx(at[1]), at[0], fresnel_dielectric(1.5));
         }},
        {R"("quantities":["specular_albedo"],"resolution":[64,64],)"
         R"("fresnel":{"model":"dielectric"},)"
         R"("layout":{"x":{"parameter":"NoV","range":[0.2,1]},)"
         R"("y":{"parameter":"roughness","range":[0.3,1]}})",
         3e-5,
         [](const At& at) {
             return microfacet_albedo(ggx(at[1]), at[0], fresnel_dielectric(1.5));
         }},
        {R"("quantities":["compensated_albedo"],"resolution":[64,64],"multiscatter":"kulla_conty",)"
         R"("fresnel":{"model":"schlick","f0":0.04})",
         4e-2,
         [](const At& at) {
             return SpecularAlbedo(
                        {ggx(at[1]), fresnel_schlick(0.04), reference::Multiscatter::kulla_conty})
                 .at(at[0]);
         }},
        {R"("quantities":["compensated_albedo"],"resolution":[64,64],"multiscatter":"turquin",)"
         R"("fresnel":{"model":"dielectric"},"layout":{"x":{"parameter":"NoV","range":[0.2,1]},)"
         R"("y":{"parameter":"roughness","range":[0.3,1]}})",
         5e-5,
         [](const At& at) {
             return SpecularAlbedo(
                        {ggx(at[1]), fresnel_dielectric(1.5), reference::Multiscatter::turquin})
                 .at(at[0]);
         }},
    };
}

std::vector<Wish> materials_and_lobes() {
    using namespace reference;
    using At = std::array<double, 3>;
    return {
        {R"("quantities":["total_albedo"],"resolution":[64,64],"coupling":"half_vector",)"
         R"("fresnel":{"model":"dielectric"},"diffuse":{"model":"burley","albedo":0.8})",
         4e-2,
         [](const At& at) {
             return reference::Material(reference::Coupling::half_vector,
                                        {ggx(at[1]), fresnel_dielectric(1.5)},
                                        {reference::DiffuseModel::burley, at[1], 0.8})
                 .total(at[0]);
         }},
        {R"("quantities":["directional_albedo"],"resolution":[64,64],)"
         R"("microfacet":{"distribution":"beckmann"},)"
         R"("layout":{"x":{"parameter":"NoV","range":[0.1,1]},)"
         R"("y":{"parameter":"roughness","range":[0.3,1]}})",
         2e-3,
         [](const At& at) {
             return microfacet_albedo(
                 {reference::Distribution::beckmann, Visibility::smith_correlated, at[1] * at[1]},
                 at[0]);
         }},
        {R"("quantities":["sheen_albedo"],"resolution":[64,64],)"
         R"("layout":{"x":{"parameter":"NoV","range":[0.05,1]},)"
         R"("y":{"parameter":"roughness","range":[0.1,1]}})",
         1e-2,
         [](const At& at) {
             return microfacet_albedo(
                 {reference::Distribution::charlie, Visibility::neubelt, at[1] * at[1]}, at[0]);
         }},
        {R"("quantities":["directional_albedo"],"resolution":[64,64],)"
         R"("microfacet":{"distribution":"charlie","masking":"charlie"},)"
         R"("layout":{"x":{"parameter":"NoV","range":[0.3,1]},)"
         R"("y":{"parameter":"roughness","range":[0.3,1]}})",
         1e-2,
         [](const At& at) {
             return microfacet_albedo(
                 {reference::Distribution::charlie, Visibility::charlie, at[1] * at[1]}, at[0]);
         }},
    };
}

std::vector<Wish> three_axes() {
    using namespace reference;
    using At = std::array<double, 3>;
    return {
        {R"("quantities":["specular_albedo"],"resolution":[32,32,4],)"
         R"("fresnel":{"model":"dielectric"},)"
         R"("layout":{"x":{"parameter":"NoV","range":[0.1,1]},)"
         R"("y":{"parameter":"roughness","range":[0.3,1]},)"
         R"("z":{"parameter":"ior","range":[1.2,2.4],"grid":"node"}})",
         3e-2,
         [](const At& at) {
             return microfacet_albedo(ggx(at[1]), at[0], fresnel_dielectric(at[2]));
         }},
        {R"("quantities":["specular_albedo"],"resolution":[32,32,4],"fresnel":{"model":"schlick"},)"
         R"("layout":{"x":{"parameter":"NoV","range":[0.1,1]},)"
         R"("y":{"parameter":"roughness","range":[0.3,1]},)"
         R"("z":{"parameter":"f0","grid":"node"}})",
         3e-2,
         [](const At& at) { return microfacet_albedo(ggx(at[1]), at[0], fresnel_schlick(at[2])); }},
    };
}

// Each advice is taken. What its table is off by anywhere between texels, by quadrature in double
// at places of the judge's own, is within the total that was told, and the reconstruction that was
// told is at most a third above it. At the worst place tests/reference, which shares no line with
// the kernels, has the same value.
void hold(const std::vector<Wish>& wishes) {
    ThreadPool pool(0);
    const auto native = make_native_backend(pool, usable_instruction_sets().front());
    const Judge judge(*native, pool);
    for (const Wish& wish : wishes) {
        const JobSpec job = parse_job(R"({"device":"native",)" + std::string(wish.job) + "}");
        const auto candidates = advise(job, wish.bound, *native, pool, Control{});
        ASSERT_FALSE(candidates.empty()) << wish.job;
        const Candidate& best = candidates[0];
        const JobSpec named = parse_job(canonical(best.job));
        const Worst worst = judge.worst(named, std::max(1e-8, 1e-4 * wish.bound));
        std::printf(
            "%s, %g: %lld x %lld texels, %s, told %.4g (%.3g + %.3g + %.3g), true %.4g\n", wish.job,
            wish.bound, static_cast<long long>(named.resolution[0]),
            static_cast<long long>(named.resolution.at(named.resolution.size() > 1 ? 1 : 0)),
            std::string(to_word(named.pixel)).c_str(), best.total(), best.reconstruction,
            best.quantisation, best.integration, worst.error);
        EXPECT_LE(worst.error, best.total()) << wish.job;
        EXPECT_GE(worst.error, 0.75 * best.reconstruction) << wish.job;
        std::array<double, 3> at = worst.at, value{};
        for (std::size_t a = 0; a < named.axes.size(); ++a) {
            const Axis& axis = named.axes[a];
            value[a] = axis_value_between(axis, at[a], named.resolution[a]);
            // tests/reference is of alpha >= 1e-3.
            if (axis.parameter == Parameter::roughness) value[a] = std::max(value[a], 0.032);
            at[a] = position(axis, named.resolution[a], value[a]);
        }
        const double truth = wish.truth(value), exact = judge.exact(named, worst.plane, at);
        EXPECT_NEAR(truth, exact, 1e-6 * std::max(1.0, exact))
            << wish.job << " at " << value[0] << ' ' << value[1] << ' ' << value[2];
        std::fflush(stdout);
    }
}

TEST(Advice, HoldsForOtherQuantitiesAveragesAndDiffuseLobes) { hold(averages_and_diffuse_lobes()); }
TEST(Advice, HoldsForOtherQuantitiesSpecularTerms) { hold(specular_terms()); }
TEST(Advice, HoldsForOtherQuantitiesMaterialsAndLobes) { hold(materials_and_lobes()); }
TEST(Advice, HoldsForOtherQuantitiesThreeAxes) { hold(three_axes()); }

}  // namespace
}  // namespace kiln
