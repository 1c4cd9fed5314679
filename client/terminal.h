// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kiln::client {

enum class ProgressMode { automatic, bar, plain, json, none };

/// What standard error can show.
struct Terminal {
    bool interactive = false;  ///< a terminal that moves its cursor (TERM is not "dumb")
    bool colour = false;       ///< interactive, and NO_COLOR is not set
    bool utf8 = false;
    int columns = 80;
};
Terminal standard_error();

/// Text from a file or a server with its control characters shown as \xNN, so that it cannot steer
/// a terminal.
std::string printable(std::string_view text);

/// One line to standard error.
void say(const std::string& line);

/// `text` in bold or dim where the terminal has colours.
std::string bold(const Terminal& terminal, const std::string& text);
std::string dim(const Terminal& terminal, const std::string& text);

/// Lines of left-aligned first and right-aligned further columns, two blanks between.
std::vector<std::string> columns(const std::vector<std::vector<std::string>>& rows);

/// 256 x 1; 4 x 15 (3 slices of 4 x 5)
std::string format_size(std::size_t width, std::size_t height, std::size_t slices = 1);
std::string format_bytes(std::size_t count);  ///< 197 kB
std::string format_seconds(double seconds);   ///< 21 ms, 1.2 s, 3 min 05 s
std::string format_error(double value);       ///< 2.1e-04; 0 for zero
std::string format_number(double value);      ///< six significant digits

struct Stage {
    std::string state;    ///< "queued" or "running"
    double fraction = 0;  ///< 0…1
    std::optional<double> standard_error_max;
};

/// Tells on standard error how far a bake is: a bar, lines for people, JSON lines for programs, or
/// nothing.
class ProgressView {
  public:
    explicit ProgressView(ProgressMode mode);
    ~ProgressView() { clear(); }
    ProgressView(const ProgressView&) = delete;
    ProgressView& operator=(const ProgressView&) = delete;

    void update(const Stage& stage);
    /// Wipes the bar; call before other text goes to the terminal.
    void clear();

  private:
    using Clock = std::chrono::steady_clock;
    void draw_bar(const Stage& stage, double elapsed_s);
    bool due(const Stage& stage, double elapsed_s);

    ProgressMode mode_;
    Terminal terminal_;
    Clock::time_point start_ = Clock::now();
    double last_s_ = -1;  ///< of the last output, since start_; negative before the first
    double last_fraction_ = 0;
    std::string last_state_;
    bool drawn_ = false;
};

}  // namespace kiln::client
