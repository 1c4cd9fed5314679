// SPDX-License-Identifier: Apache-2.0
#include "tests/reference/fresnel_models.h"

#include <cmath>
#include <stdexcept>

#include "tests/reference/tanh_sinh.h"

namespace kiln::reference {
namespace {

double unpolarised(double cosine, std::complex<double> index) {
    const double sine2 = (1 - cosine) * (1 + cosine);
    const std::complex<double> transmitted = std::sqrt(1.0 - sine2 / (index * index));
    const auto s = (cosine - index * transmitted) / (cosine + index * transmitted);
    const auto p = (index * cosine - transmitted) / (index * cosine + transmitted);
    return (std::norm(s) + std::norm(p)) / 2;
}

double schlick(double f0, double f90, double exponent, double cosine) {
    return f0 + (f90 - f0) * std::pow(1 - cosine, exponent);
}

}  // namespace

Fresnel fresnel_none() {
    return {[](double) { return 1.0; }, {}};
}

Fresnel fresnel_schlick(double f0, double f90, double exponent) {
    return {[=](double cosine) { return schlick(f0, f90, exponent, cosine); }, {}};
}

Fresnel fresnel_dielectric(double ior) {
    if (!(ior > 0)) throw std::domain_error("reference: ior is not above 0");
    Fresnel fresnel{[ior](double cosine) { return unpolarised(cosine, ior); }, {}};
    if (ior < 1) fresnel.kinks.push_back(std::sqrt((1 - ior) * (1 + ior)));
    return fresnel;
}

Fresnel fresnel_conductor(double eta, double k) {
    const std::complex<double> index(eta, k);
    return {[index](double cosine) { return unpolarised(cosine, index); }, {}};
}

std::complex<double> index_of_edge_tint(double reflectivity, double edge_tint) {
    if (!(reflectivity >= 0 && reflectivity <= 0.99 && edge_tint >= 0 && edge_tint <= 1))
        throw std::domain_error("reference: edge tint outside [0, 0.99] x [0, 1]");
    const double r = reflectivity, root = std::sqrt(r);
    const double lowest = (1 - r) / (1 + r), highest = (1 + root) / (1 - root);
    const double n = edge_tint * lowest + (1 - edge_tint) * highest;
    // Never negative but by rounding where n is the highest: there k = 0.
    const double k2 = (r * (n + 1) * (n + 1) - (n - 1) * (n - 1)) / (1 - r);
    return {n, std::sqrt(std::max(0.0, k2))};
}

Fresnel fresnel_edge_tint(double reflectivity, double edge_tint) {
    const auto index = index_of_edge_tint(reflectivity, edge_tint);
    return fresnel_conductor(index.real(), index.imag());
}

Fresnel fresnel_f82_tint(double f0, double f82) {
    const double bend = 1.0 / 7;
    const double missing = schlick(f0, 1, 5, bend) * (1 - f82);
    const double b = missing / (bend * std::pow(1 - bend, 6));
    return {[=](double cosine) {
                return schlick(f0, 1, 5, cosine) - b * cosine * std::pow(1 - cosine, 6);
            },
            {}};
}

double fresnel_average(const Fresnel& fresnel) {
    std::vector<double> ends{0};
    ends.insert(ends.end(), fresnel.kinks.begin(), fresnel.kinks.end());
    ends.push_back(1);
    std::sort(ends.begin(), ends.end());
    return converge(
        [&](int level) {
            const TanhSinh& rule = tanh_sinh(level);
            double sum = 0;
            for (std::size_t part = 0; part + 1 < ends.size(); ++part) {
                const double length = ends[part + 1] - ends[part];
                for (std::size_t j = 0; j < rule.weight.size(); ++j) {
                    const double cosine = ends[part] + length * rule.from0[j];
                    sum += length * rule.weight[j] * cosine * fresnel.at(std::min(1.0, cosine));
                }
            }
            return 2 * sum;
        },
        1e-12, 0, Magnitude{}, 4);
}

}  // namespace kiln::reference
