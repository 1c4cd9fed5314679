// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "server/compute/backend.h"
#include "server/compute/engine.h"

namespace kiln {

/// Numerics class of every backend whose launches are bit-equal to the native one.
inline constexpr const char* kStrictNumerics = "ieee754-strict";

/// As KernelMaterial::general: the general path, by the one program that reads all other members as
/// arguments. It takes 3 s to compile in place of 1 s a material, and runs up to four times as
/// long: for who wants a few values of many materials. Native code has one function for both.
inline constexpr int kAnyMaterial = 2;

/// The kernels on the first usable OpenCL device, GPUs before CPUs. Programs are built on demand,
/// one a specialisation, and each is tried on a small launch against `oracle` before it counts as
/// built.
class OpenClBackend : public Backend {
  public:
    /// Throws Error("device_unavailable" | "device_failed").
    explicit OpenClBackend(Backend& oracle);
    ~OpenClBackend() override;

    /// Builds what launches of `what` need, if it is not built yet. Safe from any thread, also
    /// beside run().
    void build(const KernelKind& what);
    bool built(const KernelKind& what) const;

    std::size_t block_places() const override;
    void run(const Launch<float>& launch) override;
    void run(const Launch<double>& launch) override;
    void run(const QuadratureLaunch<float>& launch) override;
    void run(const QuadratureLaunch<double>& launch) override;
    void run(const MeasuredLaunch<float>& launch) override;
    void run(const MeasuredLaunch<double>& launch) override;

    std::string name() const;
    /// kStrictNumerics, or a class of the device's own where the trial launch differed in a bit.
    std::string numerics(const KernelKind& what) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

std::vector<DeviceInfo> opencl_devices();

}  // namespace kiln
