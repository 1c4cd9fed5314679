// SPDX-License-Identifier: Apache-2.0
// Advice on Charlie, whose E has no bound at NoV = 0 or at roughness 0: a texel of nodes stands
// there, none of centres does.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/compute/advice.h"
#include "server/compute/native.h"
#include "server/spec/spec.h"

namespace kiln {
namespace {

std::vector<Candidate> advice_on(const std::string& job, double max_error) {
    ThreadPool pool(0);
    const auto native = make_native_backend(pool, usable_instruction_sets().front());
    return advise(parse_job("{" + job + "}"), max_error, *native, pool, Control{});
}

/// NoV and roughness from 0 to so little that a table of 8 x 8 has all there is.
std::string sheen_up_to(const char* most) {
    const std::string range = R"("range":[0,)" + std::string(most) + "]}";
    return R"("quantities":["sheen_albedo"],"resolution":[32,32],)"
           R"("layout":{"x":{"parameter":"NoV",)" +
           range + R"(,"y":{"parameter":"roughness",)" + range + "}";
}

TEST(AdviceAtPoles, PassesOverGridsWithOne) {
    const auto candidates = advice_on(R"("quantities":["sheen_albedo"],"resolution":[32,32])", 1e3);
    ASSERT_FALSE(candidates.empty());
    for (const Candidate& candidate : candidates)
        EXPECT_EQ(candidate.job.axes[0].grid, Grid::center);
}

// In float 1e-30 is as good as 0 to Charlie; Unity's layout is of nodes, and advice leaves it so.
TEST(AdviceAtPoles, RefusesWhereAllGridsHaveOne) {
    for (const std::string& job :
         {sheen_up_to("1e-30"),
          std::string(R"("quantities":["sheen_albedo"],"resolution":[32,32],"layout":"unity")")}) {
        try {
            const auto candidates = advice_on(job, 1e3);
            ADD_FAILURE() << candidates.size() << " candidates: " << job;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), "non_finite") << job;
            EXPECT_NE(std::string(error.what()).find("let the NoV axis start above 0"),
                      std::string::npos)
                << error.what();
        }
    }
}

// Centres were looked at, and their float32 is beyond the bound at any size.
TEST(AdviceAtPoles, IsEmptyWhereAGridWithoutOneIsNotEnough) {
    EXPECT_FALSE(advice_on(sheen_up_to("1e-5"), 1e-2).empty());
    EXPECT_TRUE(advice_on(sheen_up_to("1e-5"), 1e-3).empty());
}

}  // namespace
}  // namespace kiln
