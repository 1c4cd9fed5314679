// SPDX-License-Identifier: Apache-2.0
// RGL/EPFL tensor files: points at the nodes of the visible normals, where the file is densest.
#include <algorithm>
#include <cmath>

#include "server/measured/bounds.h"
#include "server/measured/byte_scan.h"
#include "server/measured/observer.h"
#include "server/measured/readers.h"
#include "server/measured/rgl_brdf.h"
#include "server/measured/tensor_file.h"

namespace kiln::measured {
namespace {

/// Below this cosine (88 degrees) the stored value, which does not vanish at the horizon, is
/// divided by so little that f is made of its noise.
constexpr double kCosineMin = 0.035;

/// Median relative difference of f(a, b) and f(b, a), once with the stored value as f cos theta_o
/// and once as f.
struct Reciprocity {
    double as_f_cos = 0, as_f = 0;
};
Reciprocity reciprocity(const RglBrdf& brdf) {
    std::vector<double> with, without;
    for (double a = 10; a <= 70; a += 15)
        for (double b = a + 10; b <= 70; b += 10)
            for (double turn = 0; turn <= 180; turn += 15) {
                // Of an anisotropic file under many azimuths; of others they are all one.
                const double phi = 2 * turn + a;
                const Vec first = direction(a, phi), second = direction(b, phi + turn);
                const double there = brdf.value(first, second)[1];
                const double back = brdf.value(second, first)[1];
                const double ca = std::cos(a * kDegree), cb = std::cos(b * kDegree);
                const auto difference = [](double x, double y) {
                    const double mean = 0.5 * (std::abs(x) + std::abs(y));
                    return mean > 0 ? std::abs(x - y) / mean : 0.0;
                };
                with.push_back(difference(there / cb, back / ca));
                without.push_back(difference(there, back));
            }
    const auto median = [](std::vector<double>& list) {
        std::nth_element(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(list.size() / 2),
                         list.end());
        return list[list.size() / 2];
    };
    return {median(with), median(without)};
}

struct Counts {
    std::size_t negative = 0, grazing = 0, all = 0;
};

/// Every so many nodes of an incidence, so that all of them are within the bound of a cloud.
std::size_t stride_of(const RglBrdf& brdf) {
    const NodeTable& nodes = brdf.visible_normals();
    const std::size_t incidences = brdf.theta_i().size() * brdf.phi_i().size();
    std::size_t stride = 1;
    while (incidences * (nodes.width / stride + 1) * (nodes.height / stride + 1) > kPointsMax)
        ++stride;
    return stride;
}

void add_incidence(Cloud& cloud, const RglBrdf& brdf, double theta_i, double phi_i, bool divide,
                   Counts& counts) {
    const NodeTable& nodes = brdf.visible_normals();
    const Vec in = direction(theta_i, phi_i);
    const std::size_t stride = stride_of(brdf);
    std::array<double, 3> f{};
    for (std::size_t x = 0; x < nodes.width; x += stride)
        // At u = 0 all azimuths are one direction; v = 1 is v = 0.
        for (std::size_t y = 0; y < (x == 0 ? 1 : nodes.height - 1); y += stride) {
            const Vec half = RglBrdf::half_vector(
                static_cast<double>(x) / static_cast<double>(nodes.width - 1),
                static_cast<double>(y) / static_cast<double>(nodes.height - 1));
            const Vec out = 2 * dot(in, half) * half - in;
            if (out.z <= 0) continue;
            const bool grazing = out.z < kCosineMin;
            const auto stored = brdf.value_at(theta_i, phi_i, out);
            bool negative = false;
            for (std::size_t c = 0; c < 3; ++c) {
                f[c] = divide ? stored[c] / std::max(out.z, kCosineMin) : stored[c];
                negative = negative || f[c] < 0;
            }
            ++counts.all;
            counts.negative += negative;
            counts.grazing += grazing;
            add_point(cloud, {theta_i, phi_i, theta_of(out), phi_of(out)}, f.data(),
                      grazing ? PointState::kNotMeasured : PointState::kMeasured);
        }
}

std::string symmetry_words(const RglBrdf& brdf) {
    switch (brdf.symmetry()) {
        case TurnSymmetry::any_turn:
            return "isotropic";
        case TurnSymmetry::none:
            return "anisotropic";
        case TurnSymmetry::half_turn:
            return "anisotropic, a half turn changes nothing";
        case TurnSymmetry::two_planes:
            return "anisotropic, mirrored in x and y";
    }
    return {};
}

/// What the bits of `valid` stand for, by the share that is set above the horizon and below.
const char* mask_words(std::array<double, 2> set) {
    constexpr double kClear = 0.5;  // real files: .89 to .98 between the two
    if (std::abs(set[0] - set[1]) < kClear) return "the bits tell nothing of the horizon";
    return set[0] > set[1] ? "bit 1 is above the horizon" : "bit 1 is below the horizon";
}

void explain(Understood& account, const RglBrdf& brdf, const Reciprocity& found, bool divide,
             const Counts& counts) {
    account.title = plain_text(brdf.description());
    account.found("convention", divide ? "f cos theta_o" : "f",
                  "f(i,o) and f(o,i) differ by " + in_words(found.as_f_cos) +
                      " (median) if the cosine is divided out, by " + in_words(found.as_f) +
                      " if it is not");
    account.found("units", "radians, 1/sr",
                  "theta_i ends at " + in_words(brdf.theta_i().back() * kDegree));
    account.found("azimuth", brdf.isotropic() ? "from the light" : "from the sample's x axis",
                  brdf.isotropic() ? "one azimuth of the light" : "the field phi_i");
    account.found("angles", "half vectors under visible normals", "the container tensor_file");
    account.found("symmetry", symmetry_words(brdf),
                  brdf.isotropic()
                      ? "one azimuth of the light"
                      : std::to_string(brdf.phi_i().size()) + " azimuths of the light, from " +
                            in_words(brdf.phi_i().front()) + " to " +
                            in_words(brdf.phi_i().back()) + " degrees");
    if (const std::size_t stride = stride_of(brdf); stride > 1)
        account.found("points", "at each node of " + std::to_string(stride) + " in both directions",
                      std::to_string(kPointsMax) + " points are the most that a cloud has");
    if (const std::vector<double>& nm = brdf.wavelengths(); !nm.empty())
        account.found("colour", kObserverWords,
                      std::to_string(nm.size()) + " wavelengths from " + in_words(nm.front()) +
                          " to " + in_words(nm.back()) + " nm");
    const auto valid = brdf.valid_share();
    if (std::isfinite(valid[0]) && std::isfinite(valid[1]))
        account.found("mask", mask_words(valid),
                      "set in " + in_words(100 * valid[0]) + " % of the places above and in " +
                          in_words(100 * valid[1]) +
                          " % of those below; the horizon is taken from geometry");
    if (brdf.last_is_copy()) {
        const std::string last = in_words(brdf.theta_i().back());
        account.found(
            "mask", "nothing beyond theta_i = " + in_words(brdf.theta_i().end()[-2]),
            "the slice at " + last + " degrees repeats the one before it, value by value");
        account.leave_out("theta_i = " + last + " degrees",
                          "a copy of another slice is no measurement");
    }
    if (counts.grazing > 0)
        account.found("mask", std::to_string(counts.grazing) + " points beyond 88 degrees",
                      "f would be noise divided by the cosine");
    if (counts.negative > 0)
        account.found("negative values",
                      in_words(100.0 * static_cast<double>(counts.negative) /
                               static_cast<double>(counts.all)) +
                          " % of the points",
                      "colours outside sRGB; kept, and clamped only in the table");
}

}  // namespace

bool is_rgl(std::string_view bytes) { return bytes.starts_with(kTensorMagic); }

Reading read_rgl(std::string_view bytes, const ReadOptions&) {
    const RglBrdf brdf(bytes);
    const Reciprocity found = reciprocity(brdf);
    const bool divide = found.as_f_cos <= found.as_f;
    Reading reading;
    Component part{"reflection front", {}, {}};
    part.cloud.channels = {"R", "G", "B"};
    Counts counts;
    const std::size_t slices = brdf.theta_i().size() - (brdf.last_is_copy() ? 1 : 0);
    part.symmetry = brdf.symmetry();
    const std::vector<double>& azimuths = brdf.phi_i();
    // The last azimuth of a whole turn is the first.
    const bool whole = !brdf.isotropic() && brdf.symmetry() == TurnSymmetry::none;
    for (std::size_t a = 0; a + whole < azimuths.size(); ++a)
        for (std::size_t slice = 0; slice < slices; ++slice)
            add_incidence(part.cloud, brdf, brdf.theta_i()[slice], azimuths[a], divide, counts);
    explain(reading.understood, brdf, found, divide, counts);
    reading.components.push_back(std::move(part));
    return reading;
}

}  // namespace kiln::measured
