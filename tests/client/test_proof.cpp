// SPDX-License-Identifier: Apache-2.0
#include "client/proof.h"

#include <gtest/gtest.h>

namespace kiln::client {
namespace {

FullSet full_set(std::int64_t sample_count) {
    PlanOptions options;
    options.sample_count = sample_count;
    options.diffuse = DiffuseModel::chan2018;
    return full_set_of(plan_scene(
        read_scene(R"({"materials":[{"lobes":["metal","diffuse","sheen"]}]})", {}), options));
}

/// A reference that shared the plan's samples would share their error, and not see it.
TEST(Proof, WhatIsSampledForItHasSamplesOfItsOwn) {
    const FullSet coarse = full_set(16), fine = full_set(65536);
    ASSERT_EQ(coarse.jobs.size(), 4u);
    std::size_t sampled = 0;
    for (std::size_t i = 0; i < coarse.jobs.size(); ++i) {
        if (coarse.jobs[i].integrator == Integrator::quadrature) continue;
        ++sampled;
        EXPECT_EQ(coarse.jobs[i], fine.jobs[i]);
        EXPECT_LE(coarse.jobs[i].target_error.value(), 1e-3);
    }
    EXPECT_EQ(sampled, 1u) << "chan2018; quadrature has the others";
}

}  // namespace
}  // namespace kiln::client
