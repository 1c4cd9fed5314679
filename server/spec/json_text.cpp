// SPDX-License-Identifier: Apache-2.0
#include "server/spec/json_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "server/spec/spec.h"

namespace kiln {
namespace {

using Json = nlohmann::json;

[[noreturn]] void refuse(const std::string& message, const std::string& pointer = "") {
    const std::string where = pointer.empty() ? "" : " at " + in_quotes(pointer);
    throw Malformed("the document cannot be read: " + message + where, {{pointer, message}});
}

std::string place(std::string_view text, std::size_t byte_index) {
    const std::string_view before = text.substr(0, std::min(byte_index, text.size()));
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0: the first line
    return "line " + std::to_string(line) + ", column " +
           std::to_string(before.size() - line_start + 1) + " (byte " + std::to_string(byte_index) +
           ")";
}

/// The library's sentence without its prefix and without the offending text, which may be long and
/// no UTF-8.
std::string reason(const std::string& what) {
    std::string_view sentence = what;
    if (const auto start = sentence.find(": "); start != sentence.npos)
        sentence.remove_prefix(start + 2);
    return std::string(sentence.substr(0, sentence.find("; last read")));
}

/// Builds the value while it guards depth, repeated names and number range.
class Builder : public nlohmann::json_sax<Json> {
  public:
    Builder(std::string_view text, const TextLimits& limits)
        : text_(text),
          depth_max_(static_cast<std::size_t>(limits.depth_max)),
          values_max_(limits.values_max) {}
    Json take() { return std::move(root_); }

    bool null() override { return put(nullptr); }
    bool boolean(bool value) override { return put(value); }
    bool number_integer(number_integer_t value) override { return put(value); }
    bool number_unsigned(number_unsigned_t value) override { return put(value); }
    bool string(string_t& value) override { return put(std::move(value)); }
    bool binary(binary_t&) override { refuse("binary values are no JSON", pointer()); }
    bool number_float(number_float_t value, const string_t& digits) override {
        const std::string_view mantissa =
            std::string_view(digits).substr(0, digits.find_first_of("eE"));
        if (value == 0 && mantissa.find_first_of("123456789") != mantissa.npos)
            refuse("the number is too small for a double", pointer());
        return put(value);
    }
    bool start_object(std::size_t) override { return open(Json::object()); }
    bool start_array(std::size_t) override { return open(Json::array()); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }
    bool key(string_t& name) override {
        stack_.back().name = name;
        if (stack_.back().value->contains(name))
            refuse("the name " + in_quotes(name) + " stands twice in one object", pointer());
        return true;
    }
    bool parse_error(std::size_t position, const std::string&,
                     const nlohmann::detail::exception& error) override {
        const std::size_t byte_index =
            position == 0 ? 0 : position - 1;  // the library counts from 1
        if (error.id == 406)                   // out_of_range: the number overflows a double
            refuse("the number at " + place(text_, byte_index) + " is too large for a double",
                   pointer());
        if (text_.empty()) refuse("it is empty");
        refuse(place(text_, byte_index) + ": " + reason(error.what()), pointer());
    }

  private:
    struct Open {
        Json* value;
        std::optional<std::string> name;  ///< of the last member, in an object
    };

    /// Where the value being read stands, or the last one that was.
    std::string pointer() const {
        std::string result;
        for (const Open& open : stack_) {
            const bool innermost = &open == &stack_.back();  // an outer array holds its open entry
            if (open.value->is_object() && !open.name) break;
            result = join_pointer(result,
                                  open.value->is_object()
                                      ? *open.name
                                      : std::to_string(open.value->size() - (innermost ? 0 : 1)));
        }
        return result;
    }
    Json* place_value(Json&& value) {
        if (++value_count_ > values_max_)
            refuse("it has more than " + std::to_string(values_max_) + " values", pointer());
        if (stack_.empty()) return &(root_ = std::move(value));
        Json& parent = *stack_.back().value;
        if (parent.is_object()) return &(parent[*stack_.back().name] = std::move(value));
        parent.push_back(std::move(value));
        return &parent.back();
    }
    bool put(Json value) {
        place_value(std::move(value));
        return true;
    }
    bool open(Json&& value) {
        if (stack_.size() >= depth_max_)
            refuse("arrays and objects nest deeper than " + std::to_string(depth_max_) + " levels",
                   pointer());
        stack_.push_back({place_value(std::move(value)), {}});
        return true;
    }
    bool close() {
        stack_.pop_back();
        return true;
    }

    std::string_view text_;
    std::size_t depth_max_;
    std::int64_t values_max_, value_count_ = 0;
    Json root_;
    std::vector<Open> stack_;
};

}  // namespace

nlohmann::json parse_json(std::string_view text, const TextLimits& limits) {
    if (text.size() > static_cast<std::size_t>(limits.bytes_max))
        refuse("it has " + std::to_string(text.size()) + " bytes; allowed: at most " +
               std::to_string(limits.bytes_max));
    if (text.starts_with("\xEF\xBB\xBF"))
        refuse("it starts with a byte order mark (EF BB BF); send UTF-8 without one");
    // The library's lexer takes a NUL byte for the end of the text and would ignore what follows.
    if (const auto nul = text.find('\0'); nul != text.npos)
        refuse(place(text, nul) + ": a NUL byte");
    Builder builder(text, limits);
    Json::sax_parse(text.begin(), text.end(), &builder);
    return builder.take();
}

std::string in_quotes(std::string_view text) {
    constexpr std::size_t kShownBytes = 40;
    std::size_t end = std::min(text.size(), kShownBytes);
    // Not inside a UTF-8 sequence: its later bytes are 10xxxxxx.
    while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80)
        --end;
    const std::string shown =
        Json(text.substr(0, end)).dump(-1, ' ', true, Json::error_handler_t::replace);
    return end == text.size() ? shown : shown + "…";
}

std::string join_pointer(std::string_view pointer, std::string_view token) {
    std::string result(pointer);
    result += '/';
    for (const char c : token) {
        if (c == '~')
            result += "~0";
        else if (c == '/')
            result += "~1";
        else
            result += c;
    }
    return result;
}

}  // namespace kiln
