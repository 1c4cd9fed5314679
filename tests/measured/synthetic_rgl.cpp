// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>

#include "tests/measured/synthetic.h"

namespace kiln::synthetic {
namespace {

constexpr double kPi = std::numbers::pi;

template <typename T>
void put(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string floats(const std::vector<double>& values) {
    std::string data;
    for (const double value : values) put(data, static_cast<float>(value));
    return data;
}

constexpr double kDegree = kPi / 180;

/// f by angles in degrees.
using Surface = std::function<double(double, double, double, double)>;

/// f cos(theta_o) at node (x, y) of the unit square: half vectors at theta_h = pi / 2 x^2 and
/// azimuth 2 pi y - pi, as the surface lies or, of an isotropic one, from the light; 0 below the
/// horizon.
double stored(const Surface& surface, double theta_in, double phi_in, double x, double y) {
    const double th = kPi / 2 * x * x, ph = 2 * kPi * y - kPi;
    const double hx = std::sin(th) * std::cos(ph), hy = std::sin(th) * std::sin(ph);
    const double hz = std::cos(th), s = std::sin(theta_in), c = std::cos(theta_in);
    const double ix = s * std::cos(phi_in), iy = s * std::sin(phi_in);
    const double facing = ix * hx + iy * hy + c * hz;
    const double ox = 2 * facing * hx - ix, oy = 2 * facing * hy - iy, oz = 2 * facing * hz - c;
    if (oz <= 0) return 0;
    return oz * surface(theta_in / kDegree, phi_in / kDegree,
                        std::acos(std::min(1.0, oz)) / kDegree, std::atan2(oy, ox) / kDegree);
}

/// Node n of so many over [0, 1].
double node(std::size_t n, std::size_t count) {
    return static_cast<double>(n) / static_cast<double>(count - 1);
}

std::string file_of(const Surface& surface, const RglLayout& layout) {
    // Even densities: the warp of the format is then the identity. Areas and normals are bilinear,
    // so that any place among their nodes is known.
    const std::vector<double> theta_in = {0, 0.35, 0.7, 1.05, 1.4};
    const std::uint64_t incidences = theta_in.size(), azimuths = layout.phi_in.size();
    const std::size_t side = layout.nodes;
    const bool spectral = !layout.nanometres.empty(), turns = azimuths > 2;
    const std::size_t planes = spectral ? layout.nanometres.size() : 3;
    const auto area = [turns](double u, double v) { return 1 + 0.3 * u + (turns ? 0.2 * v : 0.0); };
    const auto normals = [](double u, double v) { return 4 + u + 2 * v; };
    std::vector<double> values, phi, sigma, ndf, valid(azimuths * incidences * side * side);
    std::size_t place = 0;
    for (const double degrees : layout.phi_in) {
        phi.push_back(degrees * kDegree);
        for (const double theta : theta_in) {
            const double turn = turns ? degrees / 360 + 0.5 : 0.5;
            const double scale = area(std::sqrt(theta / (kPi / 2)), turn);
            for (std::size_t p = 0; p < planes; ++p)
                for (std::size_t n = 0; n < side * side; ++n) {
                    const double x = node(n % side, side), y = node(n / side, side);
                    const double value = stored(surface, theta, turns ? phi.back() : 0, x, y);
                    values.push_back(value * (4 * scale) / normals(x, y) *
                                     (spectral ? layout.reflectance(layout.nanometres[p]) : 1.0));
                    valid[place + n] = value > 0;
                }
            place += side * side;
        }
    }
    for (std::size_t n = 0; n < 16; ++n) {
        sigma.push_back(area(node(n % 4, 4), node(n / 4, 4)));
        ndf.push_back(normals(node(n % 4, 4), node(n / 4, 4)));
    }
    std::string bits((valid.size() + 7) / 8, '\0');
    for (std::size_t n = 0; n < valid.size(); ++n)
        if (valid[n] > 0) bits[n / 8] = static_cast<char>(bits[n / 8] | (0x80 >> n % 8));
    if (layout.mask) bits.assign(bits.size(), *layout.mask);
    std::vector<TensorPart> parts = {
        {"description", 1, {9}, "synthetic"},
        {"phi_i", 10, {azimuths}, floats(phi)},
        {"theta_i", 10, {incidences}, floats(theta_in)},
        {"sigma", 10, {4, 4}, floats(sigma)},
        {"ndf", 10, {4, 4}, floats(ndf)},
        {"vndf",
         10,
         {azimuths, incidences, side, side},
         floats(std::vector<double>(valid.size(), 1.0))},
        {spectral ? "spectra" : "rgb",
         10,
         {azimuths, incidences, planes, side, side},
         floats(values)},
        {"jacobian", 1, {1}, std::string(1, '\1')},
        {"valid", 1, {bits.size()}, bits},
    };
    if (spectral) parts.push_back({"wavelengths", 10, {planes}, floats(layout.nanometres)});
    return tensor_file(parts);
}

}  // namespace

std::string tensor_file(const std::vector<TensorPart>& parts) {
    std::size_t directory = 18;
    for (const TensorPart& f : parts) directory += 2 + f.name.size() + 11 + 8 * f.shape.size();
    std::string head("tensor_file\0\1\0", 14), payload;
    put(head, static_cast<std::uint32_t>(parts.size()));
    for (const TensorPart& f : parts) {
        put(head, static_cast<std::uint16_t>(f.name.size()));
        head += f.name;
        put(head, static_cast<std::uint16_t>(f.shape.size()));
        put(head, f.type);
        put(head, static_cast<std::uint64_t>(directory + payload.size()));
        for (const std::uint64_t size : f.shape) put(head, size);
        payload += f.data;
    }
    return head + payload;
}

std::string rgl_file(const Material& surface, const RglLayout& layout) {
    return file_of(
        [&surface](double theta_i, double phi_i, double theta_o, double phi_o) {
            return surface(cosines(theta_i, theta_o, phi_o - phi_i))[0];
        },
        layout);
}

std::string rgl_file(const Brushed& surface, const RglLayout& layout) {
    return file_of(surface, layout);
}

double Brushed::operator()(double theta_i, double phi_i, double theta_o, double phi_o) const {
    const double ci = std::cos(theta_i * kDegree), si = std::sin(theta_i * kDegree);
    const double co = std::cos(theta_o * kDegree), so = std::sin(theta_o * kDegree);
    const double ix = si * std::cos(phi_i * kDegree), iy = si * std::sin(phi_i * kDegree);
    const double ox = so * std::cos(phi_o * kDegree), oy = so * std::sin(phi_o * kDegree);
    // Slopes of the half vector (Heitz 2014, "Understanding the Masking-Shadowing Function").
    const double sx = (ix + ox) / (ci + co) / alpha_x, sy = (iy + oy) / (ci + co) / alpha_y;
    const double length2 = 2 * (1 + ix * ox + iy * oy + ci * co);
    const double cos2 = (ci + co) * (ci + co) / length2, bowl = cos2 * (1 + sx * sx + sy * sy);
    const double d = 1 / (kPi * alpha_x * alpha_y * bowl * bowl);
    const auto lambda = [this](double x, double y, double z) {
        return 0.5 *
               (std::sqrt(1 + (x * x * alpha_x * alpha_x + y * y * alpha_y * alpha_y) / (z * z)) -
                1);
    };
    const double masking = 1 / (1 + lambda(ix, iy, ci) + lambda(ox, oy, co));
    const double schlick = std::pow(1 - 0.5 * std::sqrt(length2), 5.0);
    return diffuse / kPi + d * masking * (f0 + (1 - f0) * schlick) / (4 * ci * co);
}

std::string csv_file(const Brushed& surface, const std::vector<double>& theta_in,
                     const std::vector<double>& phi_in, double step) {
    std::string text = "theta_in,phi_in,theta_out,phi_out,value\n";
    for (const double ti : theta_in)
        for (const double pi : phi_in)
            for (double to = 0; to <= 75; to += step)
                for (double po = 0; po < (to > 0 ? 360 : step); po += step) {
                    char line[96];
                    std::snprintf(line, sizeof line, "%g,%g,%g,%g,%.7g\n", ti, pi, to, po,
                                  surface(ti, pi, to, po));
                    text += line;
                }
    return text;
}

}  // namespace kiln::synthetic
