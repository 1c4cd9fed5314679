// SPDX-License-Identifier: Apache-2.0
#include "server/measured/rgl_brdf.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "server/measured/bounds.h"
#include "server/measured/byte_scan.h"
#include "server/measured/observer.h"
#include "server/measured/reader.h"
#include "server/measured/tensor_file.h"

namespace kiln::measured {
namespace {

using Fields = std::map<std::string, TensorField>;

const TensorField& field_of(const Fields& fields, const std::string& name,
                            std::vector<std::uint64_t> shape) {
    const auto found = fields.find(name);
    if (found == fields.end())
        throw Error("malformed_measurement", "byte 18: the field " + name + " is missing");
    const TensorField& field = found->second;
    bool fits = field.shape.size() == shape.size();
    for (std::size_t d = 0; fits && d < shape.size(); ++d)  // 0 = any size from 2
        fits = shape[d] == 0 ? field.shape[d] >= 2 : field.shape[d] == shape[d];
    if (!fits) fail_at_byte(field.offset, "the field " + name + " has an unexpected shape");
    return field;
}

NodeTable table_of(std::string_view bytes, const Fields& fields, const std::string& name,
                   const std::vector<std::uint64_t>& shape) {
    const TensorField& field = field_of(fields, name, shape);
    NodeTable table;
    table.width = field.shape.back();
    table.height = field.shape[field.shape.size() - 2];
    table.values = tensor_floats(bytes, name, field);
    table.slices = table.values.size() / (table.width * table.height);
    return table;
}

/// A place between nodes: index of the lower one and the share of the upper.
struct Between {
    std::size_t index = 0;
    double share = 0;
};
Between between(double place, std::size_t nodes) {
    const double at = std::clamp(place, 0.0, 1.0) * static_cast<double>(nodes - 1);
    const std::size_t index = std::min(static_cast<std::size_t>(at), nodes - 2);
    return {index, at - static_cast<double>(index)};
}

double bilinear(const NodeTable& table, std::size_t slice, double u, double v) {
    const Between x = between(u, table.width), y = between(v, table.height);
    const float* p = table.values.data() + (slice * table.height + y.index) * table.width + x.index;
    const double low = (1 - x.share) * p[0] + x.share * p[1];
    const double high = (1 - x.share) * p[table.width] + x.share * p[table.width + 1];
    return (1 - y.share) * low + y.share * high;
}

/// Nanometres, rising, over what the eye sees.
std::vector<double> wavelengths_of(std::string_view bytes, const Fields& fields) {
    const TensorField& field = field_of(fields, "wavelengths", {0});
    std::vector<double> list;
    for (const float at : tensor_floats(bytes, "wavelengths", field)) {
        if (!(at > 0) || (!list.empty() && at <= list.back()))
            fail_at_byte(field.offset, "wavelengths do not rise");
        list.push_back(at);
    }
    if (const std::string lack = lacks_for_colour(list); !lack.empty())
        throw Error("unreadable_measurement", lack);
    return list;
}

double root_of_theta(double theta) { return std::sqrt(std::max(0.0, theta) / 90.0); }

}  // namespace

RglBrdf::RglBrdf(std::string_view bytes) {
    load_tables(bytes);
    build_distribution();
}

void RglBrdf::load_tables(std::string_view bytes) {
    const Fields fields = tensor_fields(bytes);
    const auto phi = fields.find("phi_i");
    const std::uint64_t azimuths = phi == fields.end() ? 1 : phi->second.count;
    if (azimuths > 2) load_azimuths(bytes, field_of(fields, "phi_i", {0}));
    const TensorField& thetas = field_of(fields, "theta_i", {0});
    for (const float theta : tensor_floats(bytes, "theta_i", thetas)) {
        const double degrees = theta / kDegree;
        if (!(degrees >= 0 && degrees <= 90.01) ||
            (!theta_i_.empty() && degrees <= theta_i_.back()))
            fail_at_byte(thetas.offset, "theta_i does not rise from 0 to 90 degrees");
        theta_i_.push_back(degrees);
    }
    const std::uint64_t count = theta_i_.size();
    ndf_ = table_of(bytes, fields, "ndf", {0, 0});
    sigma_ = table_of(bytes, fields, "sigma", {0, 0});
    vndf_ = table_of(bytes, fields, "vndf", {azimuths, count, 0, 0});
    if (!fields.contains("rgb") && fields.contains("spectra")) {
        wavelengths_ = wavelengths_of(bytes, fields);
        rgb_ =
            seen(table_of(bytes, fields, "spectra", {azimuths, count, wavelengths_.size(), 0, 0}));
    } else {
        rgb_ = table_of(bytes, fields, "rgb", {azimuths, count, 3, 0, 0});
    }
    if (std::any_of(sigma_.values.begin(), sigma_.values.end(), [](float s) { return s <= 0; }))
        fail_at_byte(fields.at("sigma").offset, "a projected area that is not positive");
    if (const auto text = fields.find("description");
        text != fields.end() && text->second.type == kTensorU8)
        description_ = bytes.substr(text->second.offset, text->second.count);
    if (const auto flag = fields.find("jacobian"); flag != fields.end())
        jacobian_ = load<std::uint8_t>(bytes, flag->second.offset) != 0;
    if (const auto mask = fields.find("valid");
        mask != fields.end() && mask->second.type == kTensorU8 &&
        mask->second.count >= (azimuths * count * rgb_.width * rgb_.height + 7) / 8) {
        const auto start = bytes.begin() + static_cast<std::ptrdiff_t>(mask->second.offset);
        valid_.assign(start, start + static_cast<std::ptrdiff_t>(mask->second.count));
    }
    last_is_copy_ = repeats_last_slice();
}

/// Files of two azimuths are isotropic, as the format's authors read them.
void RglBrdf::load_azimuths(std::string_view bytes, const TensorField& field) {
    phi_i_.clear();
    for (const float phi : tensor_floats(bytes, "phi_i", field)) {
        const double degrees = phi / kDegree;
        if (!(std::abs(degrees) <= 360.01) || (!phi_i_.empty() && degrees <= phi_i_.back()))
            fail_at_byte(field.offset, "phi_i does not rise within a turn");
        phi_i_.push_back(degrees);
    }
    const double width = phi_i_.back() - phi_i_.front();
    const long parts = std::lround(360 / width);
    const double off_axis = std::abs(std::remainder(phi_i_.front(), 90.0));
    if ((parts != 1 && parts != 2 && parts != 4) ||
        std::abs(360.0 / static_cast<double>(parts) - width) > 0.1 ||
        (parts == 4 && off_axis > 0.1))
        throw Error("unreadable_measurement",
                    "azimuths of the light from " + in_words(phi_i_.front()) + " to " +
                        in_words(phi_i_.back()) +
                        " degrees; a whole turn, a half one or a quadrant are read");
    symmetry_ = parts == 4   ? TurnSymmetry::two_planes
                : parts == 2 ? TurnSymmetry::half_turn
                             : TurnSymmetry::none;
}

bool RglBrdf::repeats_last_slice() const {
    const std::size_t count = theta_i_.size(), slice = 3 * rgb_.width * rgb_.height;
    if (count < 2) return false;
    for (std::size_t last = count - 1; last < phi_i_.size() * count; last += count) {
        const auto at = rgb_.values.begin() + static_cast<std::ptrdiff_t>(last * slice);
        const auto step = static_cast<std::ptrdiff_t>(slice);
        if (!std::equal(at, at + step, at - step)) return false;
    }
    return true;
}

/// What the eye sees of spectra: linear in them, so that it may come before any interpolation.
NodeTable RglBrdf::seen(const NodeTable& spectra) const {
    const std::vector<std::array<double, 3>> weights = srgb_weights(wavelengths_);
    const std::size_t area = spectra.width * spectra.height, count = wavelengths_.size();
    const std::size_t incidences = spectra.slices / count;
    NodeTable rgb{spectra.width, spectra.height, 3 * incidences, {}};
    rgb.values.reserve(rgb.slices * area);
    for (std::size_t i = 0; i < incidences; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t n = 0; n < area; ++n) {
                double sum = 0;
                for (std::size_t w = 0; w < count; ++w)
                    sum += weights[w][c] *
                           static_cast<double>(spectra.values[(i * count + w) * area + n]);
                rgb.values.push_back(static_cast<float>(sum));
            }
    return rgb;
}

/// Marginal over rows and conditional within a row of piecewise linear densities, each slice of
/// integral 1 over the unit square.
void RglBrdf::build_distribution() {
    const std::size_t width = vndf_.width, height = vndf_.height;
    conditional_.assign(vndf_.values.size(), 0.0);
    marginal_.assign(vndf_.slices * height, 0.0);
    for (std::size_t s = 0; s < vndf_.slices; ++s) {
        float* values = vndf_.values.data() + s * width * height;
        double* conditional = conditional_.data() + s * width * height;
        double* marginal = marginal_.data() + s * height;
        const double cell = 1.0 / static_cast<double>((width - 1) * (height - 1));
        for (std::size_t y = 0; y < height; ++y) {
            for (std::size_t x = 0; x + 1 < width; ++x) {
                const double a = values[y * width + x], b = values[y * width + x + 1];
                if (a < 0 || b < 0)
                    throw Error("malformed_measurement",
                                "the field vndf holds a density below zero (slice " +
                                    std::to_string(s) + ")");
                conditional[y * width + x + 1] = conditional[y * width + x] + 0.5 * (a + b) * cell;
            }
            if (y > 0)
                marginal[y] = marginal[y - 1] +
                              0.5 * (conditional[y * width - 1] + conditional[(y + 1) * width - 1]);
        }
        const double total = marginal[height - 1];
        if (!(total > 0))
            throw Error("malformed_measurement", "the field vndf holds a slice without density");
        for (std::size_t n = 0; n < width * height; ++n) {
            values[n] = static_cast<float>(values[n] / total);
            conditional[n] /= total;
        }
        for (std::size_t y = 0; y < height; ++y) marginal[y] /= total;
    }
}

RglBrdf::Mix RglBrdf::mix_at(double theta_i, double phi_i) const {
    const auto place = [](const std::vector<double>& list, double at) {
        const auto above = std::upper_bound(list.begin(), list.end(), at);
        const std::size_t low =
            above == list.begin() ? 0 : static_cast<std::size_t>(above - list.begin()) - 1;
        if (low + 1 == list.size()) return Between{low, 0};
        return Between{low, std::max(0.0, (at - list[low]) / (list[low + 1] - list[low]))};
    };
    const Between theta = place(theta_i_, theta_i), phi = place(phi_i_, phi_i);
    Mix mix;
    for (std::size_t corner = 0; corner < 4; ++corner) {
        const bool right = (corner & 1) != 0, upper = (corner & 2) != 0;
        const double share =
            (right ? theta.share : 1 - theta.share) * (upper ? phi.share : 1 - phi.share);
        if (share <= 0) continue;
        mix.slice[mix.count] = (phi.index + upper) * theta_i_.size() + theta.index + right;
        mix.share[mix.count++] = share;
    }
    return mix;
}

/// The sample that visible-normal sampling would have turned into the half vector at (u, v).
RglBrdf::Place RglBrdf::warp(const Mix& mix, double u, double v) const {
    const std::size_t width = vndf_.width, height = vndf_.height;
    const Between x = between(u, width), y = between(v, height);
    const auto mixed = [&](const auto& values, std::size_t stride, std::size_t n) {
        double sum = 0;
        for (std::size_t k = 0; k < mix.count; ++k)
            sum += mix.share[k] * static_cast<double>(values[mix.slice[k] * stride + n]);
        return sum;
    };
    const std::size_t area = width * height, n = y.index * width + x.index;
    const auto row_mixed = [&](const auto& values, std::size_t at) {
        return (1 - y.share) * mixed(values, area, at) + y.share * mixed(values, area, at + width);
    };
    const double cell = 1.0 / static_cast<double>((width - 1) * (height - 1));
    const double c0 = row_mixed(vndf_.values, n), c1 = row_mixed(vndf_.values, n + 1);
    const double along =
        row_mixed(conditional_, n) + x.share * (c0 + 0.5 * x.share * (c1 - c0)) * cell;
    const std::size_t end = y.index * width + width - 1;
    const double r0 = mixed(conditional_, area, end), r1 = mixed(conditional_, area, end + width);
    const double row = (1 - y.share) * r0 + y.share * r1;
    const double across =
        mixed(marginal_, height, y.index) + y.share * (r0 + 0.5 * y.share * (r1 - r0));
    return {row > 0 ? along / row : 0.0, across};
}

Vec RglBrdf::half_vector(double u, double v) { return direction(u * u * 90.0, 360.0 * v - 180.0); }

/// Turns or mirrors a pair of directions until the light stands where the file has it.
void RglBrdf::into_range(Vec& in, Vec& out) const {
    constexpr std::array<std::array<int, 2>, 4> kSigns = {{{1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};
    const std::size_t images = symmetry_ == TurnSymmetry::two_planes  ? 4
                               : symmetry_ == TurnSymmetry::half_turn ? 2
                                                                      : 1;
    for (std::size_t k = 0; k < images; ++k) {
        const auto [x, y] = kSigns[k];
        const Vec image = {x * in.x, y * in.y, in.z};
        const double past = wrapped_degrees(phi_of(image) - phi_i_.front());
        if (past > phi_i_.back() - phi_i_.front() + 1e-9) continue;
        in = image;
        out = {x * out.x, y * out.y, out.z};
        return;
    }
}

std::array<double, 3> RglBrdf::value(Vec in, Vec out) const {
    if (!isotropic()) into_range(in, out);
    const double phi = phi_of(in);
    if (!isotropic())
        return value_at(theta_of(in), phi_i_.front() + wrapped_degrees(phi - phi_i_.front()), out);
    const double c = std::cos(phi * kDegree), s = std::sin(phi * kDegree);
    return value_at(theta_of(in), phi_i_.front(),
                    {c * out.x + s * out.y, c * out.y - s * out.x, out.z});
}

std::array<double, 3> RglBrdf::value_at(double theta_i, double phi_i, Vec out) const {
    const Vec half = direction(theta_i, phi_i) + out;
    const double length = std::sqrt(dot(half, half));
    if (out.z <= 0 || length < 1e-9) return {0, 0, 0};
    const double u = root_of_theta(theta_of(half));
    const double turn = (phi_of(half) + 180.0) / 360.0;
    const double v = turn - std::floor(turn);
    const Mix mix = mix_at(theta_i, phi_i);
    const Place s = warp(mix, u, v);
    double scale = 1;
    if (jacobian_) {
        // The float of -pi lies a hair before the table's first column: no whole turn from it.
        const double turns = phi_i / 360 + 0.5;
        const double across = turns < -1e-6 || turns > 1 + 1e-6 ? turns - std::floor(turns) : turns;
        scale = bilinear(ndf_, 0, u, v) /
                (4 * bilinear(sigma_, 0, root_of_theta(theta_i), isotropic() ? 0.5 : across));
    }
    std::array<double, 3> result{};
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < mix.count; ++k)
            result[c] += scale * mix.share[k] * bilinear(rgb_, 3 * mix.slice[k] + c, s.u, s.v);
    return result;
}

std::array<double, 2> RglBrdf::valid_share() const {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    if (valid_.empty()) return {kNone, kNone};
    constexpr std::size_t kSide = 16;
    std::array<double, 2> set{}, all{};
    // Real files have eight; a hostile one may have many thousands.
    const std::size_t step = (theta_i_.size() + 7) / 8;
    for (std::size_t slice = 0; slice < theta_i_.size(); slice += step)
        for (std::size_t n = 0; n < kSide * kSide; ++n) {
            const double u = (static_cast<double>(n % kSide) + 0.5) / kSide;
            const double v = (static_cast<double>(n / kSide) + 0.5) / kSide;
            const Vec in = direction(theta_i_[slice], phi_i_.front()), half = half_vector(u, v);
            const bool above = (2 * dot(in, half) * half - in).z > 0;
            const Place s = warp(mix_at(theta_i_[slice], phi_i_.front()), u, v);
            const auto node = [](double place, std::size_t nodes) {
                return static_cast<std::size_t>(
                    std::lround(std::clamp(place, 0.0, 1.0) * static_cast<double>(nodes - 1)));
            };
            const std::size_t bit =
                (slice * rgb_.height + node(s.v, rgb_.height)) * rgb_.width + node(s.u, rgb_.width);
            all[above ? 0 : 1] += 1;
            set[above ? 0 : 1] += valid_[bit / 8] >> (7 - bit % 8) & 1;
        }
    return {all[0] > 0 ? set[0] / all[0] : kNone, all[1] > 0 ? set[1] / all[1] : kNone};
}

}  // namespace kiln::measured
