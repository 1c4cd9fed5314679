// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "server/spec/channels.h"
#include "server/study/reflectance.h"
#include "tests/study/studying.h"

// f(V, L) summed over the hemisphere beside the total albedo that the tables hold: the pointwise
// and the integrated form of a material are one material.
namespace kiln {
namespace {

using namespace studying;

constexpr std::size_t kAngles = 64;

/// ∫ f NoL dω by the midpoint rule, even in NoL² and in azimuth. At roughness 0.5 and above its
/// error is below 1e-4, measured by doubling both counts.
double albedo_of(const Reflectance& f, double NoV) {
    constexpr int kHeights = 256, kTurns = 128;
    double sum = 0;
    for (int i = 0; i < kHeights; ++i)
        for (int j = 0; j < kTurns; ++j) {
            const double NoL = std::sqrt((i + 0.5) / kHeights);
            sum += f({NoV, NoL, std::cos(std::numbers::pi * (j + 0.5) / kTurns)});
        }
    return std::numbers::pi * sum / (kHeights * kTurns);
}

class Rows {
  public:
    Rows(JobSpec job, double roughness) {
        job.kind = Kind::lut;
        job.quantities = {Quantity::total_albedo, Quantity::multiscatter_albedo,
                          Quantity::average_albedo, Quantity::compensated_albedo};
        job.axes[1].lo = 0.1;
        job.axes[1].hi = roughness;
        job.axes[1].grid = Grid::node;
        job.resolution = {kAngles, 2};
        job.sample_count = 16384;
        Engine engine = native_engine();
        table_ = engine.run(job, Control{}).table;
        channels_ = channels_of(job);
        albedos_.deficit = row(Quantity::multiscatter_albedo);
        albedos_.average_deficit = 1 - row(Quantity::average_albedo)[0];
        albedos_.compensated = row(Quantity::compensated_albedo);
    }
    const Albedos& albedos() const { return albedos_; }
    /// Of its first colour.
    std::vector<double> row(Quantity quantity) const {
        std::size_t c = 0;
        while (channels_[c].quantity != quantity) ++c;
        const auto& plane = table_.planes[c];
        return {plane.begin() + kAngles, plane.begin() + 2 * kAngles};
    }

  private:
    std::vector<Channel> channels_;
    Table table_;
    Albedos albedos_;
};

void expect_one_material(const std::string& fields, double roughness) {
    SCOPED_TRACE(fields);
    const JobSpec job = parse_job(R"({"kind":"furnace",)" + fields + "}");
    const Rows rows(job, roughness);
    const Reflectance f(job, 0, roughness, rows.albedos());
    for (std::size_t x = 3; x < kAngles; x += 12) {
        const double NoV = (static_cast<double>(x) + 0.5) / kAngles;
        // 16384 samples: 3e-4; albedos between the angles of a table: a second difference of at
        // most 0.01 over eight; the rule: 1e-4.
        EXPECT_NEAR(albedo_of(f, NoV), rows.row(Quantity::total_albedo)[x], 1.5e-3)
            << "NoV " << NoV;
    }
}

TEST(Reflectance, IsWhatTheTablesIntegrate) {
    expect_one_material(R"("coupling":"none","diffuse":{"model":"burley","albedo":0.8})", 0.6);
    expect_one_material(R"("coupling":"half_vector","diffuse":{"model":"eon","albedo":0.5})", 0.8);
    expect_one_material(R"("coupling":"view")", 0.7);
    expect_one_material(R"("coupling":"kelemen","diffuse":{"albedo":0.7})", 0.6);
    expect_one_material(R"("coupling":"kelemen","multiscatter":"kulla_conty")", 0.9);
    expect_one_material(R"("diffuse":{"model":"none"},"multiscatter":"kulla_conty",)"
                        R"("fresnel":{"model":"conductor","metal":"copper"})",
                        0.9);
    expect_one_material(R"("diffuse":{"model":"none"},"multiscatter":"kulla_conty_linear")", 0.9);
    expect_one_material(R"("diffuse":{"model":"none"},"multiscatter":"turquin")", 0.9);
    expect_one_material(R"("diffuse":{"model":"none"},"microfacet":{"distribution":"beckmann"})",
                        0.8);
    expect_one_material(R"("diffuse":{"model":"none"},"microfacet":{"distribution":"charlie"})",
                        0.9);
}

}  // namespace
}  // namespace kiln
