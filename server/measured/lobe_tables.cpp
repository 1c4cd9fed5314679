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
    shape.lobes = static_cast<unsigned>(material.stations().size());
    shape.rings = held(rings, kLobeRingsMin, kLobeRingsMax);
    shape.spokes = held(spokes, kLobeSpokesMin, kLobeSpokesMax);
    const double room = static_cast<double>(kMeasuredNodesMax) / shape.lobes;
    const double excess = static_cast<double>(shape.rings) * shape.spokes / room;
    if (excess > 1) {
        shape.rings = static_cast<unsigned>(shape.rings / std::sqrt(excess));
        shape.spokes = static_cast<unsigned>(shape.spokes / std::sqrt(excess));
    }
    shape.spokes = (shape.spokes - 1) | 1;  // half a turn from each spoke stands another
    return shape;
}

/// What the nodes of measured incidences are, ring by ring, for those made of them.
struct RingSource {
    std::vector<double> squeezed;  ///< [node][R, G, B], asinh(f / floor)
    std::vector<float> origin;     ///< beyond the edge too
};

float* nodes_of(LobeTables& tables, std::size_t lobe, unsigned ring) {
    return tables.nodes.data() +
           (lobe * tables.shape.rings + ring) * std::size_t{tables.shape.spokes} * 4;
}

Vec place_of(const MeasuredShape& shape, unsigned ring, unsigned spoke) {
    const double root = static_cast<double>(ring) / (shape.rings - 1), rho = root * root;
    const double sine = 2 * rho * std::sqrt(std::max(0.0, 1 - rho * rho));
    const double turn = 2 * std::numbers::pi * (spoke % (shape.spokes - 1)) / (shape.spokes - 1);
    return {sine * std::cos(turn), sine * std::sin(turn), 1 - 2 * rho * rho};
}

void fill_ring(const Material& material, std::size_t station, unsigned ring, LobeTables& tables,
               RingSource* source) {
    const std::size_t lobe = material.stations()[station].taps[0].lobe;
    float* node = nodes_of(tables, station, ring);
    std::uint32_t hint = Triangulation::kNone;
    for (unsigned spoke = 0; spoke < tables.shape.spokes; ++spoke, node += 4) {
        const Vec out = from_mirror(tables.theta_in[station], place_of(tables.shape, ring, spoke));
        Origin origin{};
        const Colour f = material.edge_value(lobe, out, hint, origin);
        for (std::size_t k = 0; k < 3; ++k) node[k] = static_cast<float>(f[k]);
        node[3] = origin == Origin::kMeasured ? 0.0f : 1.0f;
        if (!source) continue;
        for (const double v : f) source->squeezed.push_back(std::asinh(v / material.floor()));
        const bool beyond = theta_of(out) > material.edge(lobe, phi_of(out)) + 1e-3;
        source->origin.push_back(beyond ? 2.0f : std::max(node[3], 1.0f));
    }
}

/// The same ring of an incidence between measured ones, as Material::tapped has it.
void mix_ring(const Material& material, std::size_t station, unsigned ring,
              const std::vector<RingSource>& sources, LobeTables& tables) {
    const std::vector<Tap>& taps = material.stations()[station].taps;
    const unsigned spokes = tables.shape.spokes;
    float* node = nodes_of(tables, station, ring);
    for (unsigned spoke = 0; spoke < spokes; ++spoke, node += 4) {
        Colour sum{};
        for (const Tap& tap : taps) {
            const unsigned turned = (spoke + (spokes - 1) / 2) % (spokes - 1);
            const double* from =
                &sources[tap.lobe].squeezed[3 * std::size_t{tap.turned ? turned : spoke}];
            for (std::size_t k = 0; k < 3; ++k) sum[k] += tap.weight * from[k];
        }
        for (std::size_t k = 0; k < 3; ++k)
            node[k] = static_cast<float>(material.floor() * std::sinh(sum[k]));
        node[3] =
            std::max(sources[taps[0].lobe].origin[spoke], sources[taps[1].lobe].origin[spoke]);
    }
}

/// One ring of all incidences.
void fill_rings(const Material& material, unsigned ring, LobeTables& tables) {
    const std::vector<Station>& stations = material.stations();
    const bool more = stations.size() > material.lobe_count();
    std::vector<RingSource> sources(material.lobe_count());
    for (std::size_t n = 0; n < stations.size(); ++n)
        if (stations[n].taps.size() == 1)
            fill_ring(material, n, ring, tables,
                      more ? &sources[stations[n].taps[0].lobe] : nullptr);
    for (std::size_t n = 0; n < stations.size(); ++n)
        if (stations[n].taps.size() > 1) mix_ring(material, n, ring, sources, tables);
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
    for (const Station& station : material.stations())
        for (std::size_t azimuth = 0; azimuth < kMeasuredEdges; ++azimuth)
            add(material.station_edge(station, static_cast<double>(azimuth)) * kDegree);
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
    for (const Station& station : material.stations()) {
        if (station.taps.size() == 1) tables.measured.push_back(tables.theta_in.size());
        tables.theta_in.push_back(station.theta_in);
    }
    tables.shape = shape_of(material);
    tables.shape.reciprocal_beyond = material.goes_on_by_reciprocity() ? 1 : 0;
    const std::size_t rings = tables.shape.rings;
    tables.nodes.resize(tables.shape.lobes * rings * tables.shape.spokes * 4);
    ThreadPool pool(0);
    pool.parallel_for(rings, [&](std::size_t ring) {
        fill_rings(material, static_cast<unsigned>(ring), tables);
    });
    fill_curves(material, tables);
    return tables;
}

}  // namespace kiln::measured
