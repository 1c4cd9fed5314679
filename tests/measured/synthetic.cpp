// SPDX-License-Identifier: Apache-2.0
#include "tests/measured/synthetic.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>

namespace kiln::synthetic {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;

std::string digits(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.7g", value);
    return text;
}

}  // namespace

Material lambert(std::array<double, 3> albedo) {
    return [albedo](const Cosines&) {
        return std::array{albedo[0] / kPi, albedo[1] / kPi, albedo[2] / kPi};
    };
}

Material ggx(double alpha, std::array<double, 3> f0, std::array<double, 3> diffuse) {
    return [=](const Cosines& c) {
        const double a2 = alpha * alpha;
        const double bowl = c.NoH * c.NoH * (a2 - 1) + 1;
        const double d = a2 / (kPi * bowl * bowl);
        const double v = 0.5 / (c.NoL * std::sqrt(a2 + (1 - a2) * c.NoV * c.NoV) +
                                c.NoV * std::sqrt(a2 + (1 - a2) * c.NoL * c.NoL));
        const double s = std::pow(1 - c.VoH, 5.0);
        std::array<double, 3> f{};
        for (std::size_t k = 0; k < 3; ++k)
            f[k] = diffuse[k] / kPi + d * v * (f0[k] + (1 - f0[k]) * s);
        return f;
    };
}

Cosines cosines(double theta_i, double theta_o, double phi) {
    const double ci = std::cos(theta_i * kDegree), si = std::sin(theta_i * kDegree);
    const double co = std::cos(theta_o * kDegree), so = std::sin(theta_o * kDegree);
    const double between = ci * co + si * so * std::cos(phi * kDegree);
    const double half = std::sqrt(0.5 * (1 + between));  // cosine of half the angle
    return {ci, co, (ci + co) / (2 * half), half};
}

namespace {

constexpr std::array<double, 4> kLoftLights = {10, 30, 50, 70};

std::string written(const char* format, double value) {
    char text[32];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

}  // namespace

std::string zemax_file(const Material& material) {
    const std::vector<double> radial = {0, 5, 10, 15, 20, 30, 40, 50, 60, 70, 80, 90};
    std::string text =
        "Source\tMeasured\nSymmetry\tPlaneSymmetrical\nSpectralContent\tMonochrome\n"
        "ScatterType\tBRDF\nSampleRotation\t1\n0\nAngleOfIncidence\t4\n10\t30\t50\t70\n"
        "ScatterAzimuth\t19\n";
    for (int azimuth = 0; azimuth <= 180; azimuth += 10) text += std::to_string(azimuth) + "\t";
    text += "\nScatterRadial\t12\n";
    for (const double r : radial) text += digits(r) + "\t";
    text += "\n\nMonochrome\nDataBegin\n";
    for (const double light : kLoftLights) {
        text += "TIS\t0.1\n";
        const double c = std::cos(light * kDegree), s = std::sin(light * kDegree);
        for (int azimuth = 0; azimuth <= 180; azimuth += 10) {
            for (const double r : radial) {
                // Light at azimuth 0: the mirror direction is (-s, 0, c), towards the normal (c, 0,
                // s).
                const double across = std::sin(r * kDegree), along = std::cos(r * kDegree);
                const double ca = std::cos(azimuth * kDegree), sa = std::sin(azimuth * kDegree);
                const double x = -s * along + c * across * ca, y = across * sa;
                const double z = c * along + s * across * ca;
                const double theta = std::acos(std::min(1.0, z)) / kDegree;
                const double f =
                    z <= 1e-9 ? 0.0
                              : material(cosines(light, theta, std::atan2(y, x) / kDegree))[0];
                text += written("%.3e\t", f);
            }
            text += "\n";
        }
    }
    return text + "DataEnd\n";
}

std::string fred_file(const Material& material) {
    std::string text = "type bsdf_data\nformat angles=deg bsdf=value scale=1\n";
    for (const double light : kLoftLights) {
        text += digits(light) + "\t0\n";
        for (int theta = 0; theta <= 80; theta += 5)
            for (int phi = 0; phi <= (theta == 0 ? 0 : 180); phi += 10)  // 0: the mirror's side
                text += digits(theta) + "\t" + digits(phi) + "\t" +
                        written("%.6f\n", material(cosines(light, theta, 180 - phi))[0]);
    }
    return text;
}

std::string merl_file(const Material& material, int azimuths) {
    const std::array<std::int32_t, 3> dims = {90, 90, azimuths};
    const std::size_t cells = std::size_t{90} * 90 * static_cast<std::size_t>(azimuths);
    std::string bytes(12 + 24 * cells, '\0');
    std::memcpy(bytes.data(), dims.data(), 12);
    const std::array<double, 3> scale = {1500 / 1.00, 1500 / 1.15, 1500 / 1.66};
    for (std::size_t h = 0; h < 90; ++h)
        for (std::size_t d = 0; d < 90; ++d)
            for (std::size_t p = 0; p < static_cast<std::size_t>(azimuths); ++p) {
                const double root = (static_cast<double>(h) + 0.5) / 90;
                const double th = root * root * kPi / 2;
                const double td = (static_cast<double>(d) + 0.5) * kDegree;
                const double pd = (static_cast<double>(p) + 0.5) * kDegree;
                // The spherical law of cosines, about the half vector.
                const double along = std::cos(th) * std::cos(td);
                const double across = std::sin(th) * std::sin(td) * std::cos(pd);
                const double NoL = along - across, NoV = along + across;
                std::array<double, 3> f = {-1, -1, -1};
                if (NoL > 0 && NoV > 0) f = material({NoL, NoV, std::cos(th), std::cos(td)});
                const std::size_t n = p + static_cast<std::size_t>(azimuths) * (d + 90 * h);
                for (std::size_t c = 0; c < 3; ++c) {
                    const double stored = f[c] * scale[c];
                    std::memcpy(bytes.data() + 12 + 8 * (c * cells + n), &stored, 8);
                }
            }
    return bytes;
}

std::string minidiff_file(const Material& material, const MiniDiffGrid& grid) {
    const auto axis = [](double step, double last) {
        std::vector<double> list;
        for (int k = 0; k * step <= last + 1e-9; ++k) list.push_back(k * step);
        return list;
    };
    const auto azimuth = axis(grid.azimuth_step, 360),
               radial = axis(grid.radial_step, grid.radial_max);
    const auto row = [](const std::vector<double>& list) {
        std::string text;
        for (const double v : list) text += (text.empty() ? "" : "\t") + digits(v);
        return text + "\n";
    };
    std::string text = "#written by a test\nModel #: " + grid.model +
                       "\nSource\tMeasured\nSymmetry\tAsymmetric\nSpectralContent\tMonochrome\n";
    text += "ScatterAzimuth\t" + std::to_string(azimuth.size()) + "\n" + row(azimuth);
    text += "ScatterRadial\t" + std::to_string(radial.size()) + "\n" + row(radial) + "DataBegin\n";
    const std::array<int, 3> wavelength = {630, 525, 465};
    for (std::size_t c = 0; c < 3; ++c)
        for (const double aoi : grid.aoi) {
            text += "\nAOI " + digits(aoi) + "\nPOI 0\nSide Front\nWavelength " +
                    std::to_string(wavelength[c]) + "\nScatterType BRDF\nTIS 0.5\n";
            for (const double phi : azimuth) {
                std::vector<double> values;
                for (const double theta : radial)
                    values.push_back(material(cosines(aoi, theta, phi - grid.light_azimuth))[c]);
                text += row(values);
            }
        }
    return text + "DataEnd\n";
}

}  // namespace kiln::synthetic
