// SPDX-License-Identifier: Apache-2.0
#include "tests/reference/microfacet_models.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace kiln::reference {
namespace {

constexpr double kPi = std::numbers::pi;

double tangent_of(double cosine) { return std::sqrt((1 - cosine) * (1 + cosine)) / cosine; }

/// G1 / cosine of Schlick's fit to Smith's term.
double karis_over_cosine(double k, double cosine) { return 1 / (cosine * (1 - k) + k); }

/// The exponent of Lambda below 1/2: a / (1 + b x^c) + d x + e with constants mixed between the
/// two ends of the roughness.
double charlie_exponent(double alpha, double x) {
    const double smooth[] = {25.3245, 3.32435, 0.16801, -1.27393, -4.85967};
    const double rough[] = {21.5473, 3.82987, 0.19823, -1.97760, -4.32054};
    double c[5];
    const double weight = (1 - alpha) * (1 - alpha);
    for (int i = 0; i < 5; ++i) c[i] = weight * smooth[i] + (1 - weight) * rough[i];
    return c[0] / (1 + c[1] * std::pow(x, c[2])) + c[3] * x + c[4];
}

}  // namespace

void check_lobe(const Microfacet& lobe) {
    if (!(lobe.alpha > 0 && lobe.alpha <= 1))
        throw std::domain_error("reference: alpha is not in (0, 1]");
    const bool sheen = lobe.distribution == Distribution::charlie;
    switch (lobe.visibility) {
        case Visibility::smith_correlated:
        case Visibility::smith_separable:
            if (sheen) throw std::domain_error("reference: charlie has no closed Smith Lambda");
            return;
        case Visibility::charlie:
        case Visibility::charlie_softened:
            if (!sheen)
                throw std::domain_error("reference: charlie masking is fitted to charlie only");
            return;
        default:
            return;
    }
}

double distribution(Distribution kind, double alpha, double tangent) {
    const double t2 = tangent * tangent, a2 = alpha * alpha;
    const double cos4 = 1 / ((1 + t2) * (1 + t2));
    switch (kind) {
        case Distribution::ggx:
            return a2 / (kPi * cos4 * (a2 + t2) * (a2 + t2));
        case Distribution::beckmann:
            return std::exp(-t2 / a2) / (kPi * a2 * cos4);
        case Distribution::charlie: {
            const double sine = tangent / std::sqrt(1 + t2);
            return (2 + 1 / alpha) * std::pow(sine, 1 / alpha) / (2 * kPi);
        }
    }
    throw std::domain_error("reference: unknown distribution");
}

double smith_lambda(Distribution kind, double alpha, double cosine) {
    const double slope = alpha * tangent_of(cosine);
    if (slope == 0) return 0;
    switch (kind) {
        case Distribution::ggx:
            return (std::sqrt(1 + slope * slope) - 1) / 2;
        case Distribution::beckmann: {
            const double a = 1 / slope;
            return std::exp(-a * a) / (2 * a * std::sqrt(kPi)) - std::erfc(a) / 2;
        }
        case Distribution::charlie:
            break;
    }
    throw std::domain_error("reference: charlie has no closed Smith Lambda");
}

double charlie_lambda(double alpha, double cosine) {
    if (cosine < 0.5) return std::exp(charlie_exponent(alpha, cosine));
    return std::exp(2 * charlie_exponent(alpha, 0.5) - charlie_exponent(alpha, 1 - cosine));
}

double visibility(const Microfacet& lobe, double NoV, double NoL) {
    const double alpha = lobe.alpha;
    switch (lobe.visibility) {
        case Visibility::smith_correlated:
            return 1 /
                   (1 + smith_lambda(lobe.distribution, alpha, NoV) +
                    smith_lambda(lobe.distribution, alpha, NoL)) /
                   (4 * NoV * NoL);
        case Visibility::smith_separable:
            return 1 / (1 + smith_lambda(lobe.distribution, alpha, NoV)) /
                   (1 + smith_lambda(lobe.distribution, alpha, NoL)) / (4 * NoV * NoL);
        case Visibility::karis_ibl:
            return karis_over_cosine(alpha / 2, NoV) * karis_over_cosine(alpha / 2, NoL) / 4;
        case Visibility::karis_direct: {
            const double k = (std::sqrt(alpha) + 1) * (std::sqrt(alpha) + 1) / 8;
            return karis_over_cosine(k, NoV) * karis_over_cosine(k, NoL) / 4;
        }
        case Visibility::unreal_joint:
            return 0.5 / (NoL * (NoV * (1 - alpha) + alpha) + NoV * (NoL * (1 - alpha) + alpha));
        case Visibility::neubelt:
            return 1 / (4 * (NoL + NoV - NoL * NoV));
        case Visibility::charlie:
            return 1 / (1 + charlie_lambda(alpha, NoV) + charlie_lambda(alpha, NoL)) /
                   (4 * NoV * NoL);
        case Visibility::charlie_softened: {
            const double soft = std::pow(charlie_lambda(alpha, NoL), 1 + 2 * std::pow(1 - NoL, 8));
            return 1 / (1 + charlie_lambda(alpha, NoV) + soft) / (4 * NoV * NoL);
        }
    }
    throw std::domain_error("reference: unknown visibility");
}

std::vector<double> visibility_kinks(Visibility kind) {
    if (kind == Visibility::charlie || kind == Visibility::charlie_softened) return {0.5, 1};
    return {};
}

}  // namespace kiln::reference
