// SPDX-License-Identifier: Apache-2.0
#include "server/measured/lobe_tables.h"

#include <algorithm>
#include <cmath>

#include "server/compute/thread_pool.h"
#include "server/measured/material.h"

namespace kiln::measured {
namespace {

unsigned held(double wanted, unsigned least, unsigned most) {
    return static_cast<unsigned>(
        std::clamp(std::ceil(wanted), static_cast<double>(least), static_cast<double>(most)));
}

MeasuredShape shape_of(const Material& material) {
    MeasuredShape shape;
    double rings = 0, spokes = 0;
    for (std::size_t n = 0; n < material.lobe_count(); ++n) {
        const Hemisphere::Spacing spacing = material.hemisphere(n).spacing();
        if (spacing.root > 0) rings = std::max(rings, 1 + 2 / spacing.root);
        if (spacing.turn > 0) spokes = std::max(spokes, 1 + 2 / spacing.turn);
    }
    shape.lobes = static_cast<unsigned>(material.lobe_count());
    shape.rings = held(rings, kLobeRingsMin, kLobeRingsMax);
    shape.spokes = held(spokes, kLobeSpokesMin, kLobeSpokesMax);
    const double room = static_cast<double>(kMeasuredNodesMax) / shape.lobes;
    const double excess = static_cast<double>(shape.rings) * shape.spokes / room;
    if (excess > 1) {
        shape.rings = static_cast<unsigned>(shape.rings / std::sqrt(excess));
        shape.spokes = static_cast<unsigned>(shape.spokes / std::sqrt(excess));
    }
    return shape;
}

void fill_ring(const Material& material, std::size_t lobe, unsigned ring, LobeTables& tables) {
    const unsigned spokes = tables.shape.spokes;
    const double root = static_cast<double>(ring) / (tables.shape.rings - 1), rho = root * root;
    const double sine = 2 * rho * std::sqrt(std::max(0.0, 1 - rho * rho));
    float* node =
        tables.nodes.data() + (lobe * tables.shape.rings + ring) * std::size_t{spokes} * 4;
    std::uint32_t hint = Triangulation::kNone;
    for (unsigned spoke = 0; spoke < spokes; ++spoke, node += 4) {
        const double turn = 2 * std::numbers::pi * (spoke % (spokes - 1)) / (spokes - 1);
        const Vec d = {sine * std::cos(turn), sine * std::sin(turn), 1 - 2 * rho * rho};
        Origin origin{};
        const Colour f =
            material.edge_value(lobe, from_mirror(tables.theta_in[lobe], d), hint, origin);
        for (std::size_t k = 0; k < 3; ++k) node[k] = static_cast<float>(f[k]);
        node[3] = origin == Origin::kMeasured ? 0.0f : 1.0f;
    }
}

void fill_curves(const Material& material, LobeTables& tables) {
    std::vector<float>& curves = tables.curves;
    const auto add = [&](double value) { curves.push_back(static_cast<float>(value)); };
    add(material.extrapolation().p);
    add(material.extrapolation().l);
    for (std::size_t n = 0; n < kMeasuredCurve; ++n)
        add(material.level(material.theta_in_max() + static_cast<double>(n)));
    for (std::size_t n = 0; n < kMeasuredCurve; ++n) add(1);
    for (const double theta : tables.theta_in) add(theta * kDegree);
    for (const double theta : tables.theta_in) add(std::cos(theta * kDegree));
    for (const double theta : tables.theta_in) add(std::sin(theta * kDegree));
    for (std::size_t n = 0; n < material.lobe_count(); ++n)
        for (std::size_t azimuth = 0; azimuth < kMeasuredEdges; ++azimuth)
            add(material.edge(n, static_cast<double>(azimuth)) * kDegree);
}

}  // namespace

void LobeTables::make_symmetric(const std::vector<double>& scale) {
    shape.symmetric = 1;
    for (std::size_t n = 0; n < kMeasuredCurve; ++n)
        curves[2 + kMeasuredCurve + n] =
            static_cast<float>(scale.empty() ? 1.0 : scale[std::min(n, scale.size() - 1)]);
}

LobeTables make_lobe_tables(const Material& material) {
    LobeTables tables;
    tables.theta_in = material.theta_in();
    tables.shape = shape_of(material);
    tables.shape.reciprocal_beyond = material.goes_on_by_reciprocity() ? 1 : 0;
    const std::size_t rings = tables.shape.rings;
    tables.nodes.resize(tables.shape.lobes * rings * tables.shape.spokes * 4);
    ThreadPool pool(0);
    pool.parallel_for(tables.shape.lobes * rings, [&](std::size_t n) {
        fill_ring(material, n / rings, static_cast<unsigned>(n % rings), tables);
    });
    fill_curves(material, tables);
    return tables;
}

}  // namespace kiln::measured
