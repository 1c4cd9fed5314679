// SPDX-License-Identifier: Apache-2.0
// Files that end too early: of every format, which cuts are told and which nobody can tell.
#include <gtest/gtest.h>

#include <functional>
#include <numeric>
#include <set>

#include "server/base/error.h"
#include "server/measured/reader.h"
#include "tests/measured/files.h"
#include "tests/measured/fuzz_targets.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;
using namespace synthetic;

using Read = std::function<Reading(std::string_view)>;

bool warns_of_cut(const Reading& reading) {
    for (const std::string& text : reading.understood.warnings)
        if (text.find("cut off") != text.npos) return true;
    return false;
}

bool same_points(const Reading& a, const Reading& b) {
    bool same = a.components.size() == b.components.size();
    for (std::size_t n = 0; same && n < a.components.size(); ++n) {
        const Cloud &x = a.components[n].cloud, &y = b.components[n].cloud;
        same = x.values == y.values && x.theta_o == y.theta_o && x.phi_o == y.phi_o &&
               x.theta_i == y.theta_i && x.state == y.state && x.channels == y.channels;
    }
    return same;
}

/// What a file's first `size` bytes do: they are refused, or read with a warning, or hold all that
/// the whole file does, or less of it and nobody says so.
bool cut_is_silent(const std::string& bytes, std::size_t size, const Read& read,
                   const Reading& whole) {
    try {
        const Reading reading = read(std::string_view(bytes).substr(0, size));
        return !warns_of_cut(reading) && !same_points(reading, whole);
    } catch (const Error&) {
        return false;
    }
}

/// Sizes of all cuts that nobody tells.
std::set<std::size_t> silent_cuts(const std::string& bytes, const Read& read) {
    const Reading whole = read(bytes);
    EXPECT_FALSE(warns_of_cut(whole));
    std::set<std::size_t> silent;
    for (std::size_t size = 0; size < bytes.size(); ++size)
        if (cut_is_silent(bytes, size, read, whole)) silent.insert(size);
    return silent;
}

Reading read_any(std::string_view bytes) { return read_measurement(bytes); }

/// Sizes of a text up to the end of each line that `counts` says yes to.
std::set<std::size_t> line_ends(const std::string& text,
                                const std::function<bool(std::size_t line)>& counts) {
    std::set<std::size_t> ends;
    std::size_t line = 0;
    for (std::size_t at = text.find('\n'); at != text.npos; at = text.find('\n', at + 1))
        if (counts(++line) && at + 1 < text.size()) ends.insert(at + 1);
    return ends;
}

/// Sizes, counts, brackets or tags: a file of these formats is whole or it is not.
TEST(Cuts, AreToldAtEveryByteWhereAFormatSaysItsSize) {
    for (const FuzzTarget& target : fuzz_targets()) {
        if (target.name == "csv" || target.name == "fred") continue;
        const Read read = target.name == "merl" ? Read(target.read) : Read(read_any);
        EXPECT_EQ(silent_cuts(target.seed, read), std::set<std::size_t>()) << target.name;
    }
}

/// Rows in no order and no count of them: a file of fewer whole rows is a file.
TEST(Cuts, OfScatteredRowsAreToldWithinARowAlone) {
    const std::string csv = small_file("csv");
    EXPECT_EQ(silent_cuts(csv, read_any), line_ends(csv, [](std::size_t n) { return n > 1; }));
    std::string astm = small_file("astm");
    astm.replace(astm.find("NUM_POINTS 4"), 12, "NOTE");
    EXPECT_EQ(silent_cuts(astm, read_any), line_ends(astm, [](std::size_t n) { return n > 4; }));
}

/// theta 0 to 80 and phi 0 to 180, rings of five, under each of `lights`.
std::string scan(const std::vector<int>& lights) {
    std::string text = "type bsdf_data\nformat angles=deg bsdf=value scale=1\n";
    for (const int light : lights) {
        text += std::to_string(light) + " 0\n0 0 0.25\n";
        for (int theta = 20; theta <= 80; theta += 20)
            for (int phi = 0; phi <= 180; phi += 45)
                text += std::to_string(theta) + " " + std::to_string(phi) + " 0.125\n";
    }
    return text;
}

/// A section has 22 lines after two of the head. What a scan is like is known when one section of
/// it is whole, so within the first nothing but whole rows can be asked for; where another would
/// begin, a file may end.
TEST(Cuts, OfAScanAreToldWithinItsSections) {
    const std::string text = scan({10, 30, 50, 70});
    EXPECT_EQ(silent_cuts(text, read_any), line_ends(text, [](std::size_t line) {
                  const bool first_section = line > 3 && line <= 24;
                  return first_section || (line > 2 && (line - 2) % 22 == 0);
              }));
}

std::string refusal(const std::string& text) {
    try {
        read_measurement(text);
    } catch (const Error& error) {
        return error.what();
    }
    return "was read";
}

TEST(Cuts, OfAScanNameTheLineAndWhatTheOthersHave) {
    const std::string text = scan({10, 30, 50, 70});
    const auto first_lines = [&text](std::size_t count) {
        return text.substr(0,
                           *line_ends(text, [count](std::size_t n) { return n == count; }).begin());
    };
    EXPECT_EQ(refusal(first_lines(83)),
              "line 83: the file was cut off: the rows end at theta 60, phi 90, but all 14 others "
              "of one theta end at phi 180 and those of the other directions of light (3) at theta "
              "80");
    EXPECT_EQ(refusal(first_lines(69)),
              "line 69: the file ends after the two numbers that start a section");
    const auto warning = [&](std::size_t count) {
        const Reading reading = read_measurement(first_lines(count));
        return reading.understood.warnings.empty() ? "" : reading.understood.warnings.front();
    };
    // An arm that hides the end of the last ring, or light that leaves no more rings free.
    EXPECT_EQ(warning(88),
              "the file may have been cut off: the rows end at theta 80, phi 90, but all 15 others "
              "of one theta end at phi 180");
    EXPECT_EQ(warning(85),
              "the file may have been cut off: the rows end at theta 60, phi 180, those of the "
              "other directions of light (3) at theta 80");
}

/// Where rows may come in any order a scan is still seen, and told of rather than refused.
TEST(Cuts, OfScansInColumnsAreWarnedOf) {
    const std::string csv = csv_file(Brushed{}, {0, 30, 60}, {0}, 15);
    const std::string astm =
        "VARS theta_i,phi_i,theta_s,phi_s,value\n" + csv.substr(csv.find('\n') + 1);
    for (const std::string& whole : {csv, astm}) {
        EXPECT_FALSE(warns_of_cut(read_measurement(whole)));
        std::size_t size = whole.size();
        for (int row = 1; row <= 30; ++row) {  // more than the last ring
            size = whole.rfind('\n', size - 2) + 1;
            EXPECT_TRUE(warns_of_cut(read_measurement(whole.substr(0, size)))) << row;
        }
    }
}

/// Scans as instruments make them, and what is no scan.
TEST(Cuts, AreNotSeenWhereThereAreNone) {
    const std::string head = "type bsdf_data\nformat angles=deg bsdf=value scale=1\n";
    const auto row = [](int theta, int phi) {
        return std::to_string(theta) + " " + std::to_string(phi) + " 0.125\n";
    };
    std::string inward = head, by_phi = head, in_plane = head, holes = head, scattered = head,
                reach = head, wider = head;
    for (int light = 10; light <= 70; light += 20) {
        for (std::string* text : {&inward, &by_phi, &in_plane, &holes, &scattered, &reach, &wider})
            *text += std::to_string(light) + " 0\n";
        for (int theta = 80; theta >= 0; theta -= 20)
            for (int phi = 0; phi <= (theta == 0 ? 0 : 180); phi += 45) inward += row(theta, phi);
        for (int phi = 0; phi < 180; phi += 45)
            for (int theta = -80; theta <= 80; theta += 20) by_phi += row(theta, phi);
        for (int theta = -80; theta <= 80; theta += 5) in_plane += row(theta, 0);
        // The detector's arm hides the light's side near the mirror direction's height.
        for (int theta = 5; theta <= 80; theta += 5)
            for (int phi = 0; phi <= (std::abs(theta - light) <= 10 ? 135 : 180); phi += 45)
                holes += row(theta, phi);
        for (int n = 0; n < 40; ++n) scattered += row(n * 37 % 83, n * 101 % 360);
        // Nearer to the horizon more of a ring is free.
        for (int theta = 20; theta <= 80; theta += 10)
            for (int phi = 0; phi <= (light == 70 && theta == 80 ? 150 : 120); phi += 30)
                wider += row(theta, phi);
        // Each light has another reach; the last one's is the longest.
        for (int theta = 0; theta <= light + 10; theta += 5)
            for (int phi = 0; phi <= 180; phi += 45) reach += row(theta, phi);
    }
    for (const std::string& text : {inward, by_phi, in_plane, holes, scattered, reach, wider})
        EXPECT_FALSE(warns_of_cut(read_measurement(text))) << text.substr(0, 200);
}

/// What is whole in itself is read, whatever the rest of the file is like: with a warning at most.
TEST(Cuts, OfWholeFilesAreNoErrors) {
    using Views = std::function<bool(int light, int theta, int phi)>;
    const auto file = [](const std::vector<int>& lights, int first, int last, int step, bool by_phi,
                         const Views& seen) {
        std::string text = "type bsdf_data\nformat angles=deg bsdf=value scale=1\n";
        for (const int light : lights) {
            text += std::to_string(light) + " 0\n";
            const std::size_t thetas = static_cast<std::size_t>((last - first) / step) + 1;
            for (std::size_t n = 0; n < 37 * thetas; ++n) {
                const int theta = first + step * static_cast<int>(by_phi ? n % thetas : n / 37);
                const int phi = 10 * static_cast<int>(by_phi ? n / thetas : n % 37);
                if (seen(light, theta, phi))
                    text += std::to_string(theta) + " " + std::to_string(phi) + " 0.125\n";
            }
        }
        return text;
    };
    const std::vector<int> up = {10, 30, 50, 70}, down = {60, 40, 20, 0};
    const auto pole = [](int, int theta, int phi) {
        return theta % 180 == 0 ? phi == 0 : phi < 360;
    };
    const auto half = [](int light, int, int phi) { return light > 0 ? phi <= 180 : phi == 0; };
    const auto reach = [](int light, int theta, int phi) {
        return phi <= 180 && theta <= (light == 70 ? 80 : 85);
    };
    const auto lamp = [](int light, int theta, int phi) {
        return phi <= 180 && std::abs(theta) >= (light == 0 ? 5 : 0);
    };
    const auto plane = [](int light, int theta, int phi) {
        return phi == 0 && theta <= (light == 70 ? 0 : 85);
    };
    const auto arm = [](int light, int theta, int phi) {
        return phi < 180 || (phi == 180 && theta < (light == 70 ? 65 : 85));
    };
    const auto last_ring = [](int light, int theta, int phi) {
        return phi <= (light == 70 && theta == 85 ? 150 : 180);
    };
    for (const std::string& text :
         {file({10}, 0, 180, 10, false, pole), file(down, 0, 85, 5, false, half),
          file(up, 0, 85, 5, false, reach), file(down, 85, 0, -5, false, lamp),
          file(up, -85, 85, 5, false, plane), file(up, 0, 85, 5, true, arm),
          file(up, 0, 85, 5, false, last_ring)})
        EXPECT_EQ(refusal(text), "was read");
    std::string disc = "type bsdf_data\nformat angles=sin bsdf=value scale=1\n";
    for (const int light : {0, 1, 2}) {
        disc += "0 0." + std::to_string(light) + "\n";
        for (int alpha = -5; alpha <= 5; ++alpha)
            for (int beta = -5; beta <= 5; ++beta)
                if (alpha * alpha + beta * beta <= 25)
                    disc +=
                        std::to_string(alpha * 0.2) + " " + std::to_string(beta * 0.2) + " 0.125\n";
    }
    EXPECT_EQ(refusal(disc), "was read");
}

/// At 50 places of each real file, half of them ends of lines: nothing is silent within a row, or
/// in the last section of a scan. Spectralon's rows each have a light of their own.
TEST(Cuts, OfRealFilesAreTold) {
    using namespace measured_files;
    if (folder().empty()) GTEST_SKIP() << kNoFolder;
    std::size_t read = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder())) {
        const std::string name = std::filesystem::relative(entry.path(), folder()).string();
        const std::string bytes = entry.is_regular_file() ? bytes_of(name) : std::string();
        std::optional<Reading> whole;
        try {
            whole = read_measurement(bytes);
        } catch (const Error&) {
            continue;
        }
        ++read;
        EXPECT_FALSE(warns_of_cut(*whole)) << name;
        std::size_t silent = 0, last = 0;
        for (std::size_t n = 0; n < 50; ++n) {
            std::size_t size = bytes.size() * (2 * n + 1) / 100;
            if (n % 2 == 0) size = bytes.find('\n', size) + 1;  // 0 if there is none
            if (!cut_is_silent(bytes, size, read_any, *whole)) continue;
            ++silent;
            EXPECT_EQ(bytes[size - 1], '\n') << name << " " << size;
            last = size;
        }
        const bool scan = name.starts_with("fred"), rows = name.starts_with("spectralon");
        EXPECT_LE(silent, rows ? 25u : scan ? 12u : 0u) << name;
        EXPECT_LT(last, scan ? bytes.size() / 4 : bytes.size()) << name;
    }
    EXPECT_GE(read, 16u);
}

}  // namespace
}  // namespace kiln
