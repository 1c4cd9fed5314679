// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <compare>
#include <cstddef>
#include <span>
#include <variant>

#include "server/compute/measured_launch.h"
#include "server/compute/points.h"
#include "server/compute/quadrature_launch.h"
#include "server/compute/terms.h"
#include "server/spec/job_spec.h"

namespace kiln {

inline auto operator<=>(const KernelMaterial& a, const KernelMaterial& b) {
    const auto key = [](const KernelMaterial& m) {
        return std::array{m.distribution, m.masking, m.importance, m.terms,
                          m.averaged,     m.fresnel, m.diffuse,    m.general};
    };
    return key(a) <=> key(b);
}
inline bool operator==(const KernelMaterial& a, const KernelMaterial& b) { return a <=> b == 0; }

/// What a kernel is specialised on: what is computed, never how much of it. A closed set. What a
/// pass does not read stands at its default, so that equal passes share a program.
struct Specialisation {
    KernelMaterial material;
    Precision precision = Precision::float32;
    auto operator<=>(const Specialisation&) const = default;
};

/// Any kind of kernel: what an OpenCL program is built for.
using KernelKind = std::variant<Specialisation, QuadratureKind, MeasuredKind>;

/// Texel strides are multiples of this many lanes, the widest of all backends.
inline constexpr std::size_t kLanesMax = 16;

/// One device call: the sums of some batches at some texels.
template <typename Scalar>
struct Launch {
    Specialisation what;
    std::size_t texel_stride = 0;        ///< texels padded to kLanesMax
    std::span<const Scalar> texels;      ///< NoV of each, then alpha of each: 2 × texel_stride
    std::span<const Scalar> points;      ///< point_scalars() a point
    std::span<const Scalar> parameters;  ///< kParameterCount, uniform: kernels/material.h
    std::span<const BatchRange> batches;
    std::span<Scalar> sums;  ///< out: [batch][term asked for, by rising bit][texel_stride]
};

/// Where kernels run. Equal launches give equal bits on every backend of one numerics class.
class Backend {
  public:
    virtual ~Backend() = default;
    /// Places that are integrated to the end before the next ones start: enough to fill the device,
    /// few enough that even one batch of the longest is a short call on it, and that their sums
    /// stay in cache. A multiple of kLanesMax.
    virtual std::size_t block_places() const { return 8192; }
    /// Throws Error("device_failed") naming the call that failed.
    virtual void run(const Launch<float>& launch) = 0;
    virtual void run(const Launch<double>& launch) = 0;
    virtual void run(const QuadratureLaunch<float>& launch) = 0;
    virtual void run(const QuadratureLaunch<double>& launch) = 0;
    virtual void run(const MeasuredLaunch<float>& launch) = 0;
    virtual void run(const MeasuredLaunch<double>& launch) = 0;
};

}  // namespace kiln
