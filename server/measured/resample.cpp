// SPDX-License-Identifier: Apache-2.0
#include "server/measured/resample.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/compute/native.h"
#include "server/compute/quadrature.h"

namespace kiln::measured {
namespace {

/// Points that are summed in working precision.
constexpr unsigned kRuleBatch = 256;

std::size_t padded(std::size_t count) { return (count + kLanesMax - 1) / kLanesMax * kLanesMax; }

std::vector<float> rule_points(const AlbedoRule& rule) {
    const std::vector<double> nodes = gauss_legendre({rule.rings});
    std::vector<float> points;
    for (unsigned spoke = 0; spoke < rule.spokes; ++spoke)
        for (unsigned ring = 0; ring < rule.rings; ++ring) {
            const double turn = 2 * std::numbers::pi * (spoke + 0.5) / rule.spokes;
            const double weight = nodes[2 * ring + 1] * 2 * std::numbers::pi / rule.spokes;
            for (const double value : {nodes[2 * ring], std::cos(turn), std::sin(turn), weight})
                points.push_back(static_cast<float>(value));
        }
    return points;
}

std::vector<BatchRange> rule_batches(const AlbedoRule& rule) {
    std::vector<BatchRange> batches;
    const unsigned count = rule.rings * rule.spokes;
    for (unsigned first = 0; first < count; first += kRuleBatch)
        batches.push_back({first, std::min(kRuleBatch, count - first)});
    return batches;
}

void place_light(std::vector<float>& places, std::size_t stride, std::size_t n, double theta_in) {
    const double theta = theta_in * kDegree;
    places[n] = static_cast<float>(theta);
    places[stride + n] = static_cast<float>(std::cos(theta));
    places[2 * stride + n] = static_cast<float>(std::sin(theta));
}

}  // namespace

Resampler::Resampler(Backend* backend) : backend_(backend) {
    if (backend_) return;
    pool_ = std::make_unique<ThreadPool>(0);
    own_ = make_native_backend(*pool_, usable_instruction_sets().front());
    backend_ = own_.get();
}

Sampled Resampler::values(const LobeTables& tables, double theta_in, std::span<const Vec> out) {
    return values(tables, std::vector<double>(out.size(), theta_in), out);
}

Sampled Resampler::values(const LobeTables& tables, std::span<const double> theta_in,
                          std::span<const Vec> out) {
    const std::size_t count = out.size(), stride = padded(count);
    std::vector<float> places(6 * stride), found(4 * stride);
    for (std::size_t n = 0; n < stride; ++n) {
        const std::size_t from = std::min(n, count - 1);
        place_light(places, stride, n, theta_in[from]);
        places[3 * stride + n] = static_cast<float>(out[from].x);
        places[4 * stride + n] = static_cast<float>(out[from].y);
        places[5 * stride + n] = static_cast<float>(out[from].z);
    }
    MeasuredLaunch<float> launch{{MeasuredOperation::values, Precision::float32},
                                 tables.shape,
                                 tables.nodes,
                                 tables.curves,
                                 stride,
                                 places,
                                 {},
                                 {},
                                 found};
    backend_->run(launch);
    const auto plane = [&](std::size_t k) {
        const auto start = found.begin() + static_cast<std::ptrdiff_t>(k * stride);
        return std::vector<float>(start, start + static_cast<std::ptrdiff_t>(count));
    };
    return {plane(0), plane(1), plane(2), plane(3)};
}

std::vector<Material::Albedo> Resampler::albedos(const LobeTables& tables,
                                                 std::span<const double> theta_in,
                                                 AlbedoRule rule) {
    const std::size_t count = theta_in.size(), stride = padded(count);
    const std::vector<float> points = rule_points(rule);
    const std::vector<BatchRange> batches = rule_batches(rule);
    std::vector<float> places(3 * stride), found(batches.size() * 4 * stride);
    for (std::size_t n = 0; n < stride; ++n)
        place_light(places, stride, n, theta_in[std::min(n, count - 1)]);
    backend_->run(MeasuredLaunch<float>{{MeasuredOperation::albedos, Precision::float32},
                                        tables.shape,
                                        tables.nodes,
                                        tables.curves,
                                        stride,
                                        places,
                                        points,
                                        batches,
                                        found});
    std::vector<Material::Albedo> result(count);
    for (std::size_t n = 0; n < count; ++n) {
        Material::Albedo& sum = result[n];
        double beyond = 0;
        for (std::size_t b = 0; b < batches.size(); ++b) {
            const float* batch = found.data() + b * 4 * stride + n;
            for (std::size_t k = 0; k < 3; ++k)
                sum.value[k] += static_cast<double>(batch[k * stride]);
            beyond += static_cast<double>(batch[3 * stride]);
        }
        sum.extrapolated = sum.value[1] > 0 ? beyond / sum.value[1] : 0;
    }
    return result;
}

Material::Albedo Resampler::average_albedo(const LobeTables& tables, AlbedoRule rule) {
    // E is smooth between incidences and has a kink at each.
    constexpr unsigned kNodes = 5;
    const std::vector<double> nodes = gauss_legendre({kNodes});
    std::vector<double> ends, angles, weights;
    for (const std::size_t n : tables.measured) ends.push_back(tables.theta_in[n]);
    ends.insert(ends.begin(), 0.0);
    ends.push_back(90.0);
    for (std::size_t n = 0; n + 1 < ends.size(); ++n)
        for (unsigned k = 0; k < kNodes; ++k) {
            const double width = ends[n + 1] - ends[n], theta = ends[n] + width * nodes[2 * k];
            if (width <= 0) continue;
            angles.push_back(theta);
            weights.push_back(nodes[2 * k + 1] * width * kDegree * std::sin(2 * theta * kDegree));
        }
    Material::Albedo mean;
    double beyond = 0;
    const std::vector<Material::Albedo> all = albedos(tables, angles, rule);
    for (std::size_t n = 0; n < all.size(); ++n) {
        for (std::size_t k = 0; k < 3; ++k) mean.value[k] += weights[n] * all[n].value[k];
        beyond += weights[n] * all[n].extrapolated * all[n].value[1];
    }
    mean.extrapolated = mean.value[1] > 0 ? beyond / mean.value[1] : 0;
    return mean;
}

std::vector<KernelKind> resampler_kernels() {
    return {MeasuredKind{MeasuredOperation::values, Precision::float32},
            MeasuredKind{MeasuredOperation::albedos, Precision::float32}};
}

}  // namespace kiln::measured
