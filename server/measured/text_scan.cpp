// SPDX-License-Identifier: Apache-2.0
#include "server/measured/text_scan.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "server/base/error.h"
#include "server/measured/bounds.h"
#include "server/measured/reader.h"

namespace kiln::measured {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::string_view without_mark(std::string_view text) {
    return text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text;
}

/// Whether the commas of a line are decimal signs.
bool decimal_commas(std::string_view text) {
    if (text.find(',') == text.npos || text.find('.') != text.npos) return false;
    if (text.find_first_of(" \t;") == text.npos) return false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != ',') continue;
        const bool after_digit = i > 0 && text[i - 1] >= '0' && text[i - 1] <= '9';
        const bool before_digit = i + 1 < text.size() && text[i + 1] >= '0' && text[i + 1] <= '9';
        if (!after_digit || !before_digit) return false;
    }
    return true;
}

}  // namespace

void fail_at(const Line& line, const std::string& what) {
    throw Error("malformed_measurement", "line " + std::to_string(line.number) + ": " + what);
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

std::string lower_case(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), lower);
    return out;
}

bool same_word(std::string_view a, std::string_view b) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(),
                                              [](char x, char y) { return lower(x) == lower(y); });
}

LineScanner::LineScanner(std::string_view text) : rest_(without_mark(text)) {}

bool LineScanner::next_with_comments(Line& line) {
    if (again_) {
        again_ = false;
        line = last_;
        return true;
    }
    while (!rest_.empty()) {
        if (after_cr_ && rest_.front() == '\n') {  // the second half of a CRLF
            after_cr_ = false;
            rest_.remove_prefix(1);
            continue;
        }
        const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
        ++number_;
        last_ = {trimmed(rest_.substr(0, end)), number_};
        if (end > kLineBytesMax) fail_at(last_, "longer than " + std::to_string(kLineBytesMax));
        const bool has_end = end < rest_.size();
        after_cr_ = has_end && rest_[end] == '\r';
        rest_.remove_prefix(std::min(end + 1, rest_.size()));
        if (last_.text.empty()) continue;
        line_has_end_ = has_end || last_.text.front() == '#';
        if (last_.text.find('\0') != last_.text.npos) fail_at(last_, "a NUL byte in a text file");
        line = last_;
        return true;
    }
    return false;
}

bool LineScanner::next(Line& line) {
    while (next_with_comments(line))
        if (line.text.front() != '#') return true;
    return false;
}

Line LineScanner::expect(std::string_view what) {
    Line line;
    if (!next(line))
        throw Error("malformed_measurement", "line " + std::to_string(number_ + 1) +
                                                 ": the file ends where " + std::string(what) +
                                                 " was expected");
    return line;
}

std::optional<double> parse_number(std::string_view field) {
    if (field.starts_with('+') && !field.starts_with("+-")) field.remove_prefix(1);
    double value = 0;
    const auto [end, problem] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (end != field.data() + field.size() || field.empty()) return std::nullopt;
    // Text of a number too small for a double is a zero; one too large is refused.
    if (problem == std::errc::result_out_of_range)
        return field.find('-', 1) != field.npos ? std::optional(0.0) : std::nullopt;
    if (problem != std::errc() || !std::isfinite(value)) return std::nullopt;
    return value;
}

void parse_numbers(const Line& line, std::vector<double>& numbers) {
    numbers.clear();
    const bool decimal = decimal_commas(line.text);
    const std::string_view separators = decimal ? " \t;" : " \t;,";
    std::string_view rest = line.text;
    std::string converted;
    while (true) {
        const std::size_t start = rest.find_first_not_of(separators);
        if (start == rest.npos) return;
        rest.remove_prefix(start);
        const std::size_t length = std::min(rest.find_first_of(separators), rest.size());
        std::string_view field = rest.substr(0, length);
        rest.remove_prefix(length);
        if (decimal) {
            converted = field;
            std::replace(converted.begin(), converted.end(), ',', '.');
        }
        const auto value = parse_number(decimal ? std::string_view(converted) : field);
        if (!value)
            fail_at(line, "field " + std::to_string(numbers.size() + 1) + ", \"" +
                              plain_text(field.substr(0, 40)) + "\", is no finite number");
        numbers.push_back(*value);
    }
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> fields;
    while (true) {
        const std::size_t end = text.find(separator);
        fields.push_back(trimmed(text.substr(0, end)));
        if (end == text.npos) return fields;
        text.remove_prefix(end + 1);
    }
}

Keyed keyed(std::string_view text) {
    const std::size_t end = std::min(text.find_first_of(" \t:"), text.size());
    std::string_view value = text.substr(end);
    while (!value.empty() && (is_blank(value.front()) || value.front() == ':'))
        value.remove_prefix(1);
    return {text.substr(0, end), trimmed(value)};
}

std::vector<double> read_list(LineScanner& lines, const Line& header, std::string_view what,
                              double count_given, std::size_t count_max) {
    if (!(count_given >= 1) || count_given > static_cast<double>(count_max) ||
        count_given != std::floor(count_given))
        fail_at(header, std::string(what) + " has a count of " + in_words(count_given) + ", 1 to " +
                            std::to_string(count_max) + " are possible");
    const auto count = static_cast<std::size_t>(count_given);
    std::vector<double> all, row;
    while (all.size() < count) {
        const Line line = lines.expect(what);
        parse_numbers(line, row);
        if (row.empty()) fail_at(line, "no number of the list of " + std::string(what));
        all.insert(all.end(), row.begin(), row.end());
        if (all.size() > count)
            fail_at(line,
                    "more than " + std::to_string(count) + " numbers of " + std::string(what));
    }
    return all;
}

void warn_of_open_end(const LineScanner& lines, Understood& account) {
    if (!lines.line_has_end())
        account.warn("line " + std::to_string(lines.line_number()) +
                     " has no line end: the file may have been cut off within its last number");
}

bool line_starts(std::string_view bytes, std::string_view word, std::string_view stop) {
    std::string_view head = without_mark(bytes).substr(0, std::size_t{64} << 10);
    while (!head.empty()) {
        const std::size_t end = std::min(head.find_first_of("\r\n"), head.size());
        const std::string_view line = trimmed(head.substr(0, end));
        const auto starts = [&](std::string_view key) {
            return !key.empty() && same_word(line.substr(0, key.size()), key);
        };
        if (starts(word)) return true;
        if (starts(stop)) return false;
        head.remove_prefix(std::min(end + 1, head.size()));
    }
    return false;
}

}  // namespace kiln::measured
