// SPDX-License-Identifier: Apache-2.0
#include "server/http/measurement_documents.h"

#include <nlohmann/json.hpp>

#include "server/base/error.h"
#include "server/http/bounds.h"
#include "server/http/documents.h"
#include "server/spec/json_text.h"
#include "server/spec/measured_spec.h"
#include "server/spec/spec.h"

namespace kiln {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kAnswerDepth = 16;
/// Each value takes far more memory than its text.
constexpr std::int64_t kAnswerValues = 1'000'000;

std::string text_at(const nlohmann::json& object, const char* name) {
    const auto found = object.find(name);
    if (found == object.end() || !found->is_string())
        throw Error("unreadable_measurement", "the reading process gave no account");
    return found->get<std::string>();
}

Json brief(const Measurement& measurement) {
    Json unfit = nullptr;
    if (!measurement.unfit.empty()) unfit = measurement.unfit;
    return {{"id", kMeasurementPrefix + measurement.digest},
            {"bytes", measurement.bytes},
            {"uploaded", time_words(measurement.created_ms)},
            {"format", measurement.format},
            {"title", measurement.title},
            {"unfit", unfit}};
}

std::string text_of(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

ReaderAnswer read_reader_answer(std::string_view text) {
    ReaderAnswer answer;
    try {
        const nlohmann::json document = parse_json(
            text, {static_cast<std::int64_t>(kReaderAnswerBytesMax), kAnswerDepth, kAnswerValues});
        if (document.contains("code")) {
            answer.code = text_at(document, "code");
            answer.detail = text_at(document, "detail");
            return answer;
        }
        const nlohmann::json& account = document.at("account");
        answer.measurement.unfit = text_at(document, "unfit");
        answer.measurement.format = text_at(account, "format");
        answer.measurement.title = text_at(account, "title");
        answer.measurement.account = account.dump();
    } catch (const std::exception&) {
        answer = {.code = "unreadable_measurement",
                  .detail = "the process that read the file gave no account of it",
                  .measurement = {}};
    }
    return answer;
}

std::string measurement_document(const Measurement& measurement) {
    Json document = brief(measurement);
    document["readers"] = measurement.readers;
    const Json account = Json::parse(measurement.account);
    for (const auto& [name, value] : account.items())
        if (!document.contains(name)) document[name] = value;
    return text_of(document);
}

std::string measurement_page_document(const MeasurementPage& page) {
    Json list = Json::array();
    for (const Measurement& measurement : page.measurements) list.push_back(brief(measurement));
    Json next = nullptr;
    if (!page.next_cursor.empty()) next = page.next_cursor;
    return text_of({{"measurements", list}, {"next_cursor", next}});
}

std::string sidecar_document(const std::string& report) {
    const Json document = Json::parse(report);
    if (!document.contains("measured"))
        throw Error("no_sidecar",
                    "only jobs of kind slices and atlas have a side-car; this one has its "
                    "conventions in the image's metadata");
    return text_of(document["measured"]);
}

}  // namespace kiln
