// SPDX-License-Identifier: Apache-2.0
// Samples a second of every kernel specialisation on both backends: a 64 × 64 table, 1024 samples a
// texel.
//
// The arithmetic limit of the split sum (visible normals, correlated Smith, float), counted for one
// sample of one lane group: 2 √ (the cap's sine, the light's Smith length) and 1 ÷ (G2 / G1) on the
// divider; 20 products, sums, fused products and selections for E, 20 more for B (the reciprocal
// root, Schlick, the sum). On a core with a 16-lane √ every 4.8 ns, ÷ every 3.9 ns and one such
// operation every 0.23 ns (measured), E is bound by the divider at 13.5 ns, A and B by the
// same 13.5 ns as long as the other 40 operations (9.2 ns, and 2.1 ns for the divider's own) run
// beside it: 1.2 G samples/s a core.
#include <benchmark/benchmark.h>

#include <map>
#include <memory>
#include <string>

#include "server/base/error.h"
#include "server/compute/native.h"
#include "server/compute/opencl.h"
#include "server/compute/opencl_threads.h"

namespace {

using namespace kiln;

constexpr std::size_t kSide = 64, kStride = kSide * kSide, kSamples = 1024;

template <typename Scalar>
void run(benchmark::State& state, Backend& backend, const Specialisation& what) {
    std::vector<Scalar> texels(2 * kStride);
    for (std::size_t i = 0; i < kStride; ++i) {
        texels[i] = static_cast<Scalar>((static_cast<double>(i % kSide) + 0.5) / kSide);
        const double roughness = (static_cast<double>(i / kSide) + 0.5) / kSide;
        texels[kStride + i] = static_cast<Scalar>(roughness * roughness);
    }
    const PointSet set = make_points(Sampler::sobol_owen, point_kind(what.material), 0, kSamples);
    const std::vector<Scalar> points(set.values.begin(), set.values.end());
    const auto parameters = any_parameters<Scalar>();
    std::vector<Scalar> sums(
        set.batches.size() *
        static_cast<std::size_t>(__builtin_popcount(static_cast<unsigned>(what.material.terms))) *
        kStride);
    for (auto _ : state) {
        backend.run(Launch<Scalar>{what, kStride, texels, points, parameters, set.batches, sums});
        benchmark::DoNotOptimize(sums.data());
    }
    state.counters["samples/s"] = benchmark::Counter(static_cast<double>(kStride * kSamples),
                                                     benchmark::Counter::kIsIterationInvariantRate);
}

void add(const std::string& name, Backend& backend, const Specialisation& what) {
    benchmark::RegisterBenchmark(name.c_str(),
                                 [&backend, what](benchmark::State& state) {
                                     if (what.precision == Precision::float64)
                                         run<double>(state, backend, what);
                                     else
                                         run<float>(state, backend, what);
                                 })
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
}

const std::map<std::string, Specialisation> kCases = {
    {"E", {{.terms = 1}}},
    {"A_B", {{.terms = 3}}},
    {"A_B_multiscatter", {{.terms = 7}}},
    {"multiscatter", {{.terms = 4}}},
    {"E_separable", {{.masking = 1, .terms = 1}}},
    {"A_B_ndf", {{.importance = 1, .terms = 3}}},
    {"E_avg", {{.terms = 1, .averaged = 1}}},
    {"A_B_float64", {{.terms = 3}, Precision::float64}},
    // Cost against the number of terms, on the fast path and on the general one (Schlick's F of one
    // channel up to three). What is not asked for is not in the kernel.
    {"terms/fast_1_E", {{.terms = 1}}},
    {"terms/fast_2_A_B", {{.terms = 3}}},
    {"terms/fast_3_A_B_deficit", {{.terms = 7}}},
    {"terms/general_1_E", {{.terms = 1, .general = 1}}},
    {"terms/general_2_F", {{.terms = 9, .fresnel = 1, .general = 1}}},
    {"terms/general_4_F_RGB", {{.terms = 57, .fresnel = 1, .general = 1}}},
    {"terms/general_5_F_RGB_deficit", {{.terms = 61, .fresnel = 1, .general = 1}}},
    {"terms/general_6_F_RGB_B_deficit", {{.terms = 63, .fresnel = 1, .general = 1}}},
    // The general path (kernels/material.h), by the numbers of kernels/*.h.
    {"schlick", {{.terms = 8, .fresnel = 1, .general = 1}}},
    {"dielectric", {{.terms = 8, .fresnel = 3, .general = 1}}},
    {"conductor_RGB", {{.terms = 56, .fresnel = 4, .general = 1}}},
    {"f82_tint_RGB", {{.terms = 56, .fresnel = 5, .general = 1}}},
    {"karis_ibl", {{.masking = 2, .terms = 1, .general = 1}}},
    {"unreal_joint", {{.masking = 4, .terms = 1, .general = 1}}},
    {"beckmann", {{.distribution = 1, .importance = 1, .terms = 1, .general = 1}}},
    {"charlie_neubelt",
     {{.distribution = 2, .masking = 5, .importance = 3, .terms = 1, .general = 1}}},
    {"charlie", {{.distribution = 2, .masking = 6, .importance = 3, .terms = 1, .general = 1}}},
    {"lambert", {{.importance = 2, .terms = 64, .diffuse = 0, .general = 1}}},
    {"burley", {{.importance = 2, .terms = 64, .diffuse = 1, .general = 1}}},
    {"oren_nayar", {{.importance = 2, .terms = 64, .diffuse = 2, .general = 1}}},
    {"oren_nayar_full", {{.importance = 2, .terms = 64, .diffuse = 3, .general = 1}}},
    {"fon", {{.importance = 2, .terms = 64, .diffuse = 4, .general = 1}}},
    {"eon", {{.importance = 2, .terms = 64, .diffuse = 5, .general = 1}}},
    {"eon_unreal", {{.importance = 2, .terms = 64, .diffuse = 6, .general = 1}}},
    {"chan2018", {{.importance = 2, .terms = 64, .diffuse = 7, .general = 1}}},
    {"chan2024", {{.importance = 2, .terms = 64, .diffuse = 8, .general = 1}}},
};

}  // namespace

int main(int argc, char** argv) {
    pin_opencl_threads();
    ThreadPool one(1), all(0);
    std::vector<std::unique_ptr<Backend>> backends;
    for (const InstructionSet set : usable_instruction_sets()) {
        backends.push_back(make_native_backend(one, set));
        add("native/" + to_string(set) + "/one_thread/A_B", *backends.back(), kCases.at("A_B"));
    }
    backends.push_back(make_native_backend(all, usable_instruction_sets().front()));
    for (const auto& [name, what] : kCases)
        add("native/all_threads/" + name, *backends.back(), what);
    std::unique_ptr<OpenClBackend> opencl;
    try {
        opencl = std::make_unique<OpenClBackend>(*backends.front());
        for (const auto& [name, what] : kCases) {
            opencl->build(what);
            add("opencl/" + name, *opencl, what);
        }
    } catch (const Error& error) {
        std::fprintf(stderr, "no OpenCL: %s\n", error.what());
    }
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
