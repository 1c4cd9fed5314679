// SPDX-License-Identifier: Apache-2.0
// One sample in two formats: what the files differ by, and what their readers do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/measured/files.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;
using namespace measured_files;

/// Median of |ours / theirs - 1| over our points within the other's measured part; `turned` about
/// our mirror direction by half a turn first, as if the azimuth began on its other side.
double median_difference(const Incidence& ours, const Incidence& theirs, bool turned) {
    const Hemisphere hemisphere(theirs, 1);
    const Vec mirror = direction(ours.theta_i, 180);
    std::vector<double> differences;
    std::uint32_t hint = 0;
    for (std::size_t p = 0; p < ours.out.size(); ++p) {
        const Vec out = turned ? 2 * dot(ours.out[p], mirror) * mirror - ours.out[p] : ours.out[p];
        double value = 0;
        Origin origin{};
        if (usable(ours.state[p]) && hemisphere.value(out, hint, &value, origin))
            differences.push_back(std::abs(value / ours.values[p] - 1));
    }
    EXPECT_GT(differences.size(), 100u);
    std::sort(differences.begin(), differences.end());
    return differences[differences.size() / 2];
}

/// |ours / theirs - 1| at the directions that both hold, rising.
std::vector<double> same_directions(const Incidence& ours, const Incidence& theirs) {
    std::vector<double> differences;
    for (std::size_t p = 0; p < ours.out.size(); ++p)
        for (std::size_t q = 0; q < theirs.out.size(); ++q)
            if (usable(ours.state[p]) && usable(theirs.state[q]) &&
                dot(ours.out[p], theirs.out[q]) > 1 - 1e-8)
                differences.push_back(std::abs(ours.values[p] / theirs.values[q] - 1));
    std::sort(differences.begin(), differences.end());
    return differences;
}

/// The same sample in two formats, one about the mirror direction and one absolute. The two files
/// were smoothed differently by who made them: values of one direction in both differ by 2 to 9 %
/// (.0307 against .0320 at the normal, 10 degrees of incidence), so medians of 6 to 10 % are all
/// that two correct readers can have. An azimuth that begins on the wrong side gives 16 to 38 %.
TEST_F(Files, ZemaxAndFredAgreeOnOneSample) {
    const Reading zemax = reading_of("zemax/AnoBlackEC1onAlum.bsdf");
    for (const char* name : {"fred/AnoBlackEC1onAlum.txt", "fred/AnoBlackEC1onAlum_fullAz.txt"}) {
        const Reading fred = reading_of(name);
        const auto theirs = incidences_of(fred.components[0], {});
        const auto ours = incidences_of(zemax.components[0], {});
        ASSERT_EQ(ours.size(), 4u);
        ASSERT_EQ(theirs.size(), 4u);
        for (std::size_t n = 0; n < 4; ++n) {
            ASSERT_EQ(ours[n].theta_i, theirs[n].theta_i);
            EXPECT_LT(median_difference(ours[n], theirs[n], false), 0.11) << name << " " << n;
            if (n > 0) {
                EXPECT_GT(median_difference(ours[n], theirs[n], true), 0.15) << name << n;
            }
        }
    }
}

/// What is Kiln's own of that difference: one surface with a lobe like the sample's, written by
/// rules of the formats in both layouts at the angles of those files. At directions that both hold
/// the readers agree to the digits (four in one, of .006 six decimals in the other); elsewhere
/// steps of 10 degrees are interpolated: .0016, .0023, .0046 and, at the narrow peak of 70 degrees,
/// .0124 (medians).
TEST(ZemaxAndFred, OfOneKnownSurfaceAgree) {
    const auto surface = synthetic::ggx(0.35, {0.05, 0.05, 0.05}, {0.02, 0.02, 0.02});
    const auto read = [](const std::string& bytes) {
        return incidences_of(read_measurement(bytes).components[0], {});
    };
    const auto ours = read(synthetic::zemax_file(surface));
    const auto theirs = read(synthetic::fred_file(surface));
    ASSERT_EQ(ours.size(), 4u);
    ASSERT_EQ(theirs.size(), 4u);
    for (std::size_t n = 0; n < 4; ++n) {
        ASSERT_EQ(ours[n].theta_i, theirs[n].theta_i);
        const std::vector<double> same = same_directions(ours[n], theirs[n]);
        ASSERT_GT(same.size(), 20u);
        EXPECT_LT(same.back(), 5e-4 + 5e-7 / 0.005) << n;
        EXPECT_LT(median_difference(ours[n], theirs[n], false), n < 3 ? 0.007 : 0.02) << n;
    }
}

/// Where the two files have a value for one and the same direction, which is in the plane of
/// incidence, nobody interpolates: they agree to their digits at 10 and 30 degrees, and differ by
/// 3 to 4 % (median) and up to 23 % at 50 and 70. What the test above finds is theirs. Off the
/// plane a logarithmic interpolation gives the same medians as a linear one (.058 .066 .084 .115
/// against .059 .063 .085 .103), and azimuths about the mirror direction read in sines, in planes
/// or as flat angles give .13 to .25 at 50 and 70 degrees.
TEST_F(Files, ZemaxAndFredDifferWhereNobodyInterpolates) {
    const auto ours = incidences_of(reading_of("zemax/AnoBlackEC1onAlum.bsdf").components[0], {});
    const auto theirs = incidences_of(reading_of("fred/AnoBlackEC1onAlum.txt").components[0], {});
    const std::array<std::array<double, 2>, 4> medians = {
        {{0, 1e-4}, {0, 1e-3}, {0.03, 0.05}, {0.02, 0.05}}};
    for (std::size_t n = 0; n < 4; ++n) {
        const std::vector<double> differences = same_directions(ours[n], theirs[n]);
        ASSERT_GT(differences.size(), 20u);
        const double median = differences[differences.size() / 2];
        EXPECT_GE(median, medians[n][0]) << n;
        EXPECT_LE(median, medians[n][1]) << n;
        EXPECT_GT(differences.back(), n == 3 ? 0.2 : 0.03) << n;
    }
}

/// The instrument's own readings of that sample (RT, the workbook beside the files): light at 70
/// degrees, views in the plane of incidence every 5 degrees from 55, at its azimuths -90 and 90.
/// f = RT / (pi cos theta), the mean of both. Written with three digits they are good to 5e-4 to
/// 4e-3; FRED, whose angles are these, is nearer than 2e-3 (1.3e-3 seen), and Zemax, which was made
/// of them about the mirror direction, is 2.5e-2 away and more.
TEST_F(Files, FredHasTheReadingsOfTheInstrumentAndZemaxHasNot) {
    constexpr std::array<std::array<double, 2>, 6> kReadings = {
        {{.468, .422}, {.715, .639}, {1.04, .929}, {1.35, 1.22}, {1.37, 1.28}, {.989, .998}}};
    constexpr std::array<double, 6> kZemax = {.3044, .5027, .7929, 1.234, 1.437, 1.868};
    for (const bool is_fred : {true, false}) {
        const auto all = incidences_of(
            reading_of(is_fred ? "fred/AnoBlackEC1onAlum.txt" : "zemax/AnoBlackEC1onAlum.bsdf")
                .components[0],
            {});
        ASSERT_EQ(all.size(), 4u);
        ASSERT_EQ(all[3].theta_i, 70);
        for (std::size_t k = 0; k < kReadings.size(); ++k) {
            const double theta = 55 + 5 * static_cast<double>(k);
            const double reading = (kReadings[k][0] + kReadings[k][1]) / 2 /
                                   (std::numbers::pi * std::cos(theta * kDegree));
            const Vec view = direction(theta, 180);
            std::size_t found = 0;
            for (std::size_t p = 0; p < all[3].out.size(); ++p) {
                if (!usable(all[3].state[p]) || dot(all[3].out[p], view) < 1 - 1e-8) continue;
                ++found;
                const double value = all[3].values[p];
                if (is_fred)
                    EXPECT_NEAR(value, reading, 2e-3 * reading) << theta;
                else
                    EXPECT_NEAR(value, kZemax[k], 5.1e-4 * kZemax[k]) << theta;
            }
            EXPECT_GT(found, 0u) << theta;
        }
    }
}

}  // namespace
}  // namespace kiln
