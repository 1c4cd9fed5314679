// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "server/spec/contract.h"
#include "server/spec/limits.h"
#include "server/spec/problem_document.h"
#include "server/spec/spec.h"
#include "tests/spec/wrong_jobs.h"

namespace kiln {
namespace {

struct Refusal {
    int status = 200;
    std::string detail;
    std::vector<Problem> problems;
};

Refusal refusal(const std::string& text) {
    try {
        parse_job(text);
        return {};
    } catch (const Malformed& error) {
        return {400, error.what(), error.problems};
    } catch (const InvalidJob& error) {
        return {422, error.what(), error.problems};
    }
}

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text)
        result += (c == '"' || c == '\\') ? std::string{'\\', c} : std::string{c};
    return result;
}

bool printable_utf8(const std::string& text) {
    const bool has_control = std::any_of(text.begin(), text.end(), [](char c) {
        return static_cast<unsigned char>(c) < 0x20;  // the C0 controls
    });
    return !has_control && nlohmann::json::accept('"' + escaped(text) + '"');
}

TEST(WrongJobs, CorpusIsLargeEnough) { EXPECT_GE(test::wrong_jobs().size(), 300u); }

TEST(WrongJobs, EachIsRefusedWhereItIsWrong) {
    for (const test::WrongJob& job : test::wrong_jobs()) {
        SCOPED_TRACE(job.name);
        const Refusal answer = refusal(job.text);
        EXPECT_EQ(answer.status, job.status);
        EXPECT_EQ(answer.problems.size(), job.problem_count);
        EXPECT_TRUE(std::any_of(answer.problems.begin(), answer.problems.end(),
                                [&](const Problem& p) { return p.pointer == job.pointer; }))
            << "none at " << job.pointer << "; " << answer.detail;
    }
}

TEST(WrongJobs, MessagesAreBoundedAndFitForATerminal) {
    for (const test::WrongJob& job : test::wrong_jobs()) {
        SCOPED_TRACE(job.name);
        const Refusal answer = refusal(job.text);
        EXPECT_TRUE(printable_utf8(answer.detail)) << answer.detail;
        EXPECT_LT(answer.detail.size(),
                  1000u);  // some 20 field names, and a quotation of 40 characters
        for (const Problem& problem : answer.problems) {
            EXPECT_GT(problem.message.size(), 5u);
            EXPECT_LT(problem.message.size(), 1000u);
            EXPECT_TRUE(printable_utf8(problem.message)) << problem.message;
        }
    }
}

TEST(WrongJobs, ProblemDocumentsKeepTheContract) {
    for (const test::WrongJob& job : test::wrong_jobs()) {
        const Refusal answer = refusal(job.text);
        const std::string text = problem_document("invalid_job", answer.status, "Refused",
                                                  answer.detail, answer.problems);
        const auto broken = contract_problems("Problem", text);
        EXPECT_TRUE(broken.empty())
            << job.name << ": " << broken[0].pointer << " " << broken[0].message;
    }
    EXPECT_EQ(contract_problems("Problem", R"({"type":"about:blank"})").size(), 5u);
}

TEST(WrongJobs, RangesAreNamed) {
    const auto message = [](const std::string& text) {
        return refusal(text).problems.at(0).message;
    };
    EXPECT_EQ(message(R"({"quantities":["average_albedo"],"resolution":[0]})"),
              "is 0; must be in 1…4096 texels");
}

TEST(WrongJobs, NearMissesGetASuggestion) {
    const auto message = [](const std::string& text) {
        return refusal(text).problems.at(0).message;
    };
    EXPECT_NE(message(R"({"quantities":["average_albedo"],"samplr":"lattice"})")
                  .find("did you mean \"sampler\"?"),
              std::string::npos);
    EXPECT_NE(message(R"({"quantities":["average_albedo"],"samples":3})")
                  .find("did you mean \"sample_count\"?"),
              std::string::npos);
    EXPECT_EQ(message(R"({"quantities":["average_albedo"],"callback":1})").find("did you mean"),
              std::string::npos);
    const auto metal = [&](const std::string& name) {
        return message(R"({"quantities":["fresnel_average"],"fresnel":{"model":"conductor",)"
                       R"("metal":")" +
                       name + "\"}}");
    };
    // Edits: 1; 2, neighbours that changed places; 4 of ten letters; 3 of six.
    EXPECT_NE(metal("aluminum").find("did you mean \"aluminium\"?"), std::string::npos);
    EXPECT_NE(metal("iorn").find("did you mean \"iron\"?"), std::string::npos);
    EXPECT_EQ(metal("adamantium").find("did you mean"), std::string::npos);
    EXPECT_EQ(metal("bronze").find("did you mean"), std::string::npos);
}

TEST(WrongJobs, AllProblemsComeAtOnce) {
    const Refusal answer = refusal(R"({
        "quantities": ["split_sum_scale", "brdf", "split_sum_scale"], "resolution": [0, 5000],
        "layout": "blender",
        "sample_count": 0, "sampler": "halton", "seed": -1, "spp": 64, "precision": 32,
        "microfacet": {"distribution": "phong", "masking": "cook", "alpha": 1},
        "output": {"format": "png", "pixel": "half"}})");
    std::vector<std::string> pointers;
    for (const Problem& problem : answer.problems) pointers.push_back(problem.pointer);
    std::sort(pointers.begin(), pointers.end());
    const std::vector<std::string> expected = {"/layout",
                                               "/microfacet/alpha",
                                               "/microfacet/distribution",
                                               "/microfacet/masking",
                                               "/output/pixel",
                                               "/precision",
                                               "/quantities/1",
                                               "/quantities/2",
                                               "/resolution/0",
                                               "/resolution/1",
                                               "/sample_count",
                                               "/sampler",
                                               "/seed",
                                               "/spp"};
    EXPECT_EQ(pointers, expected);
}

TEST(WrongJobs, ProblemsAreBoundedAndTheRestCounted) {
    std::string text = R"({"quantities":["average_albedo"])";
    for (int i = 0; i < 5000; ++i) text += ",\"x" + std::to_string(i) + "\":1";
    const Refusal answer = refusal(text + "}");
    const auto most = static_cast<std::size_t>(limits().problems_max);
    ASSERT_EQ(answer.problems.size(), most + 1);
    EXPECT_EQ(answer.problems.back().message,
              "and " + std::to_string(5000 - most) + " more problems");
}

TEST(WrongJobs, SyntaxErrorsNameLineColumnAndByte) {
    const Refusal answer = refusal("{\n  \"seed\": 1,\n  \"kind\": NaN\n}");
    EXPECT_NE(answer.detail.find("line 3, column 11 (byte 25)"), std::string::npos)
        << answer.detail;
}

}  // namespace
}  // namespace kiln
