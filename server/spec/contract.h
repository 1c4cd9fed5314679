// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string_view>
#include <vector>

#include "server/spec/spec.h"

namespace kiln {

/// Reads the embedded contract and holds it against the code: only keywords that the schema walker
/// knows, every default valid, every closed set equal to its words. Throws Error("contract").
/// Programs call it first.
void check_contract();

/// What is wrong with `text` as the contract's component schema `component` ("Report", "JobStatus",
/// …). Throws Malformed when it is not JSON, Error("contract") when there is no such component.
std::vector<Problem> contract_problems(std::string_view component, std::string_view text);

/// What of a diffuse model is no fault, since it was published so: x-kiln-known beside its word.
struct KnownOfModel {
    bool exceeds_one, negative, not_reciprocal;
};
KnownOfModel known_of(DiffuseModel model);

/// The embedded document, parsed and checked.
const nlohmann::json& contract();

}  // namespace kiln
