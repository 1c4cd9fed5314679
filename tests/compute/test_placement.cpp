// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/compute/against_reference.h"

namespace kiln {
namespace {

using namespace against_reference;

struct Placement {
    const char* name;
    Axis x, y;
};

std::vector<Placement> placements() {
    const Axis NoV = axis(Parameter::NoV), roughness = axis(Parameter::roughness);
    const auto flipped = [](Axis a) {
        a.flip = true;
        return a;
    };
    const auto between = [](Axis a, double lo, double hi) {
        a.lo = lo;
        a.hi = hi;
        return a;
    };
    return {
        {"center", NoV, roughness},
        {"node", axis(Parameter::NoV, Grid::node), axis(Parameter::roughness, Grid::node)},
        {"flip_x", flipped(NoV), roughness},
        {"flip_y", NoV, flipped(roughness)},
        {"flip_both_nodes", flipped(axis(Parameter::NoV, Grid::node)),
         flipped(axis(Parameter::roughness, Grid::node))},
        {"sqrt_NoV", axis(Parameter::NoV, Grid::node, Mapping::sqrt), roughness},
        {"square_NoV", axis(Parameter::NoV, Grid::center, Mapping::square), roughness},
        {"sqrt_roughness", NoV, axis(Parameter::roughness, Grid::center, Mapping::sqrt)},
        {"alpha", NoV, axis(Parameter::alpha)},
        {"alpha_square", NoV, axis(Parameter::alpha, Grid::node, Mapping::square)},
        {"transposed", axis(Parameter::roughness, Grid::node), NoV},
        {"transposed_alpha", flipped(axis(Parameter::alpha)), axis(Parameter::NoV, Grid::node)},
        {"range", between(NoV, .2, .7), between(roughness, .3, .9)},
        {"range_sqrt", between(axis(Parameter::NoV, Grid::center, Mapping::sqrt), .1, .8),
         between(axis(Parameter::roughness, Grid::node, Mapping::square), .25, .75)},
    };
}

/// Largest difference between two tables.
double distance(const Values& a, const Values& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
    return largest;
}

void PrintTo(const Placement& placement, std::ostream* out) { *out << placement.name; }

class EveryPlacement : public testing::TestWithParam<Placement> {};

// 16 replicates of 1024 scrambled points: a quarter of the error of the recommended recipe at best,
// its 2e-3 at worst. Any other placement, nearest the other grid, is off by more than twice that
// somewhere, or the test could not tell. Not square, so that rows and columns cannot be mixed up
// either.
TEST_P(EveryPlacement, PutsEachTexelWhereItsAxisSays) {
    JobSpec job = square_job({Quantity::split_sum_scale, Quantity::split_sum_bias}, 12, 16384);
    job.resolution = {12, 9};
    job.axes = {GetParam().x, GetParam().y};
    const Outcome outcome = bake(job);
    ASSERT_EQ(outcome.table.width, 12U);
    ASSERT_EQ(outcome.table.height, 9U);
    double nearest_wrong = 0;
    for (std::size_t channel = 0; channel < 2; ++channel) {
        const Values truth = exact(job, job.quantities[channel]);
        EXPECT_LE(compare(job, outcome, channel, truth).max, 2e-3) << channel;
        JobSpec other = job;
        for (Axis& a : other.axes) a.grid = a.grid == Grid::center ? Grid::node : Grid::center;
        nearest_wrong =
            std::max(nearest_wrong, distance(truth, exact(other, job.quantities[channel])));
    }
    EXPECT_GE(nearest_wrong, 4e-3);
}

INSTANTIATE_TEST_SUITE_P(Accuracy, EveryPlacement, testing::ValuesIn(placements()),
                         [](const auto& test) { return std::string(test.param.name); });

// The first node is NoV = 0, the first row the mirror: the limits themselves, not values nearby and
// not NaN. Every weight is then the same number, so only rounding remains.
TEST(Accuracy, NodesAtZeroAreTheLimits) {
    JobSpec job = square_job(kAll, 9, 1024);
    for (Axis& a : job.axes) a.grid = Grid::node;
    for (const Precision precision : {Precision::float32, Precision::float64}) {
        job.precision = precision;
        const Outcome outcome = bake(job);
        const auto& planes = outcome.table.planes;
        for (std::size_t i = 0; i < 9; ++i) {
            const double m = 1 - static_cast<double>(i) / 8;
            EXPECT_NEAR(planes[0][i], 1 - std::pow(m, 5), kRounding) << i;
            EXPECT_NEAR(planes[1][i], std::pow(m, 5), kRounding) << i;
            EXPECT_NEAR(planes[2][i], 1, kRounding) << i;
            EXPECT_NEAR(planes[3][i], 1, kRounding) << i;
            EXPECT_EQ(planes[4][i], 0) << i;
            EXPECT_NEAR(planes[2][9 * i], 1, kRounding) << i;  // correlated masking loses nothing
            EXPECT_NEAR(planes[4][9 * i], 0, kRounding) << i;
        }
    }
    job.masking = Masking::smith_separable;
    const Outcome outcome = bake(job);
    const double loss = 1 - 2 * (1 - std::log(2.));  // at NoV = 0, alpha = 1
    EXPECT_NEAR(outcome.table.planes[2][72], 1 - loss, 1e-2);
    EXPECT_NEAR(outcome.table.planes[4][72], loss, 1e-2);
}

}  // namespace
}  // namespace kiln
