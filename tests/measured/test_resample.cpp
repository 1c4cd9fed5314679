// SPDX-License-Identifier: Apache-2.0
// The kernels' regular form against the triangulation that it is made of, and the bits of every
// backend.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>

#include "server/base/error.h"
#include "server/compute/native.h"
#include "server/compute/opencl.h"
#include "server/measured/resample.h"
#include "tests/measured/files.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;

Material material_of(const std::string& bytes, Extrapolation how = {}) {
    Reading reading = read_measurement(bytes);
    return Material(reading.components[0], how, reading.understood);
}

const synthetic::Material kSatin = synthetic::ggx(0.35, {0.6, 0.5, 0.4}, {0.2, 0.2, 0.2});
const synthetic::Material kGlossy = synthetic::ggx(0.12, {0.6, 0.5, 0.4}, {0.2, 0.2, 0.2});

/// Views spread evenly by projected solid angle: the golden spiral on the disk.
std::vector<Vec> spiral(std::size_t count) {
    std::vector<Vec> out;
    for (std::size_t n = 0; n < count; ++n) {
        const double r2 = (static_cast<double>(n) + 0.5) / static_cast<double>(count);
        const double turn = static_cast<double>(n) * std::numbers::pi * (3 - std::sqrt(5.0));
        out.push_back({std::sqrt(r2) * std::cos(turn), std::sqrt(r2) * std::sin(turn),
                       std::sqrt(1 - r2)});
    }
    return out;
}

struct Difference {
    double relative = 0;  ///< sum of |kernel - triangulation| cos over the sum of the latter
    double origins = 0;   ///< share of views whose origin differs
};
Difference difference(const Material& material, double theta_in) {
    const LobeTables tables = make_lobe_tables(material);
    Resampler resampler;
    const std::vector<Vec> views = spiral(4000);
    const Sampled found = resampler.values(tables, theta_in, views);
    double off = 0, all = 0, origins = 0;
    for (std::size_t n = 0; n < views.size(); ++n) {
        Origin origin{};
        const Colour f = material.value(theta_in, views[n], origin);
        const float kernel[3] = {found.r[n], found.g[n], found.b[n]};
        for (std::size_t k = 0; k < 3; ++k) {
            off += std::abs(static_cast<double>(kernel[k]) - f[k]);
            all += std::abs(f[k]);
        }
        origins += found.origin[n] != static_cast<float>(origin);
    }
    return {off / all, origins / static_cast<double>(views.size())};
}

TEST(Resample, ProbeKernelAgainstTriangulation) {
    for (const auto* m : {&kSatin, &kGlossy}) {
        const Material material =
            material_of(synthetic::minidiff_file(*m), {0.2, 0.3, ThetaInBeyond::reciprocity});
        const LobeTables t = make_lobe_tables(material);
        std::printf("rings %u spokes %u\n", t.shape.rings, t.shape.spokes);
        for (const double theta_in : {0.0, 20.0, 30.0, 60.0, 70.0, 80.0, 89.0}) {
            const Difference d = difference(material, theta_in);
            std::printf("%g: %g origins %g\n", theta_in, d.relative, d.origins);
        }
        for (const double theta_in : {0.0, 20.0, 30.0, 60.0, 70.0, 80.0, 89.0})
            for (AlbedoRule r : {AlbedoRule{48, 64}, AlbedoRule{}, AlbedoRule{384, 512}})
                std::printf("E %g %u: %.7f\n", theta_in, r.rings,
                            Resampler().albedos(t, std::array{theta_in}, r)[0].value[1]);
    }
}

}  // namespace
}  // namespace kiln
