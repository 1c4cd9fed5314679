// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "server/spec/spec.h"

namespace kiln {

/// Problems of one document, up to a bound; what is beyond is counted.
class ProblemList {
  public:
    explicit ProblemList(std::size_t count_max) : count_max_(count_max) {}

    void add(const std::string& pointer, const std::string& message);
    bool empty() const { return found_.empty(); }
    /// Further problems are only counted.
    bool full() const { return found_.size() == count_max_; }
    /// Nothing is wrong at `pointer`, above it or below it.
    bool sound(std::string_view pointer) const;
    /// The problems in the order found, closed by a count when there were more.
    std::vector<Problem> take();

  private:
    std::size_t count_max_;
    std::size_t left_out_ = 0;
    std::vector<Problem> found_;
};

/// Validates `instance` against `schema` (a part of `contract`, into which $ref points), adds every
/// problem to `problems`, and returns the instance with defaults inserted and integral numbers of
/// integer type stored as integers. What is wrong stays in it as it was: ask problems.sound()
/// first.
nlohmann::json walk_schema(const nlohmann::json& contract, const nlohmann::json& schema,
                           const nlohmann::json& instance, ProblemList& problems);

/// The same for a foreign format, of which the schema names what is read: other members of objects
/// are left out of what is returned, whatever they hold.
nlohmann::json project_schema(const nlohmann::json& contract, const nlohmann::json& schema,
                              const nlohmann::json& instance, ProblemList& problems);

/// Refuses a schema that the walker would not obey to the letter: an unknown keyword, a $ref with
/// siblings or without target, a oneOf whose branches share a type. Throws Error("contract") naming
/// the place.
void check_schema(const nlohmann::json& contract, const nlohmann::json& schema,
                  const std::string& place);

}  // namespace kiln
