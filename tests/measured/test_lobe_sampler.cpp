// SPDX-License-Identifier: Apache-2.0
// Samplers of measured lobes: directions that are drawn, against the density that is claimed.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "server/base/error.h"
#include "server/measured/lobe_sampler.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kCosines = 16, kAzimuths = 24, kDrawn = 100000;

LobeTables tables_of(const synthetic::Material& surface) {
    synthetic::MiniDiffGrid grid;
    grid.azimuth_step = grid.radial_step = 3;
    Reading reading = read_measurement(synthetic::minidiff_file(surface, grid));
    return make_lobe_tables(Material(reading.components[0], {}, reading.understood));
}

std::size_t bin_of(Vec out) {
    const double turn = phi_of(out) < 0 ? phi_of(out) + 360 : phi_of(out);
    const auto row = std::min(static_cast<std::size_t>(out.z * kCosines), kCosines - 1);
    return row * kAzimuths +
           std::min(static_cast<std::size_t>(turn / 360 * kAzimuths), kAzimuths - 1);
}

/// Integral of a density over each bin by midpoints; what is missing from 1 is the last.
template <typename Pdf>
std::vector<double> expected_of(const Pdf& pdf) {
    constexpr std::size_t kSteps = 40;
    std::vector<double> expected(kCosines * kAzimuths + 1);
    double sum = 0;
    for (std::size_t r = 0; r < kCosines * kSteps; ++r)
        for (std::size_t a = 0; a < kAzimuths * kSteps; ++a) {
            const double cosine = (static_cast<double>(r) + 0.5) / (kCosines * kSteps);
            const double phi = 360 * (static_cast<double>(a) + 0.5) / (kAzimuths * kSteps);
            const double part = pdf(direction(std::acos(cosine) / kDegree, phi)) * 2 * kPi /
                                (kCosines * kSteps * kAzimuths * kSteps);
            expected[r / kSteps * kAzimuths + a / kSteps] += part;
            sum += part;
        }
    EXPECT_LT(sum, 1.003);
    expected.back() = std::max(0.0, 1 - sum);
    return expected;
}

/// How many standard deviations chi square lies above its mean (Wilson and Hilferty 1931). Bins
/// that expect fewer than ten are put together.
template <typename Sampler, typename Pdf>
double chi_square(const Sampler& sampler, const Pdf& pdf) {
    const std::vector<double> expected = expected_of(pdf);
    std::vector<double> count(expected.size());
    std::mt19937_64 random(5);
    const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    for (std::size_t n = 0; n < kDrawn; ++n) {
        const double a = uniform(), b = uniform();
        const Drawn drawn = sampler.draw(a, b);
        count[drawn.pdf > 0 ? bin_of(drawn.out) : count.size() - 1] += 1;
    }
    double chi = 0, degrees = -1, few_wanted = 0, few_found = 0;
    const auto add = [&](double found, double wanted) {
        chi += (found - wanted) * (found - wanted) / wanted;
        degrees += 1;
    };
    for (std::size_t n = 0; n < expected.size(); ++n) {
        const double wanted = expected[n] * kDrawn;
        if (wanted >= 10) {
            add(count[n], wanted);
        } else {
            few_wanted += wanted;
            few_found += count[n];
        }
    }
    if (few_wanted >= 10) add(few_found, few_wanted);
    const double part = 2 / (9 * degrees);
    return (std::cbrt(chi / degrees) - (1 - part)) / std::sqrt(part);
}

/// Light from 15 degrees elsewhere: whose density is the wrong one.
double elsewhere(double theta_in) { return std::abs(theta_in - 15); }

TEST(LobeSampler, DrawsWhatItSays) {
    for (const auto& [alpha, angles] : {std::pair(0.35, std::vector<double>{0, 35, 70}),
                                        std::pair(0.2, std::vector<double>{35})}) {
        const LobeTables tables =
            tables_of(synthetic::ggx(alpha, {0.6, 0.5, 0.4}, {0.2, 0.2, 0.2}));
        Resampler resampler;
        for (const double theta_in : angles) {
            const LobeSampler sampler(tables, theta_in, resampler);
            const LobeSampler other(tables, elsewhere(theta_in), resampler);
            EXPECT_LT(chi_square(sampler, [&](Vec out) { return sampler.pdf(out); }), 4)
                << alpha << " " << theta_in;
            EXPECT_GT(chi_square(sampler, [&](Vec out) { return other.pdf(out); }), 8)
                << alpha << " " << theta_in;
        }
    }
}

/// f cos / pdf is nearly the albedo at every sample: that is what the sampler is for.
TEST(LobeSampler, WeighsEverySampleNearlyAlike) {
    const LobeTables tables = tables_of(synthetic::ggx(0.2, {0.6, 0.5, 0.4}, {0.2, 0.2, 0.2}));
    Resampler resampler;
    const LobeSampler sampler(tables, 35, resampler);
    std::vector<Vec> out;
    std::vector<double> pdf;
    for (std::size_t n = 0; n < 4096; ++n) {
        const double b = static_cast<double>(n) * 0.6180339887498949;
        const Drawn drawn = sampler.draw((static_cast<double>(n) + 0.5) / 4096, b - std::floor(b));
        EXPECT_NEAR(sampler.pdf(drawn.out) / drawn.pdf, 1, 1e-6);
        out.push_back(drawn.out);
        pdf.push_back(drawn.pdf);
    }
    const Sampled found = resampler.values(tables, 35, out);
    double mean = 0, square = 0;
    for (std::size_t n = 0; n < out.size(); ++n) {
        const double weight = static_cast<double>(found.g[n]) * out[n].z / pdf[n];
        mean += weight / 4096;
        square += weight * weight / 4096;
    }
    const double e = resampler.albedos(tables, std::vector<double>{35})[0].value[1];
    const double spread = std::sqrt(square - mean * mean);
    EXPECT_LT(spread, 0.1 * e);
    EXPECT_NEAR(mean, e, 4 * spread / 64);
}

double ggx_D(double alpha, double theta) {
    const double c = std::cos(theta), s = std::sin(theta), bowl = c * c * alpha * alpha + s * s;
    return alpha * alpha / (kPi * bowl * bowl);
}

/// Heitz 2014: light that goes back the way it came is masked once; f = F0 D G1 / (4 cos^2).
double ggx_retro(double alpha, double f0, double theta) {
    const double c = std::cos(theta), s = std::sin(theta);
    const double g1 = 2 * c / (c + std::sqrt(c * c + alpha * alpha * s * s));
    // D over normals with cosine: in ggx_D's bowl tan is of the normal, c^2 a^2 + s^2.
    return f0 * ggx_D(alpha, theta) * g1 / (4 * c * c);
}

TEST(PowerIteration, FindsTheNormalsOfGgx) {
    for (const double alpha : {0.05, 0.2, 0.5, 0.9}) {
        const NormalDistribution found =
            power_iteration([&](double theta) { return ggx_retro(alpha, 0.6, theta); });
        EXPECT_NEAR(found.eigenvalue, 0.15, 0.15e-4) << alpha;
        for (std::size_t n = 0; n < found.theta.size(); ++n)
            EXPECT_NEAR(found.value[n] / ggx_D(alpha, found.theta[n]), 1, 1e-4)
                << alpha << " " << found.theta[n];
    }
    EXPECT_THROW(power_iteration([](double) { return 0.0; }), Error);
}

TEST(VisibleNormalSampler, DrawsWhatItSays) {
    const NormalDistribution normals =
        power_iteration([](double theta) { return ggx_retro(0.35, 0.6, theta); });
    for (const double theta_in : {0.0, 35.0, 70.0}) {
        const VisibleNormalSampler sampler(normals, theta_in);
        const VisibleNormalSampler other(normals, elsewhere(theta_in));
        EXPECT_LT(chi_square(sampler, [&](Vec out) { return sampler.pdf(out); }), 4) << theta_in;
        EXPECT_GT(chi_square(sampler, [&](Vec out) { return other.pdf(out); }), 8) << theta_in;
    }
}

}  // namespace
}  // namespace kiln
