// SPDX-License-Identifier: Apache-2.0
#include "client/compare.h"

#include <algorithm>
#include <cmath>

#include "client/terminal.h"

namespace kiln::client {

namespace {

std::string size_of(const Table& table) {
    return format_size(table.width, table.height) + " texels";
}

std::string names_of(const Table& table) {
    std::string text;
    for (const std::string& name : table.channels) text += (text.empty() ? "" : ", ") + name;
    return text.empty() ? "none" : text;
}

ChannelDifference difference(const std::string& name, const std::vector<float>& a,
                             const std::vector<float>& b, std::size_t width) {
    ChannelDifference result{.name = name};
    double squares = 0;
    std::size_t worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        // Equal infinities differ by nothing, though their difference is NaN.
        const double apart = a[i] == b[i] ? 0 : std::abs(double{a[i]} - double{b[i]});
        if (!std::isfinite(apart)) {
            if (result.incomparable_count++ == 0) worst = i;
            continue;
        }
        squares += apart * apart;
        if (apart > result.max) {
            result.max = apart;
            if (result.incomparable_count == 0) worst = i;
        }
    }
    const auto compared = static_cast<double>(a.size() - result.incomparable_count);
    result.rms = compared > 0 ? std::sqrt(squares / compared) : 0;
    result.x = worst % width;
    result.y = worst / width;
    result.a = a[worst];
    result.b = b[worst];
    return result;
}

}  // namespace

std::vector<ChannelStatistics> statistics_of(const Table& table) {
    std::vector<ChannelStatistics> result;
    for (std::size_t c = 0; c < table.channels.size(); ++c) {
        ChannelStatistics& channel = result.emplace_back();
        channel.name = table.channels[c];
        double sum = 0;
        for (const float value : table.planes[c]) {
            if (std::isnan(value)) {
                ++channel.nan_count;
            } else if (std::isinf(value)) {
                ++channel.infinite_count;
            } else {
                const double v = value;
                channel.min = channel.finite_count == 0 ? v : std::min(channel.min, v);
                channel.max = channel.finite_count == 0 ? v : std::max(channel.max, v);
                sum += v;
                ++channel.finite_count;
            }
        }
        if (channel.finite_count != 0)
            channel.mean = sum / static_cast<double>(channel.finite_count);
    }
    return result;
}

bool Comparison::within(double max_error) const {
    return mismatch.empty() && std::all_of(channels.begin(), channels.end(), [&](const auto& c) {
               return c.incomparable_count == 0 && c.max <= max_error;
           });
}

Comparison compare(const Table& a, const Table& b) {
    if (a.width != b.width || a.height != b.height)
        return {.mismatch = "one has " + size_of(a) + ", the other " + size_of(b), .channels = {}};
    std::vector<std::string> names_a = a.channels, names_b = b.channels;
    std::sort(names_a.begin(), names_a.end());
    std::sort(names_b.begin(), names_b.end());
    if (names_a != names_b)
        return {.mismatch = "one has channels " + names_of(a) + ", the other " + names_of(b),
                .channels = {}};
    Comparison result;
    for (std::size_t c = 0; c < a.channels.size(); ++c) {
        const auto other = std::find(b.channels.begin(), b.channels.end(), a.channels[c]);
        const auto& plane = b.planes[static_cast<std::size_t>(other - b.channels.begin())];
        result.channels.push_back(difference(a.channels[c], a.planes[c], plane, a.width));
    }
    return result;
}

}  // namespace kiln::client
