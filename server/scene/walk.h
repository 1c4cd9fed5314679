// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/spec/schema.h"

namespace kiln {

/// A value of an untrusted document together with where it stands. Whatever is asked of it and is
/// not there is a default; whatever is there and wrong is a problem with its pointer, and a default
/// as well, so that one walk finds every problem.
class Place {
  public:
    Place(const nlohmann::json* value, std::string pointer, ProblemList& problems)
        : value_(value), pointer_(std::move(pointer)), problems_(&problems) {}

    explicit operator bool() const { return value_ != nullptr; }
    const std::string& pointer() const { return pointer_; }
    void refuse(const std::string& message) const { problems_->add(pointer_, message); }

    bool has(const char* name) const;
    /// The member, when it is an object.
    Place object(const char* name) const;
    /// The same, but whatever else stands there is nobody's fault: what glTF leaves to
    /// applications.
    Place extras(const char* name) const;
    /// The member, when it is an array of at most `count_max` entries.
    Place list(const char* name, std::size_t count_max) const;
    /// The entry of an array, when it is an object.
    Place item(std::size_t index) const;
    std::size_t size() const;
    std::vector<std::string> member_names() const;

    double number(const char* name, double fallback, double lo, double hi) const;
    std::array<double, 3> colour(const char* name, double fallback, double lo, double hi,
                                 std::size_t count = 3) const;
    /// An index below `count`; `what` names what it counts.
    std::optional<std::size_t> index(const char* name, std::size_t count, const char* what) const;
    /// A whole number of bytes.
    std::optional<std::size_t> bytes(const char* name) const;
    /// Indices below `count`, from an array of numbers.
    std::vector<std::size_t> indices(const char* name, std::size_t count, const char* what,
                                     std::size_t count_max) const;
    std::string text(const char* name, std::size_t characters_max = SIZE_MAX) const;
    /// The text itself, not copied; null where there is none.
    const std::string* text_at(const char* name) const;
    /// The id of measured data, "" where there is none.
    std::string measurement(const char* name) const;
    std::vector<std::string> texts(const char* name, std::size_t count_max) const;

  private:
    const nlohmann::json* member(const char* name) const;
    Place at(const char* name, const nlohmann::json* value) const;
    void wrong(const char* name, const nlohmann::json& value, const std::string& allowed) const;

    const nlohmann::json* value_;
    std::string pointer_;
    ProblemList* problems_;
};

}  // namespace kiln
