// SPDX-License-Identifier: Apache-2.0
#include "server/measured/lobe_sampler.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/base/error.h"
#include "server/compute/quadrature.h"

namespace kiln::measured {
namespace {

constexpr double kPi = std::numbers::pi;

double fourth(double v) { return v * v * v * v; }

/// Index and share of a place among running sums.
std::pair<std::size_t, double> found(const double* sums, std::size_t count, double place) {
    const double at = place * sums[count];
    const double* above = std::upper_bound(sums, sums + count + 1, at);
    const auto index = static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(above - sums - 1, 0, static_cast<std::ptrdiff_t>(count) - 1));
    const double width = sums[index + 1] - sums[index];
    const double share = width > 0 ? (at - sums[index]) / width : 0.5;
    return {index, std::clamp(share, 0.0, std::nextafter(1.0, 0.0))};
}

double horizon_end(double theta_in, double phi) {
    const double c = std::cos(theta_in * kDegree), s = std::sin(theta_in * kDegree);
    return std::sqrt(std::sin(0.5 * std::atan2(c, s * std::cos(phi * kDegree))));
}

std::vector<double> lobe_masses(const LobeTables& tables, double theta_in, std::size_t rings,
                                std::size_t spokes, Resampler& resampler) {
    // Five places a cell: its middle and towards its corners.
    constexpr std::array<std::array<double, 2>, 5> kPlaces = {
        {{0.5, 0.5}, {0.05, 0.05}, {0.05, 0.95}, {0.95, 0.05}, {0.95, 0.95}}};
    std::vector<Vec> out;
    for (std::size_t n = 0; n < rings * spokes; ++n)
        for (const auto& [a, b] : kPlaces) {
            const double phi =
                360 * (static_cast<double>(n % spokes) + b) / static_cast<double>(spokes);
            const double u = horizon_end(theta_in, phi) * (static_cast<double>(n / spokes) + a) /
                             static_cast<double>(rings);
            out.push_back(from_mirror(theta_in, direction(2 * std::asin(u * u) / kDegree, phi)));
        }
    const Sampled found = resampler.values(tables, theta_in, out);
    std::vector<double> mass(rings * spokes);
    double sum = 0;
    for (std::size_t n = 0; n < mass.size(); ++n) {
        const double low = static_cast<double>(n / spokes) / static_cast<double>(rings);
        const double high = low + 1 / static_cast<double>(rings);
        const double phi =
            360 * (static_cast<double>(n % spokes) + 0.5) / static_cast<double>(spokes);
        const double solid = fourth(horizon_end(theta_in, phi)) * (fourth(high) - fourth(low));
        for (std::size_t k = 0; k < kPlaces.size(); ++k) {
            const std::size_t at = n * kPlaces.size() + k;
            const double f = static_cast<double>(found.r[at]) + found.g[at] + found.b[at];
            mass[n] += solid * std::max(0.0, f) * std::max(0.0, out[at].z) / kPlaces.size();
        }
        sum += mass[n];
    }
    // A hundredth is spread evenly over solid angle, so that every direction can be drawn.
    double all = 0;
    for (std::size_t n = 0; n < mass.size(); ++n) all += mass[n];
    for (std::size_t n = 0; n < mass.size(); ++n) {
        const double low = static_cast<double>(n / spokes) / static_cast<double>(rings);
        const double phi =
            360 * (static_cast<double>(n % spokes) + 0.5) / static_cast<double>(spokes);
        const double solid = 2 * fourth(horizon_end(theta_in, phi)) *
                             (fourth(low + 1 / static_cast<double>(rings)) - fourth(low)) /
                             static_cast<double>(spokes);
        mass[n] = 0.99 * mass[n] / std::max(all, 1e-300) + 0.01 * solid;
    }
    return mass;
}

}  // namespace

CellTable::CellTable(std::size_t rows, std::size_t columns, std::vector<double> mass)
    : columns_(columns), marginal_(rows + 1), conditional_(rows * (columns + 1)) {
    for (std::size_t row = 0; row < rows; ++row) {
        double* sums = conditional_.data() + row * (columns + 1);
        for (std::size_t column = 0; column < columns; ++column)
            sums[column + 1] = sums[column] + mass[row * columns + column];
        marginal_[row + 1] = marginal_[row] + sums[columns];
    }
}

CellTable::Cell CellTable::draw(double a, double b) const {
    Cell cell;
    std::tie(cell.row, cell.row_share) = found(marginal_.data(), marginal_.size() - 1, a);
    std::tie(cell.column, cell.column_share) =
        found(conditional_.data() + cell.row * (columns_ + 1), columns_, b);
    return cell;
}

double CellTable::probability(std::size_t row, std::size_t column) const {
    const double* sums = conditional_.data() + row * (columns_ + 1);
    return (sums[column + 1] - sums[column]) / marginal_.back();
}

double CellTable::cell_sum(std::size_t row, std::size_t column) const {
    const double* sums = conditional_.data() + row * (columns_ + 1);
    return sums[column + 1] / sums[columns_];
}

LobeSampler::LobeSampler(const LobeTables& tables, double theta_in, Resampler& resampler,
                         std::size_t rings, std::size_t spokes)
    : theta_in_(theta_in),
      cells_(rings, spokes, lobe_masses(tables, theta_in, rings, spokes, resampler)) {}

double LobeSampler::end(double phi) const { return horizon_end(theta_in_, phi); }

double LobeSampler::solid_angle(std::size_t ring, double phi) const {
    const auto rings = static_cast<double>(cells_.rows());
    const double low = static_cast<double>(ring) / rings, high = low + 1 / rings;
    return 2 * fourth(end(phi)) * (fourth(high) - fourth(low)) * 2 * kPi /
           static_cast<double>(cells_.columns());
}

Drawn LobeSampler::draw(double a, double b) const {
    const CellTable::Cell cell = cells_.draw(a, b);
    const auto rings = static_cast<double>(cells_.rows());
    const double low = static_cast<double>(cell.row) / rings, high = low + 1 / rings;
    const double phi = 360 * (static_cast<double>(cell.column) + cell.column_share) /
                       static_cast<double>(cells_.columns());
    // Even in solid angle along the spoke: d omega = 8 u^3 du dphi.
    const double v4 = fourth(low) + cell.row_share * (fourth(high) - fourth(low));
    const double rho = std::sqrt(v4) * end(phi) * end(phi);
    const Vec out =
        from_mirror(theta_in_, direction(2 * std::asin(std::min(1.0, rho)) / kDegree, phi));
    return {out, cells_.probability(cell.row, cell.column) / solid_angle(cell.row, phi)};
}

double LobeSampler::pdf(Vec out) const {
    if (out.z <= 0) return 0;
    const Vec d = to_mirror(theta_in_, out);
    double phi = phi_of(d);
    if (phi < 0) phi += 360;
    const double v = std::sqrt(std::sin(theta_of(d) * kDegree / 2)) / end(phi);
    const std::size_t rings = cells_.rows(), spokes = cells_.columns();
    const auto row = std::min(static_cast<std::size_t>(v * static_cast<double>(rings)), rings - 1);
    const auto column =
        std::min(static_cast<std::size_t>(phi / 360 * static_cast<double>(spokes)), spokes - 1);
    return cells_.probability(row, column) / solid_angle(row, phi);
}

double NormalDistribution::at(double theta_h) const {
    const auto above = std::upper_bound(theta.begin(), theta.end(), theta_h);
    if (above == theta.begin()) return value.front();
    if (above == theta.end()) return value.back();
    const auto n = static_cast<std::size_t>(above - theta.begin());
    const double share = (theta_h - theta[n - 1]) / (theta[n] - theta[n - 1]);
    return (1 - share) * value[n - 1] + share * value[n];
}

NormalDistribution power_iteration(const std::function<double(double)>& retro) {
    constexpr unsigned kNodes = 96, kRounds = 200;
    const std::vector<double> rule = gauss_legendre({kNodes});
    NormalDistribution d;
    std::vector<double> weight, reflected;
    for (unsigned n = 0; n < kNodes; ++n) {  // theta = pi / 2 u^2, dense where peaks are
        const double u = rule[2 * n];
        d.theta.push_back(kPi / 2 * u * u);
        weight.push_back(kPi * u * rule[2 * n + 1] * std::sin(d.theta.back()));
        reflected.push_back(std::max(0.0, retro(d.theta.back())) * std::cos(d.theta.back()));
    }
    std::vector<double> kernel(std::size_t{kNodes} * kNodes);
    for (unsigned i = 0; i < kNodes; ++i)
        for (unsigned k = 0; k < kNodes; ++k) {
            const double a = std::cos(d.theta[i]) * std::cos(d.theta[k]);
            const double b = std::sin(d.theta[i]) * std::sin(d.theta[k]);
            const double turn = a >= b ? kPi : std::acos(-a / b);  // where <w, h> ends
            kernel[i * kNodes + k] = reflected[i] * 2 * (a * turn + b * std::sin(turn)) * weight[k];
        }
    d.value.assign(kNodes, 1 / kPi);
    for (unsigned round = 0; round < kRounds; ++round) {
        std::vector<double> next(kNodes);
        double norm = 0, before = 0;
        for (unsigned i = 0; i < kNodes; ++i) {
            for (unsigned k = 0; k < kNodes; ++k) next[i] += kernel[i * kNodes + k] * d.value[k];
            norm += 2 * kPi * weight[i] * std::cos(d.theta[i]) * next[i];
            before += 2 * kPi * weight[i] * std::cos(d.theta[i]) * d.value[i];
        }
        if (!(norm > 0)) throw Error("unfit_measurement", "nothing is reflected back to the light");
        d.eigenvalue = norm / before;
        for (unsigned i = 0; i < kNodes; ++i) d.value[i] = next[i] / norm;
    }
    return d;
}

NormalDistribution normals_of(const LobeTables& tables, Resampler& resampler) {
    constexpr std::size_t kSteps = 901;  // a tenth of a degree
    std::vector<double> theta_in;
    std::vector<Vec> out;
    for (std::size_t n = 0; n < kSteps; ++n) {
        theta_in.push_back(90.0 * static_cast<double>(n) / (kSteps - 1));
        out.push_back(direction(theta_in.back(), 0));
    }
    const std::vector<float> back = resampler.values(tables, theta_in, out).g;
    return power_iteration([&](double theta) {
        const double place = std::min(theta / kDegree * 10, static_cast<double>(kSteps - 1));
        const auto low = std::min(static_cast<std::size_t>(place), kSteps - 2);
        const double share = place - static_cast<double>(low);
        return (1 - share) * static_cast<double>(back[low]) +
               share * static_cast<double>(back[low + 1]);
    });
}

namespace {

/// Edges of rings: theta_h = 90 (n / rings)^2 degrees.
double ring_cosine(std::size_t ring, std::size_t rings) {
    const double root = static_cast<double>(ring) / static_cast<double>(rings);
    return ring == rings ? 0.0 : std::cos(kPi / 2 * root * root);
}

std::vector<double> normal_masses(const NormalDistribution& normals, Vec in, std::size_t rings,
                                  std::size_t spokes) {
    std::vector<double> mass;
    for (std::size_t ring = 0; ring < rings; ++ring)
        for (std::size_t spoke = 0; spoke < spokes; ++spoke) {
            const double high = ring_cosine(ring, rings), low = ring_cosine(ring + 1, rings);
            const double theta = std::acos(0.5 * (low + high));
            const Vec h = direction(theta / kDegree, 360 * (static_cast<double>(spoke) + 0.5) /
                                                         static_cast<double>(spokes));
            mass.push_back(normals.at(theta) * std::max(0.0, dot(in, h)) * (high - low) + 1e-12);
        }
    return mass;
}

}  // namespace

VisibleNormalSampler::VisibleNormalSampler(const NormalDistribution& normals, double theta_in)
    : in_(direction(theta_in, 0)),
      cells_(kRings, kSpokes, normal_masses(normals, in_, kRings, kSpokes)) {}

double VisibleNormalSampler::density(std::size_t ring, std::size_t spoke) const {
    const double solid = (ring_cosine(ring, kRings) - ring_cosine(ring + 1, kRings)) * 2 * kPi /
                         static_cast<double>(kSpokes);
    return cells_.probability(ring, spoke) / solid;
}

Drawn VisibleNormalSampler::draw(double a, double b) const {
    const CellTable::Cell cell = cells_.draw(a, b);
    const double high = ring_cosine(cell.row, kRings), low = ring_cosine(cell.row + 1, kRings);
    const double cosine = high + cell.row_share * (low - high);
    const Vec h = direction(std::acos(cosine) / kDegree,
                            360 * (static_cast<double>(cell.column) + cell.column_share) / kSpokes);
    const double facing = dot(in_, h);
    const Vec out = 2 * facing * h - in_;
    if (facing <= 0 || out.z <= 0) return {out, 0};
    return {out, density(cell.row, cell.column) / (4 * facing)};
}

double VisibleNormalSampler::pdf(Vec out) const {
    Vec h = in_ + out;
    const double length = std::sqrt(dot(h, h));
    if (out.z <= 0 || length < 1e-12) return 0;
    h = (1 / length) * h;
    const double root = std::sqrt(theta_of(h) / 90);
    double phi = phi_of(h);
    if (phi < 0) phi += 360;
    const auto ring = std::min(static_cast<std::size_t>(root * kRings), kRings - 1);
    const auto spoke = std::min(static_cast<std::size_t>(phi / 360 * kSpokes), kSpokes - 1);
    return density(ring, spoke) / (4 * dot(in_, h));
}

}  // namespace kiln::measured
