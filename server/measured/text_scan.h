// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kiln::measured {

struct Understood;

/// One line of a text file without its end and without blanks around it.
struct Line {
    std::string_view text;
    std::size_t number = 0;  ///< from 1
};

/// Throws Error("malformed_measurement", "line N: …").
[[noreturn]] void fail_at(const Line& line, const std::string& what);

/// Walks the lines of a text file: CR, LF and CRLF end a line, a UTF-8 byte order mark is skipped.
/// Throws for a line longer than kLineBytesMax and for a NUL byte.
class LineScanner {
  public:
    explicit LineScanner(std::string_view text);
    /// The next line that is neither empty nor a comment (its first byte '#'); false at the end.
    bool next(Line& line);
    /// The same with comments.
    bool next_with_comments(Line& line);
    /// Gives the last line once more.
    void put_back() { again_ = true; }
    /// The next line. Throws if the file ends, saying what was expected.
    Line expect(std::string_view what);
    std::size_t line_number() const { return number_; }
    /// Whether the last line that was given has an end: without one a number in it may be cut.
    bool line_has_end() const { return line_has_end_; }

  private:
    std::string_view rest_;
    std::size_t number_ = 0;
    Line last_;
    bool again_ = false;
    bool after_cr_ = false;
    bool line_has_end_ = true;
};

/// The numbers of a line, separated by blanks, tabs, semicolons or commas. A comma is a decimal
/// sign where other separators stand too, none touches a blank and no point occurs. Throws, with
/// the line and the field, for what is no finite number.
void parse_numbers(const Line& line, std::vector<double>& numbers);

/// A finite number that is all of `field`, or nothing. Accepts a leading '+'.
std::optional<double> parse_number(std::string_view field);

/// The fields of a line between single separators, blanks around each removed.
std::vector<std::string_view> split(std::string_view text, char separator);

/// The word at the start of a line, up to a blank, tab or colon; and what follows these.
struct Keyed {
    std::string_view key, value;
};
Keyed keyed(std::string_view text);

bool same_word(std::string_view a, std::string_view b);  ///< ignoring the case of ASCII
std::string_view trimmed(std::string_view text);
std::string lower_case(std::string_view text);

/// `count` numbers over one or more lines after `line`. Throws where more come or fewer.
std::vector<double> read_list(LineScanner& lines, const Line& header, std::string_view what,
                              double count_given, std::size_t count_max);

/// Warns where the last line read has no end: of a format without a closing mark that is all that a
/// cut within the last number leaves.
void warn_of_open_end(const LineScanner& lines, Understood& account);

/// True if a line of the first 64 KiB starts with `word` before a line that starts with `stop`.
bool line_starts(std::string_view bytes, std::string_view word, std::string_view stop = {});

}  // namespace kiln::measured
