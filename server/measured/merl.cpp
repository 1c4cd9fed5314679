// SPDX-License-Identifier: Apache-2.0
// MERL .binary: Matusik et al. 2003, "A data-driven reflectance model", over Rusinkiewicz's angles.
#include <array>
#include <cmath>

#include "server/measured/angles.h"
#include "server/measured/byte_scan.h"
#include "server/measured/readers.h"

namespace kiln::measured {
namespace {

constexpr std::size_t kThetaH = 90, kThetaD = 90;
constexpr std::size_t kHeaderBytes = 12;
/// The file's integers times these are f_r in 1/sr.
constexpr std::array<double, 3> kScale = {1.00 / 1500, 1.15 / 1500, 1.66 / 1500};

std::array<std::int64_t, 3> dimensions(std::string_view bytes) {
    return {load<std::int32_t>(bytes, 0), load<std::int32_t>(bytes, 4),
            load<std::int32_t>(bytes, 8)};
}

/// Directions of the centre of a cell; theta_h = 90 (i / 90)^2 degrees, so centres lie half way in
/// the root. Light at azimuth 0.
struct Cell {
    Directions at;
    bool above = false;
};
Cell cell(std::size_t h, std::size_t d, double phi_d) {
    const double root = (static_cast<double>(h) + 0.5) / static_cast<double>(kThetaH);
    const double theta_h = root * root * 90.0;
    const Vec difference = direction(static_cast<double>(d) + 0.5, phi_d);
    const double c = std::cos(theta_h * kDegree), s = std::sin(theta_h * kDegree);
    // Turned by theta_h about y; the view is the light mirrored at the half vector.
    const Vec in = {c * difference.x + s * difference.z, difference.y,
                    -s * difference.x + c * difference.z};
    const Vec out = {-c * difference.x + s * difference.z, -difference.y,
                     s * difference.x + c * difference.z};
    return {{theta_of(in), 0.0, theta_of(out), phi_of(out) - phi_of(in)}, in.z > 0 && out.z > 0};
}

}  // namespace

bool is_merl(std::string_view bytes) {
    if (bytes.size() < kHeaderBytes) return false;
    const auto dims = dimensions(bytes);
    // 31 bits each: the product of two fits, and a third beyond 2^31 cannot come to the products.
    const std::int64_t plane = dims[0] * dims[1];
    if (std::abs(plane) > (std::int64_t{1} << 31)) return false;
    const std::int64_t product = plane * dims[2];
    return product == 1458000 || product == 2916000;
}

Reading read_merl(std::string_view bytes, const ReadOptions&) {
    const auto dims = dimensions(bytes);
    if (dims[0] != 90 || dims[1] != 90 || (dims[2] != 180 && dims[2] != 360))
        fail_at_byte(0, "the sizes are " + std::to_string(dims[0]) + ", " +
                            std::to_string(dims[1]) + ", " + std::to_string(dims[2]) +
                            "; 90, 90, 180 or 90, 90, 360 are read");
    const auto azimuths = static_cast<std::size_t>(dims[2]);
    const std::size_t cells = kThetaH * kThetaD * azimuths;
    const std::size_t expected = kHeaderBytes + 3 * cells * sizeof(double);
    if (bytes.size() != expected)
        fail_at_byte(bytes.size(), "the file has " + std::to_string(bytes.size()) +
                                       " bytes, its sizes ask for " + std::to_string(expected));
    Component part{"reflection front", {}, {kThetaH, kThetaD, azimuths}};
    Cloud& cloud = part.cloud;
    cloud.channels = {"R", "G", "B"};
    cloud.values.reserve(3 * cells);
    std::size_t unmeasured = 0, below = 0;
    std::array<double, 3> values{};
    for (std::size_t n = 0; n < cells; ++n) {
        bool negative = false;
        for (std::size_t c = 0; c < 3; ++c) {
            const std::uint64_t offset = kHeaderBytes + (c * cells + n) * sizeof(double);
            values[c] = load<double>(bytes, offset) * kScale[c];
            if (!std::isfinite(static_cast<float>(values[c])))
                fail_at_byte(offset, "the value is no finite number");
            negative = negative || values[c] < 0;
        }
        const std::size_t k = n % azimuths, d = n / azimuths % kThetaD, h = n / azimuths / kThetaD;
        // 180 cells and 360 cells are a degree wide each: the third axis ends at pi or at 2 pi.
        const Cell where = cell(h, d, static_cast<double>(k) + 0.5);
        below += !where.above;
        unmeasured += where.above && negative;
        add_point(cloud, where.at, values.data(),
                  !where.above ? PointState::kBelowHorizon
                  : negative   ? PointState::kNotMeasured
                               : PointState::kMeasured);
    }
    Reading reading;
    Understood& account = reading.understood;
    account.found("convention", "f", "the format stores f_r, times 1500 / (1.00, 1.15, 1.66)");
    account.found("angles", "half vector and difference, theta_h dense at its peak",
                  "the sizes in the first 12 bytes");
    account.found("symmetry", azimuths == 180 ? "isotropic and reciprocal" : "isotropic",
                  azimuths == 180 ? "the table's third axis covers half a turn"
                                  : "the table's third axis covers a whole turn");
    account.found("mask", std::to_string(unmeasured) + " cells",
                  "negative in a channel: not measured");
    account.found("mask", std::to_string(below) + " cells", "below the horizon, by geometry");
    account.warn(
        "beyond about 75 degrees of theta_h or theta_d the values of this format's "
        "authors are extrapolated");
    reading.components.push_back(std::move(part));
    return reading;
}

}  // namespace kiln::measured
