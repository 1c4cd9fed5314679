// SPDX-License-Identifier: Apache-2.0
#include "server/spec/settings.h"

#include <gtest/gtest.h>

#include "server/spec/batch.h"
#include "server/spec/limits.h"
#include "server/spec/spec.h"

namespace kiln {
namespace {

const std::string kJob = R"({"quantities":["average_albedo"],"seed":1,"layout":"kiln"})";

TEST(Settings, ReplaceAddAndNest) {
    EXPECT_EQ(apply_settings("{}", {"seed=7"}), R"({"seed":7})");
    EXPECT_EQ(apply_settings("{}", {"output.format=png", "output.pixel=uint8"}),
              R"({"output":{"format":"png","pixel":"uint8"}})");
    EXPECT_EQ(apply_settings("{}", {"resolution=[64, 64]", "resolution.1=32"}),
              R"({"resolution":[64,32]})");
    EXPECT_EQ(apply_settings("{}", {"seed=1", "seed=2"}), R"({"seed":2})");
    EXPECT_EQ(apply_settings("{}", {R"(layout={"x":{"parameter":"alpha"}})"}),
              R"({"layout":{"x":{"parameter":"alpha"}}})");
    EXPECT_EQ(
        apply_settings("{}", {"target_error=null", "a=true", "b=\"7\"", "c=", "d=x=y", "e=NaN"}),
        R"({"a":true,"b":"7","c":"","d":"x=y","e":"NaN","target_error":null})");
    EXPECT_EQ(parse_job(apply_settings(kJob, {"seed=9", "resolution=[64]"})).seed, 9u);
}

TEST(Settings, WhatCannotBeAppliedIsNamed) {
    const char* wrong[] = {"seed",
                           "=1",
                           ".=1",
                           "a..b=1",
                           "output.=1",
                           "seed.x=1",
                           "layout.x=1",
                           "quantities.1=x",
                           "quantities.x=x",
                           "quantities.-1=x",
                           "resolution=[64,64",
                           "x={\"a\":1,\"a\":2}",
                           "x=\"open",
                           "x=[1e999]",
                           "seed=\xff",
                           "a\xff=1"};
    for (const char* setting : wrong) {
        try {
            apply_settings(kJob, {setting});
            ADD_FAILURE() << setting << " was applied";
        } catch (const Malformed& error) {
            EXPECT_NE(std::string(error.what()).find("the setting \""), std::string::npos)
                << error.what();
            EXPECT_EQ(error.problems.size(), 1u);
        }
    }
    std::string deep = "a";
    for (int i = 0; i < 100000; ++i) deep += ".a";
    EXPECT_THROW(apply_settings("{}", {deep + "=1"}), Malformed);
    EXPECT_THROW(apply_settings("{", {"seed=1"}), Malformed);
    EXPECT_THROW(apply_settings("[]", {"seed=1"}), Malformed);
}

TEST(Batch, SplitsIntoJobTexts) {
    const auto jobs =
        batch_jobs(R"({"jobs":[{"quantities":["average_albedo"]},{"seed":"wrong"}]})");
    ASSERT_EQ(jobs.size(), 2u);
    EXPECT_EQ(parse_job(jobs[0]), parse_job(R"({"quantities":["average_albedo"]})"));
    EXPECT_THROW(parse_job(jobs[1]), InvalidJob);
}

TEST(Batch, HoldsItsBounds) {
    const auto of = [](std::int64_t count) {
        std::string text = R"({"jobs":[{})";
        for (std::int64_t i = 1; i < count; ++i) text += ",{}";
        return text + "]}";
    };
    EXPECT_EQ(batch_jobs(of(limits().batch_jobs_max)).size(),
              static_cast<std::size_t>(limits().batch_jobs_max));
    EXPECT_THROW(batch_jobs(of(limits().batch_jobs_max + 1)), InvalidJob);
    for (const char* text : {"{}", "[]", R"({"jobs":{}})", R"({"jobs":[]})", R"({"jobs":[1]})",
                             R"({"jobs":[{}],"x":1})"})
        EXPECT_THROW(batch_jobs(text), InvalidJob) << text;
    std::string text = of(1);
    text.resize(static_cast<std::size_t>(limits().batch_bytes_max), ' ');
    EXPECT_NO_THROW(batch_jobs(text));
    EXPECT_THROW(batch_jobs(text + " "), Malformed);
    EXPECT_THROW(batch_jobs(R"({"jobs":[{"a":1,"a":2}]})"), Malformed);
}

}  // namespace
}  // namespace kiln
