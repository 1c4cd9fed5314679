// SPDX-License-Identifier: Apache-2.0
#include "server/compute/facet_albedos.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>

#include "server/compute/facet_space.h"

namespace kiln {

namespace {

/// Directions of the rules that are tried in turn, and their largest error, of albedos and averages
/// (tests/compute/test_facet_space.cpp).
struct Step {
    unsigned directions;
    double error;
};
constexpr Step kSteps[] = {{8, 6e-5},  {12, 1e-5}, {16, 3e-6},  {24, 5e-7},
                           {32, 2e-8}, {48, 1e-9}, {64, 5e-11}, {96, 5e-12}};
/// Where two rules are compared: the error is largest towards grazing.
constexpr std::array kProbes = {1e-4, 1e-2, 0.1, 1.0};

/// A space of one alpha under every albedo.
struct Row {
    FacetSpace space;
    std::vector<FacetSpace::Lit> lights;

    Row(double alpha, unsigned directions, std::span<const double> rhos)
        : space(alpha, directions) {
        for (const double rho : rhos) lights.push_back(space.lit(rho));
    }
    std::vector<double> averages() const {
        std::vector<double> values;
        for (const FacetSpace::Lit& light : lights) values.push_back(space.average(light));
        return values;
    }
    std::vector<double> at(double NoV) const { return space.albedo(NoV, lights); }
};

double difference(const Row& a, const Row& b, bool averaged) {
    double most = 0;
    const auto compare = [&](const std::vector<double>& x, const std::vector<double>& y) {
        for (std::size_t k = 0; k < x.size(); ++k) most = std::max(most, std::abs(x[k] - y[k]));
    };
    if (averaged) compare(a.averages(), b.averages());
    if (!averaged)
        for (const double NoV : kProbes) compare(a.at(NoV), b.at(NoV));
    return most;
}

/// Places of one alpha.
class Task {
  public:
    Task(const FacetPlaces& places, std::span<const std::size_t> mine, double tolerance)
        : places_(places), mine_(mine), tolerance_(tolerance) {}

    void run(FacetAlbedos& out) {
        const bool averaged = places_.NoV.empty();
        const double alpha = places_.alpha[mine_.front()];
        std::size_t step = 0;
        while (step + 2 < std::size(kSteps) && kSteps[step].error > tolerance_) ++step;
        Row row = row_of(alpha, step);
        double error = 0;
        do {
            Row finer = row_of(alpha, ++step);
            error = difference(row, finer, averaged);
            row = std::move(finer);
        } while (error > tolerance_ && step + 1 < std::size(kSteps));
        if (error > tolerance_) unsettled_ = mine_.size();
        for (const std::size_t place : mine_) {
            const std::vector<double> values =
                averaged ? row.averages() : row.at(places_.NoV[place]);
            for (std::size_t k = 0; k < values.size(); ++k) out.of[k][place] = values[k];
            out.error[place] = static_cast<float>(error);
        }
        if (!averaged) evaluations_ += mine_.size() * 2 * kSteps[step].directions;
    }
    std::uint64_t evaluations() const { return evaluations_; }
    std::size_t unsettled() const { return unsettled_; }

  private:
    Row row_of(double alpha, std::size_t step) {
        const std::uint64_t directions = kSteps[step].directions;
        evaluations_ += 4 * directions * directions;
        return {alpha, kSteps[step].directions, places_.rhos};
    }

    const FacetPlaces& places_;
    std::span<const std::size_t> mine_;
    double tolerance_;
    std::uint64_t evaluations_ = 0;
    std::size_t unsettled_ = 0;
};

}  // namespace

FacetAlbedos facet_albedos(const FacetPlaces& places, ThreadPool& pool,
                           const std::function<double(double)>& tolerance) {
    const std::size_t count = places.alpha.size();
    FacetAlbedos out;
    out.of.assign(places.rhos.size(), std::vector<double>(count));
    out.error.resize(count);
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return places.alpha[a] < places.alpha[b];
    });
    std::vector<Task> tasks;
    for (std::size_t first = 0; first < count;) {
        const double asked = tolerance(static_cast<double>(first) / static_cast<double>(count));
        tasks.clear();
        while (tasks.size() < pool.size() && first < count) {
            std::size_t last = first + 1;
            while (last < count && places.alpha[order[last]] == places.alpha[order[first]]) ++last;
            tasks.emplace_back(places, std::span(order).subspan(first, last - first), asked);
            first = last;
        }
        pool.parallel_for(tasks.size(), [&](std::size_t i) { tasks[i].run(out); });
        for (const Task& task : tasks) {
            out.evaluations += task.evaluations();
            out.unsettled += task.unsettled();
        }
    }
    return out;
}

}  // namespace kiln
