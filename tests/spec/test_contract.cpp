// SPDX-License-Identifier: Apache-2.0
#include "server/spec/channels.h"
#include "server/spec/contract.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "server/spec/limits.h"
#include "server/spec/schema.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"
#include "tests/spec/valid_jobs.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

std::vector<Problem> walk(const Json& schema, const Json& instance) {
    ProblemList problems(100);
    walk_schema(contract(), schema, instance, problems);
    return problems.take();
}

TEST(Contract, StartUpCheckPasses) { EXPECT_NO_THROW(check_contract()); }

TEST(Contract, IsServedByteForByte) {
    std::ifstream file(KILN_SOURCE_DIR "/api/openapi.json", std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_FALSE(text.empty());
    EXPECT_TRUE(openapi_text() == text);
}

TEST(Contract, SchemasTheWalkerWouldNotObeyAreRefused) {
    const char* refused[] = {
        R"({"pattern": "^a"})",
        R"({"properties": {"a": {"exclusiveMinimum": 0}}})",
        R"({"items": {"prefixItems": []}})",
        R"({"additionalProperties": {"format": "date"}})",
        R"({"oneOf": [{"type": "string"}, {"type": "object", "dependentRequired": {}}]})",
        R"({"oneOf": [{"type": "string"}, {"enum": ["a"]}]})",
        R"({"oneOf": [{"type": "string"}, {"type": ["null", "string"]}]})",
        R"({"$ref": "#/components/schemas/Nowhere"})",
        R"({"$ref": "https://example.org/schema"})",
        R"({"$ref": "#/components/schemas/Job", "default": {}})",
        R"(true)",
    };
    for (const char* text : refused)
        EXPECT_THROW(check_schema(contract(), Json::parse(text), "test"), Error) << text;
    EXPECT_NO_THROW(check_schema(contract(), Json::parse(R"({"type": "string"})"), "test"));
}

/// What the contract knows and this version refuses.
TEST(Contract, LaterValuesAreRefusedByName) {
    const Json later = Json::parse(R"({
        "type": "object", "additionalProperties": false,
        "properties": {"kind": {"type": "string", "enum": ["a"], "x-kiln-later": {"enum": ["b"]}}},
        "x-kiln-later": {"properties": ["more"]}})");
    const auto message = [&](const char* text) {
        return walk(later, Json::parse(text)).at(0).message;
    };
    EXPECT_EQ(message(R"({"kind":"b"})"), R"("b" is not supported yet; allowed: "a")");
    EXPECT_EQ(message(R"({"kind":"c"})"), R"("c" is not allowed; allowed: "a"; did you mean "a"?)");
    EXPECT_EQ(message(R"({"more":1})"),
              R"(the field "more" is not supported yet; allowed: "kind")");
}

TEST(Contract, AProjectionKeepsWhatTheSchemaNames) {
    const Json schema = Json::parse(R"({"type":"object","properties":{
        "a":{"type":"number","default":2},"b":{"type":"array","items":{"type":"object",
        "properties":{"c":{"type":"integer"}}}}}})");
    const Json document = Json::parse(R"({"b":[{"c":1.0,"d":[[]]},{}],"e":{"a":null}})");
    ProblemList problems(10);
    EXPECT_EQ(project_schema(contract(), schema, document, problems).dump(),
              R"({"a":2,"b":[{"c":1},{}]})");
    EXPECT_EQ(walk_schema(contract(), schema, document, problems).dump(),
              R"({"a":2,"b":[{"c":1,"d":[[]]},{}],"e":{"a":null}})");
    EXPECT_TRUE(problems.empty());
    project_schema(contract(), schema, Json::parse(R"({"b":[{"c":true}]})"), problems);
    EXPECT_EQ(problems.take().at(0).pointer, "/b/0/c");
}

TEST(Contract, EachKeywordJudges) {
    struct Case {
        const char *schema, *good, *bad;
    };
    const Case cases[] = {
        {R"({"type":"integer"})", "2.0", "2.5"},
        {R"({"type":"number"})", "2", "true"},
        {R"({"type":["number","null"]})", "null", "\"\""},
        {R"({"type":"boolean"})", "false", "0"},
        {R"({"enum":["a",null]})", "null", "\"b\""},
        {R"({"const":"a"})", "\"a\"", "\"b\""},
        {R"({"type":"integer","minimum":3})", "3", "2"},
        {R"({"type":"integer","maximum":3})", "3", "4"},
        {R"({"type":"integer","maximum":9007199254740992})", "9007199254740992",
         "9007199254740993"},
        {R"({"type":"number","minimum":0,"maximum":1})", "1", "1.0000000000000002"},
        {R"({"type":"string","minLength":2})", "\"äö\"", "\"ä\""},
        {R"({"type":"string","maxLength":2})", "\"äö\"", "\"äöü\""},
        {R"({"type":"array","minItems":1})", "[1]", "[]"},
        {R"({"type":"array","maxItems":1})", "[1]", "[1,2]"},
        {R"({"type":"array","uniqueItems":true})", "[1,2]", "[1,1.0]"},
        {R"({"type":"array","items":{"type":"null"}})", "[null]", "[0]"},
        {R"({"type":"object","required":["a"]})", R"({"a":1})", "{}"},
        {R"({"type":"object","properties":{"a":{"type":"null"}}})", R"({"a":null,"b":1})",
         R"({"a":1})"},
        {R"({"type":"object","additionalProperties":false})", "{}", R"({"a":1})"},
        {R"({"type":"object","additionalProperties":{"type":"null"}})", R"({"a":null})",
         R"({"a":1})"},
        {R"({"oneOf":[{"type":"null"},{"type":"string","maxLength":1}]})", "\"a\"", "\"ab\""},
        {R"({"oneOf":[{"type":"null"},{"type":"string"}]})", "null", "1"},
        {R"({"$ref":"#/components/schemas/JobState"})", "\"done\"", "\"Done\""},
    };
    for (const Case& c : cases) {
        EXPECT_TRUE(walk(Json::parse(c.schema), Json::parse(c.good)).empty()) << c.schema;
        EXPECT_EQ(walk(Json::parse(c.schema), Json::parse(c.bad)).size(), 1u) << c.schema;
    }
}

TEST(Contract, DefaultsAreInsertedAtEveryLevel) {
    ProblemList problems(1);
    const Json schema = Json::parse(R"({"type":"object","properties":{"a":{"type":"object",
        "properties":{"b":{"type":"integer","default":7}}},"c":{"type":"null","default":null},
        "d":{"type":"integer"}}})");
    const Json walked = walk_schema(contract(), schema, Json::parse(R"({"a":{}})"), problems);
    EXPECT_EQ(walked, Json::parse(R"({"a":{"b":7},"c":null})"));
}

TEST(Contract, EveryFieldButQuantitiesAndMeasuredHasADefault) {
    const Json canonical_job = Json::parse(canonical(parse_job(test::kContractExample)));
    EXPECT_EQ(canonical_job, Json::parse(test::kContractExample));
    for (const auto& [name, property] :
         contract()["components"]["schemas"]["Job"]["properties"].items())
        EXPECT_TRUE(canonical_job.contains(name) || name == "measured") << name;
}

TEST(Contract, ExamplesAreValid) {
    const Json& examples = contract()["components"]["schemas"]["Job"]["examples"];
    ASSERT_GE(examples.size(), 3u);
    for (const Json& example : examples) EXPECT_NO_THROW(parse_job(example.dump())) << example;
}

TEST(Contract, EveryReferenceLeadsSomewhere) {
    std::size_t reference_count = 0;
    const auto visit = [&](const auto& self, const Json& node) -> void {
        if (node.is_object() && node.contains("$ref") && node["$ref"].is_string()) {
            const std::string pointer = node["$ref"].get<std::string>().substr(1);
            EXPECT_TRUE(contract().contains(Json::json_pointer(pointer))) << pointer;
            ++reference_count;
        }
        if (!node.is_structured()) return;
        for (const Json& child : node) self(self, child);
    };
    visit(visit, contract());
    EXPECT_GT(reference_count, 50u);
}

TEST(Contract, EveryLimitOfTheDocumentIsInTheStruct) {
    const Json entries = Json::parse(limits_json());
    // Every member of Limits is an int64: one more entry than members, or one less, shows here.
    EXPECT_EQ(entries.size() * sizeof(std::int64_t), sizeof(Limits));
    for (const auto& [name, limit] : entries.items()) {
        EXPECT_TRUE(walk(contract()["components"]["schemas"]["Limit"], limit).empty()) << name;
        EXPECT_GT(limit["value"].get<std::int64_t>(), 0) << name;
    }
    EXPECT_EQ(limits().job_bytes_max, 65536);
    EXPECT_EQ(entries["job_bytes_max"]["value"], limits().job_bytes_max);
}

TEST(Contract, ComponentsJudgeResponses) {
    const std::string id(64, 'a');
    const std::string status = R"({"id":")" + id +
                               R"(","state":"queued","progress":0,"cached":false,"error":null,
                                   "links":{"self":"/v1/jobs/x"}})";
    EXPECT_TRUE(contract_problems("JobStatus", status).empty());
    EXPECT_EQ(contract_problems("JobStatus", R"({"id":"a","state":"lost","progress":2})").size(),
              6u);
    EXPECT_THROW(contract_problems("Nothing", "{}"), Error);
    EXPECT_THROW(contract_problems("Report", "{"), Malformed);
}

TEST(Words, InvertEachOther) {
    EXPECT_EQ(to_word(DeviceChoice::automatic), "auto");
    EXPECT_EQ(to_word(PixelType::float32), "float");
    EXPECT_EQ(to_word(Precision::float32), "float32");
    EXPECT_EQ(to_word(Quantity::multiscatter_albedo), "multiscatter_albedo");
    EXPECT_EQ(to_word(Masking::smith_separable), "smith_separable");
    EXPECT_EQ(to_word(PixelType::uint16), "uint16");
    EXPECT_EQ(to_word(Sampler::random), "random");
    EXPECT_EQ(to_word(Mapping::square), "square");
    EXPECT_EQ(from_word<PixelType>("uint8"), PixelType::uint8);
    EXPECT_EQ(from_word<DeviceChoice>("automatic"), std::nullopt);
    EXPECT_EQ(from_word<Sampler>(""), std::nullopt);
    EXPECT_FALSE(depends_on_NoV(Quantity::average_albedo));
    EXPECT_TRUE(depends_on_NoV(Quantity::directional_albedo));
}

}  // namespace
}  // namespace kiln
