// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "server/base/error.h"
#include "server/measured/slices.h"
#include "server/study/stability.h"

// One value of a measured file is anything: from the bytes of the file through reader, cloud and
// hemispheres to f, albedos and the texels of slices, or to an error that says so.
namespace kiln::stability {

namespace {

using namespace measured;
using namespace std::string_literals;

/// Of all other points, and of none of the powers of two.
constexpr double kEverywhere = 0.3;
constexpr double kThetaIn = 30, kThetaOut = 40;
const char* const kSpikes[] = {"1e-40", "0", "1", "1e6", "1e30", "3e38", "-1e-3", "-1e30"};

/// f = kEverywhere at all points but one beside the mirror direction, or at all.
std::string file_of(const std::string& spike, bool alone) {
    std::string text = "theta_in,phi_in,theta_out,phi_out,value\n";
    char line[96];
    for (const int theta_in : {0, 30, 60})
        for (int theta_out = 0; theta_out <= 80; theta_out += 10)
            for (int phi = 0; phi < (theta_out == 0 ? 30 : 360); phi += 30) {
                const bool there = theta_in == kThetaIn && theta_out == kThetaOut && phi == 180;
                const std::string value = alone && !there ? plain(kEverywhere) : spike;
                std::snprintf(line, sizeof line, "%d,0,%d,%d,%s\n", theta_in, theta_out, phi,
                              value.c_str());
                text += line;
            }
    return text;
}

Material material_of(const std::string& bytes) {
    Reading reading = read_measurement(bytes);
    return Material(reading.components.at(0), {}, reading.understood);
}

Vec direction_of(double theta, double phi) {
    constexpr double degree = std::numbers::pi / 180;
    return {std::sin(theta * degree) * std::cos(phi * degree),
            std::sin(theta * degree) * std::sin(phi * degree), std::cos(theta * degree)};
}

struct Slices {
    SliceLayout layout;
    SliceTable made;
    std::size_t not_finite = 0, zero = 0;

    explicit Slices(const Material& material) {
        layout.theta_in = {kThetaIn, 45, 75};  // measured, between two, beyond the last
        layout.width = 37, layout.height = 19;
        made = make_slices(layout, {&material});
        for (std::size_t slice = 0; slice < layout.theta_in.size(); ++slice) {
            const SlicePlan::Place at = made.plan.place(layout, slice, 0);
            for (std::size_t n = 0; n < layout.width * layout.height; ++n) {
                const std::size_t row = at.y + n / layout.width, column = at.x + n % layout.width;
                for (std::size_t c = 0; c < 3; ++c) {
                    const float value = made.table.planes[c][row * made.plan.width + column];
                    not_finite += !std::isfinite(value);
                    zero += value == 0;
                }
            }
        }
    }

    double at_the_point() const {
        return look_up(layout, made, 0, kThetaIn, direction_of(kThetaOut, 180))[1];
    }
};

class Spike {
  public:
    Spike(Bench& bench, Findings& findings, const std::string& spike)
        : findings_(findings), spike_(spike), value_(static_cast<float>(std::stod(spike))) {
        bench.look();
        of_one_point();
        bench.look();
        of_all_points();
    }

  private:
    void add(const std::string& row, double value, Right right, const std::string& source,
             const std::string& limit) {
        Readings values;
        values[kNativeFloat] = value;
        findings_.add({"Spikes in measured files",
                       "spikes in measured files",
                       row,
                       spike_,
                       row,
                       "value " + spike_,
                       source,
                       {},
                       {},
                       right,
                       right,
                       values,
                       0,
                       limit});
    }

    /// Of 0.3 and 1.3 at the point: what it weighs, since f between points is linear in them.
    static double weight_in(const std::function<double(const std::string&)>& of) {
        return of("1.3") - of("0.3");
    }
    static double albedo_with(const std::string& spike) {
        return material_of(file_of(spike, true)).albedo(kThetaIn).value[1];
    }
    static double texel_with(const std::string& spike) {
        return Slices(material_of(file_of(spike, true))).at_the_point();
    }

    void of_one_point() {
        const Material material = material_of(file_of(spike_, true));
        Origin origin{};
        const double at = material.value(kThetaIn, direction_of(kThetaOut, 180), origin)[1];
        const double more = value_ - kEverywhere;
        // A cosine's rounding moves the place by 1e-7 of the 10 degrees to the next point.
        add("f at the point", at, {value_, 1e-5 * (std::abs(value_) + kEverywhere)}, "the file",
            "rounding of directions");
        const double beside = material.value(kThetaIn, direction_of(70, 0), origin)[1];
        add("f elsewhere", beside, {kEverywhere, 1e-6}, "the file", "rounding");
        static const double in_albedo = weight_in(albedo_with);
        const double none = std::numbers::pi * kEverywhere;
        // Below 0 there is no light: all around the point counts as none, however far below.
        const bool cut = value_ < -kEverywhere;
        const double right = cut ? albedo_with("-1e6") : none + more * in_albedo;
        // Weights are floats, and the difference of two albedos of 1e-7 each is 3e-6 of it.
        const double size = cut ? none : none + std::abs(more) * in_albedo;
        add("albedo", material.albedo(kThetaIn).value[1], {right, 2e-5 * size},
            cut ? "that of -1e6" : "linear in one value: pi f, and its weight from small ones",
            "floats of the tables");
        of_slices(Slices(material), more);
    }

    void of_slices(const Slices& slices, double more) {
        add("slices: texels of no number", static_cast<double>(slices.not_finite), {0, 0},
            "a number is asked for", "none");
        // Of what is negative a texel holds 0, and the account says of how many.
        const double told = static_cast<double>(slices.made.accounts[0].negative);
        add("slices: zeros untold", static_cast<double>(slices.zero) - told, {0, 0},
            "what the account counts", "none");
        static const double weight = weight_in(texel_with);
        const double right = std::max(0.0, kEverywhere + more * weight);
        add("slices: at the point", slices.at_the_point(),
            {right, 1e-5 * (kEverywhere + std::abs(more))}, "linear in one value",
            "floats of the tables");
    }

    void of_all_points() {
        const Material material = material_of(file_of(spike_, false));
        const double right = std::numbers::pi * std::max(0.0, value_);
        // pi 3e38 is beyond float, and an integral is held as a double.
        add("albedo of a file of it", material.albedo(kThetaIn).value[1],
            {right, 1e-5 * right + 1e-40}, "pi f of what is constant", "floats of the tables");
    }

    Findings& findings_;
    const std::string spike_;
    const double value_;
};

}  // namespace

Part spikes_part() {
    return {{}, [](Bench& bench, Findings& findings) {
                for (const char* spike : kSpikes) Spike(bench, findings, spike);
            }};
}

std::vector<Verdict> refused_spikes() {
    std::vector<Verdict> verdicts;
    // What is no number is refused as the text is read, by its line; what no float holds is seen
    // behind all readers, by its point, and so would be what the first let pass: its place tells.
    for (const auto& [spike, by] :
         {std::pair{"1e39", "point"}, {"nan", "line"}, {"-inf", "line"}}) {
        const std::string text = file_of(spike, true);
        const std::string before = text.substr(0, text.find(spike));
        const auto points = std::count(before.begin(), before.end(), '\n') - 1;  // less the head
        const std::string place = by + (" " + std::to_string(by == "line"s ? points + 2 : points));
        Verdict v{"a measured value of "s + spike + " is refused, by its " + by,
                  false,
                  true,
                  {},
                  {},
                  "it is accepted, and no float holds it"};
        try {
            material_of(text);
        } catch (const Error& error) {
            v.words = error.what();
            v.holds = v.words.find(place) != v.words.npos;
        }
        verdicts.push_back(v);
    }
    return verdicts;
}

}  // namespace kiln::stability
