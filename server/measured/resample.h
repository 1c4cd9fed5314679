// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "server/compute/backend.h"
#include "server/compute/thread_pool.h"
#include "server/measured/lobe_tables.h"
#include "server/measured/material.h"

namespace kiln::measured {

/// Nodes of the rule for albedos: rings by Gauss and Legendre, spokes evenly. Within 1e-3 of E at
/// grazing light and 1e-4 elsewhere, which is the kinks of the tables.
struct AlbedoRule {
    unsigned rings = 128, spokes = 160;
};

/// A sampled value: Origin's numbers in the fourth.
struct Sampled {
    std::vector<float> r, g, b, origin;
};

/// Evaluates materials in kernels. Equal bits on every backend of one numerics class.
class Resampler {
  public:
    /// `backend` runs the kernels and outlives this; null: all cores, native.
    explicit Resampler(Backend* backend = nullptr);

    /// f_r at views under one theta_in in degrees; views below the horizon get the value at it.
    Sampled values(const LobeTables& tables, double theta_in, std::span<const Vec> out);
    /// Pairs of their own theta_in.
    Sampled values(const LobeTables& tables, std::span<const double> theta_in,
                   std::span<const Vec> out);

    /// Integral of max(0, f) cos(theta_o) over the hemisphere, for each theta_in in degrees.
    std::vector<Material::Albedo> albedos(const LobeTables& tables,
                                          std::span<const double> theta_in, AlbedoRule rule = {});
    /// 2 * integral of E(mu) mu d mu, by Gauss and Legendre between measured incidences.
    Material::Albedo average_albedo(const LobeTables& tables, AlbedoRule rule = {});

  private:
    std::unique_ptr<ThreadPool> pool_;
    std::unique_ptr<Backend> own_;
    Backend* backend_;
};

/// The programs that a resampler needs, for a backend that has to build them first.
std::vector<KernelKind> resampler_kernels();

}  // namespace kiln::measured
