// SPDX-License-Identifier: Apache-2.0
// MERL .binary: Matusik et al. 2003, "A data-driven reflectance model", over Rusinkiewicz's angles.
#include <array>
#include <cmath>

#include "server/measured/angles.h"
#include "server/measured/byte_scan.h"
#include "server/measured/readers.h"

namespace kiln::measured {
namespace {

constexpr std::size_t kHeaderBytes = 12;
/// The file's integers times these are f_r in 1/sr.
constexpr std::array<double, 3> kScale = {1.00 / 1500, 1.15 / 1500, 1.66 / 1500};

std::array<std::int64_t, 3> dimensions(std::string_view bytes) {
    return {load<std::int32_t>(bytes, 0), load<std::int32_t>(bytes, 4),
            load<std::int32_t>(bytes, 8)};
}

/// Directions of the centre of a cell; of n cells in theta_h the i-th lies at 90 (i / n)^2 degrees,
/// so centres lie half way in the root. phi_d in degrees. Light at azimuth 0.
struct Cell {
    Directions at;
    bool above = false;
};
Cell cell(const MerlSizes& sizes, std::size_t h, std::size_t d, double phi_d) {
    const double root = (static_cast<double>(h) + 0.5) / static_cast<double>(sizes.theta_h);
    const double theta_h = root * root * 90.0;
    const double step = 90.0 / static_cast<double>(sizes.theta_d);
    const Vec difference = direction((static_cast<double>(d) + 0.5) * step, phi_d);
    const double c = std::cos(theta_h * kDegree), s = std::sin(theta_h * kDegree);
    // Turned by theta_h about y; the view is the light mirrored at the half vector.
    const Vec in = {c * difference.x + s * difference.z, difference.y,
                    -s * difference.x + c * difference.z};
    const Vec out = {-c * difference.x + s * difference.z, -difference.y,
                     s * difference.x + c * difference.z};
    return {{theta_of(in), 0.0, theta_of(out), phi_of(out) - phi_of(in)}, in.z > 0 && out.z > 0};
}

/// The third size, once the others are what they have to be.
std::size_t azimuths_of(std::string_view bytes, const MerlSizes& sizes) {
    const auto dims = dimensions(bytes);
    const auto h = static_cast<std::int64_t>(sizes.theta_h),
               d = static_cast<std::int64_t>(sizes.theta_d),
               half = static_cast<std::int64_t>(sizes.half_turn);
    const auto words = [](std::int64_t a, std::int64_t b, std::int64_t c) {
        return std::to_string(a) + ", " + std::to_string(b) + ", " + std::to_string(c);
    };
    if (dims[0] != h || dims[1] != d || (dims[2] != half && dims[2] != 2 * half))
        fail_at_byte(0, "the sizes are " + words(dims[0], dims[1], dims[2]) + "; " +
                            words(h, d, half) + " or " + words(h, d, 2 * half) + " are read");
    return static_cast<std::size_t>(dims[2]);
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

Reading read_merl(std::string_view bytes, const ReadOptions&) { return read_merl_of(bytes, {}); }

Reading read_merl_of(std::string_view bytes, const MerlSizes& sizes) {
    const std::size_t azimuths = azimuths_of(bytes, sizes);
    const std::size_t cells = sizes.theta_h * sizes.theta_d * azimuths;
    const std::size_t expected = kHeaderBytes + 3 * cells * sizeof(double);
    if (bytes.size() != expected)
        fail_at_byte(bytes.size(), "the file has " + std::to_string(bytes.size()) +
                                       " bytes, its sizes ask for " + std::to_string(expected));
    Component part{"reflection front", {}, {sizes.theta_h, sizes.theta_d, azimuths}};
    part.symmetry = TurnSymmetry::any_turn;
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
        const std::size_t k = n % azimuths, d = n / azimuths % sizes.theta_d,
                          h = n / azimuths / sizes.theta_d;
        // 180 cells and 360 cells are a degree wide each: the third axis ends at pi or at 2 pi.
        const double width = 180.0 / static_cast<double>(sizes.half_turn);
        const Cell where = cell(sizes, h, d, (static_cast<double>(k) + 0.5) * width);
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
    account.found("units", "1/sr",
                  "the scale of the format's authors; angles are places in the table");
    account.found("azimuth", "phi_d from the half vector; the light's own is not stored",
                  "the format's definition");
    account.found("angles", "half vector and difference, theta_h dense at its peak",
                  "the sizes in the first 12 bytes");
    account.found("symmetry",
                  azimuths == sizes.half_turn ? "isotropic and reciprocal" : "isotropic",
                  azimuths == sizes.half_turn ? "the table's third axis covers half a turn"
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
