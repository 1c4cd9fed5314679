// SPDX-License-Identifier: Apache-2.0
// Jobs of kind companion, sampling, lobe_view and sphere_view, from the job's text to image and
// side-car, against materials whose integrals are known.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "server/base/sha256.h"
#include "server/image/image.h"
#include "server/measured/angles.h"
#include "server/spec/contract.h"
#include "server/spec/spec.h"
#include "server/worker/bake.h"
#include "tests/measured/synthetic.h"
#include "tests/reference/reference.h"

namespace kiln {
namespace {

using Json = nlohmann::json;
using measured::direction;
using measured::from_mirror;
using measured::kDegree;
using measured::Vec;

constexpr double kAlpha = 0.35;
const std::array<double, 3> kF0 = {0.6, 0.5, 0.4}, kBase = {0.2, 0.15, 0.1};

/// To 85 degrees of both angles: little is extrapolated.
const std::string& satin() {
    static const std::string file = [] {
        synthetic::MiniDiffGrid grid;
        grid.aoi = {0, 15, 30, 45, 60, 70, 80, 85};
        grid.azimuth_step = grid.radial_step = 2.5;
        grid.radial_max = 85;
        return synthetic::minidiff_file(synthetic::ggx(kAlpha, kF0, kBase), grid);
    }();
    return file;
}
const std::string& paint() {
    static const std::string file = [] {
        synthetic::MiniDiffGrid grid;
        grid.azimuth_step = grid.radial_step = 5;
        return synthetic::minidiff_file(synthetic::lambert({0.3, 0.5, 0.7}), grid);
    }();
    return file;
}
std::string id_of(const std::string& bytes) { return "sha256:" + sha256_hex(bytes); }

Baked baked(const std::string& kind, const std::string& fields) {
    EngineOptions native;
    native.device = DeviceChoice::native;
    Engine engine(native);
    const JobSpec job = parse_job(R"({"kind":")" + kind + R"(",)" + fields + "}");
    return bake(engine, job, {}, [](const std::string& digest) {
        return digest == sha256_hex(satin()) ? satin() : paint();
    });
}
std::string both() {
    return R"("measured":{"data":[{"data":")" + id_of(satin()) + R"(","name":"satin"},{"data":")" +
           id_of(paint()) + R"(","name":"paint"}])";
}

/// E of GGX over a Lambertian base by quadrature that knows no table: what split-sum form is of.
double exact(double NoV, std::size_t channel) {
    const auto [scale, bias] = reference::split_sum(NoV, kAlpha, reference::Masking::correlated);
    return kBase[channel] + kF0[channel] * scale + bias;
}

/// Steps of 2.5 degrees and incidences 15 degrees apart leave 0.4 % of the lobe; beyond 80 degrees
/// of the light the extrapolation, which clamps where GGX rises, decides.
TEST(CompanionJob, IsTheSplitSumOfAMaterialThatIsKnown) {
    const Baked made = baked("companion", both() + R"(},"resolution":[8])");
    EXPECT_EQ(made.extension, "exr");
    const Decoded image = decode(made.image);
    ASSERT_EQ(image.table.width, 8u);
    ASSERT_EQ(image.table.height, 2u);
    ASSERT_EQ(image.table.planes.size(), 4u);
    for (std::size_t x = 0; x < 8; ++x) {
        const double NoV = (static_cast<double>(x) + 0.5) / 8;
        for (std::size_t k = 0; k < 3; ++k) {
            const double off =
                std::abs(static_cast<double>(image.table.planes[k][x]) / exact(NoV, k) - 1);
            EXPECT_LT(off, NoV > 0.2 ? 0.01 : 0.1) << NoV << " " << k;
            // The row below is the Lambertian's albedo, in halves.
            EXPECT_NEAR(image.table.planes[k][8 + x], 0.3 + 0.2 * static_cast<double>(k), 1e-3);
        }
        // What is extrapolated is little, and more of it at grazing light.
        EXPECT_LE(image.table.planes[3][x], NoV > 0.2 ? 0.1 : 1.0);
    }
    const Json sidecar = Json::parse(made.sidecar);
    EXPECT_TRUE(contract_problems("SideCar", made.sidecar).empty());
    EXPECT_EQ(sidecar["image"]["height"], 2);
    const Json& split = sidecar["materials"][0]["split_sum"];
    EXPECT_NEAR(split["alpha"], kAlpha, 0.01 * kAlpha);
    EXPECT_NEAR(split["roughness"], std::sqrt(kAlpha), 0.01);
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(split["diffuse"][k], kBase[k], 0.01);
        EXPECT_NEAR(split["f0"][k], kF0[k], 0.01);
    }
    EXPECT_NEAR(sidecar["materials"][1]["split_sum"]["diffuse"][2], 0.7, 0.01);
    EXPECT_NEAR(sidecar["materials"][1]["average_albedo"]["rgb"][1], 0.5, 1e-3);
}

/// A reader of the table by the side-car's words alone.
struct DrawnView {
    Vec out;
    double pdf = 0;
};
DrawnView draw(const Table& table, const Json& slice, std::size_t rings, std::size_t cells,
               double xi_1, double xi_2) {
    const std::size_t x0 = slice["x"], y0 = slice["y"];
    const auto at = [&](std::size_t plane, std::size_t k, std::size_t c) {
        return static_cast<double>(table.planes[plane][(y0 + k) * table.width + x0 + c]);
    };
    std::size_t k = 0, c = 0;
    while (k + 1 < rings && at(0, k, 0) <= xi_1) ++k;
    while (c + 1 < cells && at(1, k, c) <= xi_2) ++c;
    const double below = k > 0 ? at(0, k - 1, 0) : 0, left = c > 0 ? at(1, k, c - 1) : 0;
    const double s = (xi_1 - below) / (at(0, k, 0) - below);
    const double t = (xi_2 - left) / (at(1, k, c) - left);
    const auto m = static_cast<double>(rings), n = static_cast<double>(cells);
    const auto ring = static_cast<double>(k);
    const double wide = std::pow(ring + 1, 4) - std::pow(ring, 4);
    const double v4 = (std::pow(ring, 4) + s * wide) / std::pow(m, 4);
    const double theta_in = slice["theta_in_deg"].get<double>() * kDegree;
    const double phi_d = 2 * std::numbers::pi * (static_cast<double>(c) + t) / n;
    const double h =
        std::sin(std::atan2(std::cos(theta_in), std::sin(theta_in) * std::cos(phi_d)) / 2);
    const double theta_d = 2 * std::asin(h * std::sqrt(v4));
    const double pdf = at(2, k, c) / (4 * std::numbers::pi * h * h * wide / std::pow(m, 4) / n);
    return {from_mirror(theta_in / kDegree, direction(theta_d / kDegree, phi_d / kDegree)), pdf};
}

/// Monte Carlo of E with the truth's own f: no bias, whatever the table, and little noise because
/// the table is in proportion to f cos. A density off by 2 % fails.
TEST(SamplingJob, DrawsViewsOfTheTruthWithLittleNoise) {
    const Baked made = baked("sampling", R"("measured":{"data":")" + id_of(satin()) +
                                             R"(","theta_in":[0,40,70]},"resolution":[72,48])");
    const Json sidecar = Json::parse(made.sidecar);
    EXPECT_TRUE(contract_problems("SideCar", made.sidecar).empty());
    const Decoded image = decode(made.image);
    EXPECT_EQ(image.pixel, "float");
    ASSERT_EQ(image.table.width, 2u * 72);
    ASSERT_EQ(image.table.height, 2u * 48);
    const auto truth = synthetic::ggx(kAlpha, kF0, kBase);
    constexpr int kSamples = 20000;
    for (const Json& slice : sidecar["materials"][0]["slices"]) {
        const double theta_in = slice["theta_in_deg"];
        double sum = 0, square = 0;
        for (int i = 0; i < kSamples; ++i) {
            const double b = i * 0.6180339887498949;
            const DrawnView view =
                draw(image.table, slice, 48, 72, (i + 0.5) / kSamples, b - std::floor(b));
            const double theta = std::acos(std::clamp(view.out.z, 0.0, 1.0)) / kDegree;
            const double phi = std::atan2(view.out.y, view.out.x) / kDegree;
            const double f = truth(synthetic::cosines(theta_in, theta, phi))[1];
            const double weight = f * std::max(0.0, view.out.z) / view.pdf;
            sum += weight / kSamples;
            square += weight * weight / kSamples;
        }
        const double e = exact(std::cos(theta_in * kDegree), 1);
        const double spread = std::sqrt(square - sum * sum) / e;
        // Points of a lattice of rank 1: no worse than random ones.
        EXPECT_NEAR(sum / e, 1, 4 * spread / std::sqrt(kSamples)) << theta_in;
        EXPECT_LT(spread, 0.2) << theta_in;
        EXPECT_NEAR(slice["directional_albedo"]["rgb"][1].get<double>() / e, 1, 0.01);
    }
    const Json& normals = sidecar["materials"][0]["normals"];
    ASSERT_EQ(normals["d"].size(), normals["theta_h_deg"].size());
    // The diffuse base shines back as well, so that f0 lies above the lobe's own.
    EXPECT_GT(normals["f0"].get<double>(), kF0[1]);
}

Json size_of(const Baked& made) { return Json::parse(made.sidecar)["image"]; }

TEST(ViewJobs, AreAGridOfPictures) {
    const Baked lobes = baked("lobe_view", both() + R"(,"theta_in":[40]},"resolution":[200,150])");
    EXPECT_EQ(lobes.extension, "png");
    const Decoded image = decode(lobes.image);
    EXPECT_EQ(image.table.width, 400u);
    EXPECT_EQ(image.table.height, 150u);
    EXPECT_EQ(size_of(lobes), Json({{"width", 400}, {"height", 150}}));
    EXPECT_TRUE(contract_problems("SideCar", lobes.sidecar).empty());
    const Json materials = Json::parse(lobes.sidecar)["materials"];
    EXPECT_EQ(materials[1]["x"], 200);
    EXPECT_EQ(materials[1]["lengths"], "f");
    EXPECT_NEAR(materials[1]["f_max"].get<double>(), 0.5 / std::numbers::pi, 1e-4);
    EXPECT_NEAR(materials[0]["directional_albedo"]["rgb"][0].get<double>(),
                exact(std::cos(40 * kDegree), 0), 0.01);
    EXPECT_TRUE(lobes.report.warnings.empty());
    // The Lambertian's half sphere is blue, in the right cell: 45 degrees up from its origin.
    const double scale = 0.43 * 200;
    const auto x = static_cast<std::size_t>(300 + 0.6 * scale);
    const auto y = static_cast<std::size_t>(75 + 0.1425 * 200 - 0.6 * scale);
    EXPECT_GT(image.table.planes[2][y * 400 + x], 1.2 * image.table.planes[0][y * 400 + x]);

    const Baked spheres = baked("sphere_view", both() + R"(},"resolution":[64,64])");
    EXPECT_EQ(size_of(spheres), Json({{"width", 128}, {"height", 64}}));
    EXPECT_TRUE(contract_problems("SideCar", spheres.sidecar).empty());
    const Decoded pair = decode(spheres.image);
    EXPECT_GT(pair.table.planes[2][40 * 128 + 96], 1.2 * pair.table.planes[0][40 * 128 + 96]);
}

TEST(ViewJobs, SayWhereNothingWasMeasured) {
    const std::string id = R"("measured":{"data":")" + id_of(paint()) + R"(","name":"paint")";
    const Baked beyond = baked("lobe_view", id + R"(,"theta_in":[75]},"resolution":[64,64])");
    ASSERT_EQ(beyond.report.warnings.size(), 1u);
    EXPECT_EQ(beyond.report.warnings[0],
              "paint: theta_in 75 degrees lies outside the measured 0 to 60: the lobe is "
              "extrapolated");
    EXPECT_TRUE(baked("lobe_view", id + R"(,"theta_in":[60]},"resolution":[64,64])")
                    .report.warnings.empty());
}

}  // namespace
}  // namespace kiln
