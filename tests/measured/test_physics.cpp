// SPDX-License-Identifier: Apache-2.0
// Energy, reciprocity, companions and predicted errors, against materials that are known and files
// that are not.
#include <gtest/gtest.h>

#include <cmath>

#include "server/measured/slices.h"
#include "tests/measured/files.h"
#include "tests/measured/synthetic.h"

namespace kiln {
namespace {

using namespace measured;

Material material_of(const std::string& bytes, Extrapolation how = {}) {
    Reading reading = read_measurement(bytes);
    return Material(reading.components[0], how, reading.understood);
}

/// Mean |f - truth| cos over mean truth cos within theta_o <= 73, inside the measured part.
double actual_error(const SliceLayout& layout, const SliceTable& made,
                    const synthetic::Material& truth, double theta_in) {
    double off = 0, all = 0;
    for (double theta = 1.3; theta < 73; theta += 2.1)
        for (double phi = 0.7; phi < 360; phi += 5.3) {
            const double weight = std::sin(theta * kDegree) * std::cos(theta * kDegree);
            const auto t = truth(synthetic::cosines(theta_in, theta, phi));
            const Colour f = look_up(layout, made, 0, theta_in, direction(theta, phi));
            for (std::size_t k = 0; k < 3; ++k) {
                off += weight * std::abs(f[k] - t[k]);
                all += weight * t[k];
            }
        }
    return off / all;
}

TEST(PredictedErrorProbe, Prints) {
    for (const double alpha : {0.6, 0.35, 0.2, 0.12})
        for (const double step : {1.0, 3.0}) {
            const auto truth = synthetic::ggx(alpha, {0.6, 0.5, 0.4}, {0.2, 0.2, 0.2});
            synthetic::MiniDiffGrid grid;
            grid.azimuth_step = grid.radial_step = step;
            const Material material = material_of(synthetic::minidiff_file(truth, grid));
            const SliceLayout layout;
            const SliceTable made = make_slices(layout, {&material});
            const PredictedError p = made.accounts[0].predicted;
            std::printf("alpha %g step %g: points %.5f table %.5f theta %.5f\n", alpha, step, p.points,
                        p.table, p.theta_in);
            double at = 0, between = 0;
            for (double t : {0., 20., 40., 60.}) at += actual_error(layout, made, truth, t) / 4;
            for (double t : {5., 10., 15., 25., 30., 35., 45., 50., 55.}) between += actual_error(layout, made, truth, t) / 9;
            std::printf("   actual at %.5f (predicted %.5f) between %.5f (predicted %.5f)\n", at,
                        p.at_incidences(), between, p.between_incidences());
            const Physics& ph = made.accounts[0].physics;
            std::printf("   E max %.4f at %g, ext %.3f recip all %.4f/%.4f measured %.4f/%.4f share %.2f\n", ph.albedo_max, ph.albedo_max_theta_in, ph.extrapolated, ph.all.l1, ph.all.median, ph.measured.l1, ph.measured.median, ph.measured_pairs);
        }
}

TEST(ConserveProbe, Prints) {
    if (measured_files::folder().empty()) GTEST_SKIP() << measured_files::kNoFolder;
    for (const char* name : {"rgl/paper_white_rgb.bsdf", "rgl/satin_rosaline_rgb.bsdf", "rgl/cg_sunflower_rgb.bsdf", "rgl/cc_iris_purple_gem_rgb.bsdf"}) {
        const Material material = material_of(measured_files::bytes_of(name));
        SliceLayout layout;
        layout.theta_in = {0, 15, 30, 45, 60, 75};
        layout.conserve = true;
        const SliceTable made = make_slices(layout, {&material});
        const SliceAccount& a = made.accounts[0];
        std::printf("%s predicted points %.4f table %.4f theta %.4f\n", name, a.predicted.points, a.predicted.table, a.predicted.theta_in);
        for (const Physics* ph : {&a.measured_physics, &a.physics})
            std::printf("   E max %.4f at %g, ext %.3f recip all %.6f/%.6f/%.6f measured %.6f/%.6f share %.2f\n", ph->albedo_max, ph->albedo_max_theta_in, ph->extrapolated, ph->all.l1, ph->all.median, ph->all.p95, ph->measured.l1, ph->measured.median, ph->measured_pairs);
    }
}

}  // namespace
}  // namespace kiln
