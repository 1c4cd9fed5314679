// SPDX-License-Identifier: Apache-2.0
#include "tests/spec/wrong_jobs.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

namespace kiln::test {
namespace {

using Json = nlohmann::json;

std::string from_base64(std::string_view digits) {
    constexpr std::string_view kAlphabet =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned bits = 0;
    int bit_count = 0;
    for (const char digit : digits) {
        if (digit == '=') break;
        const auto value = kAlphabet.find(digit);
        if (value == kAlphabet.npos) throw std::runtime_error("wrong_jobs.json: no base64");
        bits = (bits << 6 | static_cast<unsigned>(value)) & 0xFFFF;  // at most 14 bits are pending
        bit_count += 6;
        if (bit_count < 8) continue;
        bit_count -= 8;
        bytes += static_cast<char>(bits >> bit_count & 0xFF);
    }
    return bytes;
}

std::string text_of(const Json& entry) {
    if (entry.contains("text")) return entry["text"].get<std::string>();
    if (entry.contains("base64")) return from_base64(entry["base64"].get<std::string>());
    std::string text;
    for (const Json& part : entry.at("parts")) {
        for (int i = 0; i < part.at(1).get<int>(); ++i) text += part.at(0).get<std::string>();
    }
    return text;
}

}  // namespace

std::vector<WrongJob> wrong_jobs() {
    std::ifstream file(KILN_SOURCE_DIR "/tests/spec/wrong_jobs.json");
    std::vector<WrongJob> jobs;
    for (const Json& entry : Json::parse(file)) {
        jobs.push_back({.name = entry.at("name"),
                        .text = text_of(entry),
                        .status = entry.at("status"),
                        .pointer = entry.at("pointer"),
                        .problem_count = entry.value("problems", std::size_t{1}),
                        .schema_refuses = entry.value("schema", true)});
    }
    return jobs;
}

}  // namespace kiln::test
