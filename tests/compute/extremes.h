// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/compute/native.h"
#include "server/compute/opencl.h"
#include "server/spec/fresnel_spec.h"
#include "tests/compute/opencl_cache.h"

// Random inputs as extreme as jobs may be, and the devices that they are run on.
namespace kiln::extremes {

/// Inputs of the sampling kernels a run: a million. KILN_EXTREME_INPUTS=100000000 is the long form,
/// and other tests take their part of it.
inline std::size_t input_count() {
    const char* text = std::getenv("KILN_EXTREME_INPUTS");
    return text == nullptr ? 1000000 : std::strtoull(text, nullptr, 10);
}

class Draw {
  public:
    explicit Draw(unsigned seed) : engine_(seed) {}
    std::size_t below(std::size_t count) { return engine_() % count; }
    double unit() { return std::uniform_real_distribution<>(0, 1)(engine_); }
    double log(double lo, double hi) { return lo * std::pow(hi / lo, unit()); }
    /// In [0, 1], with the ends, what is next to them, and denormals of a float.
    double zero_to_one() {
        switch (below(8)) {
            case 0:
                return 0;
            case 1:
                return 1;
            case 2:
                return 1 - log(6e-8, 1e-3);
            case 3:
                return log(1e-45, 1e-38);
            case 4:
                return log(1e-38, 1e-6);
            case 5:
                return 1e-6;
            case 6:
                return log(1e-6, 1);
            default:
                return unit();
        }
    }

  private:
    std::mt19937 engine_;
};

inline std::vector<double> one_or_three(Draw& draw, double (*of)(Draw&)) {
    std::vector<double> values;
    for (std::size_t c = draw.below(2) == 0 ? 1 : 3; c > 0; --c) values.push_back(of(draw));
    return values;
}

inline FresnelModel any_fresnel(Draw& draw) {
    constexpr Fresnel kModels[] = {Fresnel::none,      Fresnel::schlick,   Fresnel::dielectric,
                                   Fresnel::conductor, Fresnel::edge_tint, Fresnel::f82_tint};
    FresnelModel model;
    model.model = kModels[draw.below(std::size(kModels))];
    const auto unit = [](Draw& d) { return d.zero_to_one(); };
    const auto index = [](Draw& d) {
        return d.below(3) == 0 ? 1 + (d.below(2) == 0 ? 1 : -1) * d.log(1e-7, 1e-2)
                               : d.log(1e-4, 1e6);
    };
    model.f0 = one_or_three(draw, unit);
    model.f90 = one_or_three(draw, unit);
    model.exponent = draw.below(2) == 0 ? 5 : draw.log(1e-3, 1e3);
    model.ior = one_or_three(draw, index);
    model.eta = one_or_three(draw, index);
    model.k = one_or_three(draw, [](Draw& d) { return d.below(4) == 0 ? 0 : d.log(1e-6, 1e6); });
    model.reflectivity =
        one_or_three(draw, [](Draw& d) { return std::min(d.zero_to_one(), 0.99999); });
    model.edge_tint = one_or_three(draw, unit);
    model.f82 = one_or_three(draw, unit);
    return model;
}

class OnNative : public testing::Test {
  protected:
    ThreadPool pool_{2};
    std::unique_ptr<Backend> native_ =
        make_native_backend(pool_, usable_instruction_sets().front());
};

/// Skips where there is no device.
class OnBoth : public OnNative {
  protected:
    void SetUp() override {
        test::use_own_opencl_cache();
        try {
            opencl_ = std::make_unique<OpenClBackend>(*native_);
        } catch (const Error& error) {
            if (error.code() != "device_unavailable") throw;
            GTEST_SKIP() << error.what();
        }
    }

    /// Runs a launch whose `found` is written on both, native's last.
    template <typename AnyLaunch, typename Scalar>
    bool have_equal_bits(const AnyLaunch& launch, std::vector<Scalar>& found) {
        opencl_->build(launch.what);
        EXPECT_EQ(opencl_->numerics(launch.what), kStrictNumerics);
        opencl_->run(launch);
        const std::vector<Scalar> on_opencl = found;
        std::fill(found.begin(), found.end(), Scalar(-1));
        native_->run(launch);
        return std::memcmp(on_opencl.data(), found.data(), found.size() * sizeof(Scalar)) == 0;
    }

    std::unique_ptr<OpenClBackend> opencl_;
};

}  // namespace kiln::extremes
