// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "server/base/error.h"
#include "server/compute/quadrature.h"
#include "server/study/stability.h"

namespace kiln::stability {

namespace {

double error_of(double value, const Right& right) {
    if (value == right.value || value == right.pole) return 0;
    const double error = std::abs(value - right.value);
    return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
}

/// No tolerance is wide enough for what is no number.
double strain_of(std::optional<double> error, double tolerance) {
    if (!error || *error == 0) return 0;
    const bool numbers = std::isfinite(*error) && std::isfinite(tolerance);
    return numbers ? *error / tolerance : std::numeric_limits<double>::infinity();
}

std::size_t padded(std::size_t places) { return (places + kLanesMax - 1) / kLanesMax * kLanesMax; }

template <typename Scalar>
std::vector<Scalar> texels_of(std::span<const Place> places) {
    const std::size_t stride = padded(places.size());
    std::vector<Scalar> texels(2 * stride);
    for (std::size_t i = 0; i < stride; ++i) {
        const Place& place = places[std::min(i, places.size() - 1)];
        texels[i] = static_cast<Scalar>(place.NoV);
        texels[stride + i] = static_cast<Scalar>(place.alpha);
    }
    return texels;
}

}  // namespace

std::optional<double> Finding::error_float() const {
    std::optional<double> worst;
    for (const Arithmetic a : {kNativeFloat, kOpenClFloat})
        if (values[a]) worst = std::max(worst.value_or(0), error_of(*values[a], in_float));
    return worst;
}

std::optional<double> Finding::error_double() const {
    std::optional<double> worst;
    for (const Arithmetic a : {kNativeDouble, kOpenClDouble})
        if (values[a]) worst = std::max(worst.value_or(0), error_of(*values[a], in_double));
    return worst;
}

double Finding::strain() const {
    return std::max(strain_of(error_float(), in_float.tolerance),
                    strain_of(error_double(), in_double.tolerance));
}

bool Finding::passes() const { return strain() <= 1; }

void Findings::add(Finding finding) {
    ++values_;
    double strain = finding.strain();
    if (!finding.passes()) strain = std::numeric_limits<double>::infinity();
    const auto same = [&](const Finding& other) {
        return other.family == finding.family && other.row == finding.row &&
               other.column == finding.column && other.quantity == finding.quantity;
    };
    // What belongs together comes together: only the latest rows are worth a look.
    const std::size_t from = kept_.size() > 512 ? kept_.size() - 512 : 0;
    for (std::size_t i = from; i < kept_.size(); ++i) {
        if (!same(kept_[i])) continue;
        if (!(strain <= strains_[i])) {
            kept_[i] = std::move(finding);
            strains_[i] = strain;
        }
        return;
    }
    kept_.push_back(std::move(finding));
    strains_.push_back(strain);
}

void Bench::open(std::span<const KernelKind> kernels, std::span<const KernelKind> wide) {
    try {
        opencl_ = engine_.opencl(job_.device, kernels, control_, why_not_);
        std::string no_double;
        if (opencl_) opencl_double_ = engine_.opencl(job_.device, wide, control_, no_double);
    } catch (const Cancelled&) {
        throw;
    } catch (const Error& error) {
        opencl_ = opencl_double_ = nullptr;
        why_not_ = error.what();
    }
    if (!opencl_ && job_.device == DeviceChoice::opencl)
        throw Error("device_unavailable", why_not_);
}

DeviceReport Bench::device() const {
    if (opencl_) return {"opencl", opencl_->name(), kStrictNumerics, {}};
    const bool asked = job_.device == DeviceChoice::native;
    return {"native", engine_.native_name(), kStrictNumerics,
            asked ? std::nullopt : std::optional(why_not_)};
}

void Bench::look(double fraction) {
    fraction_ = fraction;
    control_.progress({fraction, {}});
    if (control_.cancelled()) throw Cancelled();
}

template <typename On>
void Bench::each(On on) {
    look();
    on(engine_.native(), 0.0f, Precision::float32, kNativeFloat);
    look();
    on(engine_.native(), 0.0, Precision::float64, kNativeDouble);
    look();
    if (opencl_) on(*opencl_, 0.0f, Precision::float32, kOpenClFloat);
    if (opencl_double_) on(*opencl_double_, 0.0, Precision::float64, kOpenClDouble);
}

template <typename Scalar>
void Bench::launch(Backend& backend, const KernelMaterial& material,
                   const std::array<double, kParameterCount>& parameters,
                   std::span<const double> points, std::span<const BatchRange> batches,
                   std::span<const Place> places, std::vector<double>& sums) {
    const std::size_t stride = padded(places.size());
    const std::vector<Scalar> texels = texels_of<Scalar>(places);
    const std::vector<Scalar> numbers(parameters.begin(), parameters.end());
    const std::vector<Scalar> own_points(points.begin(), points.end());
    const std::size_t rows =
        batches.size() *
        static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(material.terms)));
    std::vector<Scalar> out(rows * stride);
    const Precision precision =
        sizeof(Scalar) == sizeof(float) ? Precision::float32 : Precision::float64;
    backend.run(
        Launch<Scalar>{{material, precision}, stride, texels, own_points, numbers, batches, out});
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t i = 0; i < places.size(); ++i)
            sums.push_back(static_cast<double>(out[row * stride + i]));
    evaluations_ += points.size() / kPointScalars * places.size();
}

Bench::Sums Bench::run(const KernelMaterial& material,
                       const std::array<double, kParameterCount>& parameters,
                       std::span<const double> points, std::span<const BatchRange> batches,
                       std::span<const Place> places) {
    Sums sums;
    each([&](Backend& backend, auto scalar, Precision, Arithmetic arithmetic) {
        launch<decltype(scalar)>(backend, material, parameters, points, batches, places,
                                 sums[arithmetic]);
    });
    return sums;
}

Bench::Sums Bench::run(Masking masking, std::span<const Place> places) {
    constexpr QuadratureOrder order{56, 56};  // 4e-12, see server/compute/quadrature.h
    const std::vector<double> nodes = quadrature_nodes({}, order);
    const std::size_t stride = padded(places.size());
    Sums sums;
    each([&](Backend& backend, auto scalar, Precision precision, Arithmetic arithmetic) {
        using Scalar = decltype(scalar);
        const std::vector<Scalar> texels = texels_of<Scalar>(places);
        const std::vector<Scalar> own(nodes.begin(), nodes.end());
        std::vector<Scalar> values(3 * stride);
        const std::vector<Scalar> parameters(kQuadratureParameters);
        const QuadratureKind kind{SmithRule{masking, kSchlickWeight}, precision};
        backend.run(QuadratureLaunch<Scalar>{kind, stride, texels, own, parameters, order, values});
        for (std::size_t plane = 0; plane < 3; ++plane)
            for (std::size_t i = 0; i < places.size(); ++i)
                sums[arithmetic].push_back(static_cast<double>(values[plane * stride + i]));
        evaluations_ += places.size() * quadrature_evaluations(kind, order);
    });
    return sums;
}

Bench::Sums Bench::run(QuadratureKind kind, const QuadratureParameters& parameters,
                       std::span<const Place> places, bool on_opencl) {
    std::vector<double> NoV, alpha;
    for (const Place& place : places) NoV.push_back(place.NoV), alpha.push_back(place.alpha);
    Sums sums;
    each([&](Backend& backend, auto, Precision precision, Arithmetic arithmetic) {
        if (is_opencl(arithmetic) && !on_opencl) return;
        kind.precision = precision;
        const QuadratureResult result =
            integrate_quadrature(backend, kind, {NoV, alpha, parameters, {}}, {1e-9, 0});
        sums[arithmetic] = result.E;
        sums[arithmetic].insert(sums[arithmetic].end(), result.B.begin(), result.B.end());
        evaluations_ += result.evaluations;
    });
    return sums;
}

double Bench::average_deficit(Masking masking, double alpha) {
    const KernelMaterial lobe{.masking = static_cast<int>(masking)};
    return quadrature_averages(engine_.native(), quadrature_average_kind(lobe), {},
                               std::array{alpha}, 1e-9, [&] { look(); })
        .mean[0];
}

std::string plain(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

}  // namespace kiln::stability
