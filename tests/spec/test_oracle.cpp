// SPDX-License-Identifier: Apache-2.0
// valijson judges the same documents by the same schema, as draft 7: what our walker and it see
// differently is an error in one of them.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
// The library is not clean under this project's warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>
#pragma GCC diagnostic pop

#include "server/spec/spec.h"
#include "tests/spec/valid_jobs.h"
#include "tests/spec/wrong_jobs.h"

namespace kiln {
namespace {

using Json = nlohmann::json;
using Adapter = valijson::adapters::NlohmannJsonAdapter;

class Oracle {
  public:
    Oracle() {
        const Json contract = Json::parse(openapi_text());
        const Json root = {{"$ref", "#/components/schemas/Job"},
                           {"components", contract["components"]}};
        valijson::SchemaParser(valijson::SchemaParser::kDraft7)
            .populateSchema(Adapter(root), schema_);
    }
    bool accepts(const std::string& text) const {
        const Json document = Json::parse(text);
        valijson::Validator validator(valijson::Validator::kStrongTypes);
        return validator.validate(schema_, Adapter(document), nullptr);
    }

  private:
    valijson::Schema schema_;
};

TEST(Oracle, AcceptsWhatIsValid) {
    const Oracle oracle;
    for (const std::string& text : test::kValidJobs) {
        EXPECT_TRUE(oracle.accepts(text)) << text;
        EXPECT_TRUE(oracle.accepts(canonical(parse_job(text)))) << text;
    }
}

TEST(Oracle, RefusesWhatTheSchemaRefuses) {
    const Oracle oracle;
    std::size_t judged_count = 0;
    for (const test::WrongJob& job : test::wrong_jobs()) {
        if (job.status != 422) continue;
        ++judged_count;
        EXPECT_EQ(oracle.accepts(job.text), !job.schema_refuses) << job.name;
    }
    EXPECT_GT(judged_count, 200u);
}

}  // namespace
}  // namespace kiln
