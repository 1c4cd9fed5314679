// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <numbers>

#include "tests/measured/synthetic.h"

namespace kiln::synthetic {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kNodes = 33;

template <typename T>
void put(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string floats(const std::vector<double>& values) {
    std::string data;
    for (const double value : values) put(data, static_cast<float>(value));
    return data;
}

/// f cos(theta_o) at node (x, y) of the unit square: half vectors at theta_h = pi / 2 x^2 and
/// azimuth 2 pi y - pi, light at azimuth 0; 0 below the horizon.
double stored(const Material& surface, double theta_in, double x, double y) {
    const double th = kPi / 2 * x * x, ph = 2 * kPi * y - kPi;
    const double hx = std::sin(th) * std::cos(ph), hy = std::sin(th) * std::sin(ph);
    const double hz = std::cos(th), s = std::sin(theta_in), c = std::cos(theta_in);
    const double facing = s * hx + c * hz;
    const double ox = 2 * facing * hx - s, oy = 2 * facing * hy, oz = 2 * facing * hz - c;
    if (oz <= 0) return 0;
    const double degree = kPi / 180;
    const double theta = std::acos(std::min(1.0, oz)) / degree, phi = std::atan2(oy, ox) / degree;
    return surface(cosines(theta_in / degree, theta, phi))[0] * oz;
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
    // Even densities and areas: the warp of the format is then the identity, and ndf / (4 sigma) 1.
    const std::vector<double> theta_in = {0, 0.35, 0.7, 1.05, 1.4};
    const std::uint64_t incidences = theta_in.size(), azimuths = layout.azimuths;
    const std::uint64_t places = azimuths * incidences * kNodes * kNodes;
    const bool spectral = !layout.nanometres.empty();
    const std::size_t planes = spectral ? layout.nanometres.size() : 3;
    std::vector<double> values;
    for (std::uint64_t a = 0; a < azimuths; ++a)
        for (const double theta : theta_in)
            for (std::size_t p = 0; p < planes; ++p)
                for (std::size_t n = 0; n < kNodes * kNodes; ++n)
                    values.push_back(stored(surface, theta,
                                            static_cast<double>(n % kNodes) / (kNodes - 1),
                                            static_cast<double>(n / kNodes) / (kNodes - 1)) *
                                     (spectral ? layout.reflectance(layout.nanometres[p]) : 1.0));
    std::vector<double> phi;
    for (std::uint64_t a = 0; a < azimuths; ++a) phi.push_back(0.4 * static_cast<double>(a));
    std::vector<TensorPart> parts = {
        {"description", 1, {9}, "synthetic"},
        {"phi_i", 10, {azimuths}, floats(phi)},
        {"theta_i", 10, {incidences}, floats(theta_in)},
        {"sigma", 10, {2, 4}, floats(std::vector<double>(8, 1.0))},
        {"ndf", 10, {2, 4}, floats(std::vector<double>(8, 4.0))},
        {"vndf",
         10,
         {azimuths, incidences, kNodes, kNodes},
         floats(std::vector<double>(places, 1.0))},
        {spectral ? "spectra" : "rgb",
         10,
         {azimuths, incidences, planes, kNodes, kNodes},
         floats(values)},
        {"jacobian", 1, {1}, std::string(1, '\1')},
    };
    if (spectral) parts.push_back({"wavelengths", 10, {planes}, floats(layout.nanometres)});
    return tensor_file(parts);
}

}  // namespace kiln::synthetic
