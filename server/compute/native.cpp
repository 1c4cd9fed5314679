// SPDX-License-Identifier: Apache-2.0
#include "server/compute/native.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "server/base/error.h"

namespace kiln {

namespace {

/// Texels that a thread takes at a time: enough that taking them costs nothing, few enough to share
/// out evenly, also where a block is small.
std::size_t texels_a_task(std::size_t texel_stride, std::size_t threads) {
    const std::size_t share = texel_stride / (4 * threads) / kLanesMax * kLanesMax;
    return std::clamp(share, kLanesMax, 16 * kLanesMax);
}

const NativeKernels& kernels_of(InstructionSet set) {
    switch (set) {
        case InstructionSet::v4:
            return kNativeV4;
        case InstructionSet::v3:
            return kNativeV3;
        case InstructionSet::v2:
            return kNativeV2;
    }
    __builtin_unreachable();
}

QuadratureNumbers numbers_of(const QuadratureKind& kind) {
    using Rule = QuadratureNumbers::Rule;
    const auto of = [](const auto& rule) -> QuadratureNumbers {
        using What = std::decay_t<decltype(rule)>;
        if constexpr (std::is_same_v<What, SmithRule>)
            return {Rule::smith, 0, static_cast<int>(rule.masking), rule.fresnel, 0, 0};
        else if constexpr (std::is_same_v<What, LobeRule>)
            return {Rule::lobe,
                    rule.distribution,
                    rule.masking,
                    rule.fresnel,
                    rule.total_reflection ? 1 : 0,
                    0};
        else
            return {Rule::diffuse, 0, 0, rule.fresnel, 0, rule.diffuse};
    };
    return std::visit(of, kind.rule);
}

class NativeBackend : public Backend {
  public:
    NativeBackend(ThreadPool& pool, InstructionSet set) : pool_(pool), kernels_(kernels_of(set)) {}

    /// Where the fused product is software, a sample takes some thirty times as long.
    std::size_t block_places() const override {
        return Backend::block_places() / (&kernels_ == &kNativeV2 ? 8 : 1);
    }
    void run(const Launch<float>& launch) override { run_groups(launch); }
    void run(const Launch<double>& launch) override { run_groups(launch); }
    void run(const QuadratureLaunch<float>& launch) override { run_quadrature(launch); }
    void run(const QuadratureLaunch<double>& launch) override { run_quadrature(launch); }
    void run(const MeasuredLaunch<float>& launch) override { run_measured(launch); }
    void run(const MeasuredLaunch<double>& launch) override { run_measured(launch); }

  private:
    /// Calls body(first lane) for each lane group of a launch, on all threads.
    template <typename Body>
    void each_group(std::size_t texel_stride, int lanes, Body body) {
        const auto step = static_cast<std::size_t>(lanes);
        const std::size_t task_texels = texels_a_task(texel_stride, pool_.size());
        pool_.parallel_for((texel_stride + task_texels - 1) / task_texels, [&](std::size_t task) {
            const std::size_t end = std::min((task + 1) * task_texels, texel_stride);
            for (std::size_t first = task * task_texels; first < end; first += step) body(first);
        });
    }

    template <typename Scalar>
    const NativeFunctions<Scalar>& functions() const {
        if constexpr (sizeof(Scalar) == sizeof(float))
            return kernels_.in_float;
        else
            return kernels_.in_double;
    }

    template <typename Scalar>
    void run_quadrature(const QuadratureLaunch<Scalar>& launch) {
        const QuadratureNumbers what = numbers_of(launch.what);
        const auto function = functions<Scalar>().find_quadrature(what);
        each_group(launch.texel_stride, functions<Scalar>().lanes, [&](std::size_t first) {
            function({launch.texels.data() + first,
                      launch.texels.data() + launch.texel_stride + first, launch.nodes.data(),
                      launch.parameters.data(), what, launch.order.elevation, launch.order.azimuth,
                      launch.texel_stride, launch.values.data() + first});
        });
    }

    template <typename Scalar>
    void run_measured(const MeasuredLaunch<Scalar>& launch) {
        const NativeFunctions<Scalar>& all = functions<Scalar>();
        const auto function = launch.what.operation == MeasuredOperation::values
                                  ? all.measured_values
                                  : all.measured_albedos;
        each_group(launch.stride, all.lanes, [&](std::size_t first) {
            function({launch.nodes.data(), launch.curves.data(), launch.shape,
                      launch.places.data() + first, launch.points.data(), launch.batches.data(),
                      static_cast<unsigned>(launch.batches.size()), launch.stride,
                      launch.values.data() + first});
        });
    }

    template <typename Scalar>
    void run_groups(const Launch<Scalar>& launch) {
        const auto function = functions<Scalar>().find(launch.what.material);
        each_group(launch.texel_stride, functions<Scalar>().lanes, [&](std::size_t first) {
            function({launch.texels.data() + first,
                      launch.texels.data() + launch.texel_stride + first, launch.points.data(),
                      launch.parameters.data(), launch.batches.data(),
                      static_cast<unsigned>(launch.batches.size()), launch.texel_stride,
                      launch.what.material, launch.sums.data() + first});
        });
    }

    ThreadPool& pool_;
    const NativeKernels& kernels_;
};

}  // namespace

std::vector<InstructionSet> usable_instruction_sets() {
    std::vector<InstructionSet> sets;
    if (__builtin_cpu_supports("x86-64-v4")) sets.push_back(InstructionSet::v4);
    if (__builtin_cpu_supports("x86-64-v3")) sets.push_back(InstructionSet::v3);
    if (__builtin_cpu_supports("x86-64-v2")) sets.push_back(InstructionSet::v2);
    if (sets.empty())
        throw Error("device_unavailable", "the native backend needs an x86-64-v2 CPU (SSE4.2)");
    return sets;
}

std::string to_string(InstructionSet set) {
    switch (set) {
        case InstructionSet::v4:
            return "x86-64-v4";
        case InstructionSet::v3:
            return "x86-64-v3";
        case InstructionSet::v2:
            return "x86-64-v2";
    }
    __builtin_unreachable();
}

std::unique_ptr<Backend> make_native_backend(ThreadPool& pool, InstructionSet set) {
    return std::make_unique<NativeBackend>(pool, set);
}

}  // namespace kiln
