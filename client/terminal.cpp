// SPDX-License-Identifier: Apache-2.0
#include "client/terminal.h"

#include <langinfo.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace kiln::client {

namespace {

std::string format(const char* pattern, double value) {
    char text[64];
    std::snprintf(text, sizeof text, pattern, value);
    return text;
}

/// Columns that UTF-8 text takes where no character is wide or combining.
std::size_t width_of(const std::string& text) {
    return static_cast<std::size_t>(
        std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

Terminal standard_error() {
    Terminal terminal;
    const char* term = std::getenv("TERM");
    const char* no_color = std::getenv("NO_COLOR");
    terminal.interactive = ::isatty(STDERR_FILENO) == 1 && term != nullptr && *term != '\0' &&
                           std::string_view(term) != "dumb";
    terminal.colour = terminal.interactive && (no_color == nullptr || *no_color == '\0');
    terminal.utf8 = std::string_view(nl_langinfo(CODESET)) == "UTF-8";
    winsize size{};
    if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
        terminal.columns = size.ws_col;
    return terminal;
}

std::string printable(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto byte = static_cast<unsigned char>(text[i]);
        const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
        const bool c1 = byte == 0xC2 && next >= 0x80 && next < 0xA0;  // U+0080…U+009F
        if (byte >= 0x20 && byte != 0x7F && !c1) {
            out += text[i];
            continue;
        }
        char escape[8];
        std::snprintf(escape, sizeof escape, "\\x%02X", c1 ? next : byte);
        out += escape;
        if (c1) ++i;
    }
    return out;
}

void say(const std::string& line) {
    const std::string text = line + "\n";
    std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
}

std::string bold(const Terminal& terminal, const std::string& text) {
    return terminal.colour ? "\x1b[1m" + text + "\x1b[0m" : text;
}

std::string dim(const Terminal& terminal, const std::string& text) {
    return terminal.colour ? "\x1b[2m" + text + "\x1b[0m" : text;
}

std::vector<std::string> columns(const std::vector<std::vector<std::string>>& rows) {
    std::vector<std::size_t> widths;
    for (const auto& row : rows)
        for (std::size_t c = 0; c < row.size(); ++c) {
            if (c == widths.size()) widths.push_back(0);
            widths[c] = std::max(widths[c], width_of(row[c]));
        }
    std::vector<std::string> lines;
    for (const auto& row : rows) {
        std::string line;
        for (std::size_t c = 0; c < row.size(); ++c) {
            const std::string pad(widths[c] - width_of(row[c]), ' ');
            if (c != 0) line += "  ";
            line += c == 0 ? row[c] + pad : pad + row[c];
        }
        while (!line.empty() && line.back() == ' ') line.pop_back();
        lines.push_back(line);
    }
    return lines;
}

std::string format_size(std::size_t width, std::size_t height, std::size_t slices) {
    const auto by = [width](std::size_t rows) {
        return std::to_string(width) + " x " + std::to_string(rows);
    };
    if (slices < 2) return by(height);
    return by(height) + " (" + std::to_string(slices) + " slices of " + by(height / slices) + ")";
}

std::string format_bytes(std::size_t count) {
    const auto value = static_cast<double>(count);
    if (value < 1e3) return std::to_string(count) + " B";
    if (value < 1e6) return format("%.3g kB", value / 1e3);
    if (value < 1e9) return format("%.3g MB", value / 1e6);
    return format("%.3g GB", value / 1e9);
}

std::string format_seconds(double seconds) {
    if (seconds < 0.0995) return format("%.3g ms", std::round(seconds * 1e4) / 10);
    if (seconds < 9.95) return format("%.2g s", seconds);
    if (seconds < 120) return format("%.0f s", seconds);
    return format("%.0f min ", std::floor(seconds / 60)) +
           format("%02.0f s", std::floor(std::fmod(seconds, 60)));
}

std::string format_error(double value) { return value == 0 ? "0" : format("%.1e", value); }

std::string format_number(double value) { return format("%.6g", value); }

ProgressView::ProgressView(ProgressMode mode) : mode_(mode), terminal_(standard_error()) {
    if (mode_ == ProgressMode::automatic)
        mode_ = terminal_.interactive ? ProgressMode::bar : ProgressMode::plain;
    else if (mode_ == ProgressMode::bar && !terminal_.interactive)
        mode_ = ProgressMode::plain;
}

bool ProgressView::due(const Stage& stage, double elapsed_s) {
    const double since = elapsed_s - std::max(last_s_, 0.0);
    switch (mode_) {
        case ProgressMode::bar:  // ten a second; nothing for what is done before an eye can follow
            return elapsed_s > 0.25 && (last_s_ < 0 || since >= 0.1);
        case ProgressMode::plain:  // a log wants few lines: every tenth, but not more than one a
                                   // second
            return since >= 1 && (stage.state != last_state_ || since >= 10 ||
                                  stage.fraction - last_fraction_ >= 0.1);
        case ProgressMode::json:
            return last_s_ < 0 || stage.state != last_state_ || since >= 0.5;
        default:
            return false;
    }
}

void ProgressView::update(const Stage& stage) {
    const double elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
    if (!due(stage, elapsed_s)) return;
    last_s_ = elapsed_s;
    last_fraction_ = stage.fraction;
    last_state_ = stage.state;
    const bool known = stage.standard_error_max && std::isfinite(*stage.standard_error_max);
    if (mode_ == ProgressMode::bar) {
        draw_bar(stage, elapsed_s);
    } else if (mode_ == ProgressMode::plain) {
        say("kiln: " + stage.state + ", " + format("%.0f %%", std::floor(100 * stage.fraction)) +
            (known ? ", largest standard error " + format_error(*stage.standard_error_max) : ""));
    } else {
        say("{\"event\":\"progress\",\"state\":\"" + stage.state +
            "\",\"progress\":" + format("%.4f", stage.fraction) + ",\"standard_error_max\":" +
            (known ? format("%.6g", *stage.standard_error_max) : std::string("null")) +
            ",\"elapsed_s\":" + format("%.3f", elapsed_s) + "}");
    }
}

void ProgressView::draw_bar(const Stage& stage, double elapsed_s) {
    const std::string head = stage.state == "queued" ? "queued " : "baking ";
    std::string tail = format(" %3.0f %%", std::floor(100 * stage.fraction));
    const auto add = [&](const std::string& text) {  // a line that wraps could not be wiped
        if (head.size() + tail.size() + text.size() < static_cast<std::size_t>(terminal_.columns))
            tail += text;
    };
    // An estimate from the first few percent swings too widely to help.
    if (stage.fraction > 0.03 && stage.fraction < 1)
        add("  " + format_seconds(elapsed_s * (1 - stage.fraction) / stage.fraction) + " left");
    if (stage.standard_error_max && std::isfinite(*stage.standard_error_max))
        add("  max error " + format_error(*stage.standard_error_max));
    const int room = terminal_.columns - 1 - static_cast<int>(head.size() + tail.size());
    const int cells = std::clamp(room, 0, 40);
    const int full = static_cast<int>(std::lround(std::clamp(stage.fraction, 0.0, 1.0) * cells));

    std::string done, rest;
    for (int i = 0; i < full; ++i) done += terminal_.utf8 ? "━" : "#";
    for (int i = full; i < cells; ++i) rest += terminal_.utf8 ? "─" : ".";
    if (terminal_.colour) done = "\x1b[33m" + done + "\x1b[0m";
    const std::string line = "\r\x1b[2K" + head + done + dim(terminal_, rest) + tail;
    std::fwrite(line.data(), 1, line.size(), stderr);
    std::fflush(stderr);
    drawn_ = true;
}

void ProgressView::clear() {
    if (!drawn_) return;
    std::fputs("\r\x1b[2K", stderr);
    std::fflush(stderr);
    drawn_ = false;
}

}  // namespace kiln::client
