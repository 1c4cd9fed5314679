// SPDX-License-Identifier: Apache-2.0
// `info`, `diff` and `devices`: what looks at files and machines and changes nothing.
#include <algorithm>
#include <cstdio>
#include <sstream>

#include "client/commands.h"
#include "client/compare.h"
#include "client/files.h"
#include "client/json.h"
#include "server/image/image.h"
#include "server/spec/spec.h"

namespace kiln::client {

namespace {

// 4096² texels of 16 float channels, uncompressed, with room to spare.
constexpr std::size_t kImageBytesMax = std::size_t{2} << 30;

void print(const std::string& line) { std::printf("%s\n", line.c_str()); }

Decoded read_image(const std::string& path) {
    const std::string bytes = read_input(path, kImageBytesMax);
    try {
        return decode(bytes);
    } catch (const Error& error) {
        throw Failure(Exit::usage, error.code(), path + ": " + error.what());
    }
}

std::string metadata_value(const Decoded& file, const std::string& key) {
    for (const auto& [name, value] : file.metadata)
        if (name == key) return value;
    return "";
}

/// In words; empty for a file without a job that this version understands.
std::vector<std::string> convention_of(const Decoded& file) {
    try {
        return convention(parse_job(metadata_value(file, "kiln.job")));
    } catch (const Error&) {
        return {};
    }
}

/// Of a table with three axes; else 1.
std::size_t slices_of(const Decoded& file) {
    try {
        const JobSpec job = parse_job(metadata_value(file, "kiln.job"));
        return job.axes.size() == 3 ? static_cast<std::size_t>(job.resolution[2]) : 1;
    } catch (const Error&) {
        return 1;
    }
}

std::string count_or_blank(std::uint64_t count) { return count == 0 ? "" : std::to_string(count); }

void print_statistics(const std::vector<ChannelStatistics>& statistics) {
    std::vector<std::vector<std::string>> rows{{"channel", "min", "max", "mean"}};
    bool nan = false, infinite = false;
    for (const ChannelStatistics& channel : statistics) {
        nan |= channel.nan_count != 0;
        infinite |= channel.infinite_count != 0;
    }
    if (nan) rows[0].push_back("NaN");
    if (infinite) rows[0].push_back("infinite");
    for (const ChannelStatistics& channel : statistics) {
        const bool any = channel.finite_count != 0;
        auto& row = rows.emplace_back();
        row = {printable(channel.name), any ? format_number(channel.min) : "-",
               any ? format_number(channel.max) : "-", any ? format_number(channel.mean) : "-"};
        if (nan) row.push_back(count_or_blank(channel.nan_count));
        if (infinite) row.push_back(count_or_blank(channel.infinite_count));
    }
    for (const std::string& line : columns(rows)) print(line);
}

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream from(text);
    for (std::string line; std::getline(from, line);) lines.push_back(line);
    return lines;
}

/// Without what `told` says already.
void print_metadata(const Metadata& metadata, const std::vector<std::string>& told) {
    const auto is_told = [&told](const std::string& line) {
        return std::ranges::find(told, line) != told.end();
    };
    std::size_t width = 0;
    for (const auto& [key, value] : metadata) width = std::max(width, key.size());
    for (const auto& [key, value] : metadata) {
        const std::vector<std::string> lines = lines_of(value);
        if (std::ranges::all_of(lines, is_told)) continue;
        std::string head = printable(key) + std::string(width - key.size() + 2, ' ');
        for (const std::string& line : lines) {
            print(head + printable(line));
            head.assign(width + 2, ' ');
        }
    }
}

}  // namespace

Exit info(const std::string& path, bool json) {
    const Decoded file = read_image(path);
    const auto statistics = statistics_of(file.table);
    const auto words = convention_of(file);
    if (json) {
        print(info_json(file, statistics, words));
        return Exit::done;
    }
    print(printable(path) + "  " +
          format_size(file.table.width, file.table.height, slices_of(file)) + " " + file.pixel +
          ", " + file.format);
    print("");
    print_statistics(statistics);
    if (!words.empty()) print("");
    for (const std::string& line : words) print(printable(line));
    print("");
    if (metadata_value(file, "kiln.job").empty()) print("no Kiln metadata");
    print_metadata(file.metadata, words);
    return Exit::done;
}

namespace {
/// Without the channel that a PNG has beside two quantities.
Table quantities_of(Decoded image) {
    Table& table = image.table;
    if (metadata_value(image, "kiln.unused_channel").empty()) return std::move(table);
    table.channels.pop_back();
    table.planes.pop_back();
    return std::move(table);
}

}  // namespace

Exit diff(const std::string& a, const std::string& b, double max_error, bool json) {
    const Comparison comparison =
        compare(quantities_of(read_image(a)), quantities_of(read_image(b)));
    const Exit exit = comparison.within(max_error) ? Exit::done : Exit::different;
    if (json) {
        print(difference_json(comparison, max_error));
        return exit;
    }
    if (!comparison.mismatch.empty()) {
        print("different: " + printable(comparison.mismatch));
        return exit;
    }
    std::vector<std::vector<std::string>> rows{{"channel", "max", "rms", "at x, y", "A", "B"}};
    for (const ChannelDifference& channel : comparison.channels) {
        const bool any = channel.max != 0 || channel.incomparable_count != 0;
        rows.push_back({printable(channel.name),
                        channel.incomparable_count != 0 ? "NaN" : format_error(channel.max),
                        format_error(channel.rms),
                        any ? std::to_string(channel.x) + ", " + std::to_string(channel.y) : "-",
                        any ? format_number(channel.a) : "-",
                        any ? format_number(channel.b) : "-"});
    }
    for (const std::string& line : columns(rows)) print(line);
    for (const ChannelDifference& channel : comparison.channels)
        if (channel.incomparable_count != 0)
            print(printable(channel.name) + ": " + std::to_string(channel.incomparable_count) +
                  " texels cannot be compared (NaN, or unequal infinities)");
    return exit;
}

Exit devices(bool json) {
    keep_opencl_programs();
    Engine engine(EngineOptions{});
    const std::vector<DeviceInfo> found = engine.devices();
    if (json) {
        print(devices_json(found));
        return Exit::done;
    }
    for (const DeviceInfo& device : found) {
        print(printable(device.backend + "  " + device.name) +
              (device.usable ? "" : "  (not usable)"));
        if (!device.vendor.empty() || !device.version.empty())
            print("  " +
                  printable(device.vendor + (device.vendor.empty() ? "" : ", ") + device.version));
        print("  " + std::to_string(device.compute_units) + " compute units, numerics " +
              printable(device.numerics.empty() ? "unknown" : device.numerics));
        if (!device.detail.empty()) print("  " + printable(device.detail));
    }
    return Exit::done;
}

}  // namespace kiln::client
