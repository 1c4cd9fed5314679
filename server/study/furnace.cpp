// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "server/spec/words.h"
#include "server/study/furnace_pairs.h"
#include "server/study/furnace_reasons.h"
#include "server/study/studies.h"

// The furnace study: what a material returns of a white surroundings at each angle and roughness,
// whether its BRDF is positive, and whether it is the same with V and L exchanged.
namespace kiln {

namespace {

/// What float arithmetic may add to a sum, beside five standard errors.
constexpr double kRounding = 2e-6;

std::string text(const char* format, auto... values) {
    char buffer[256];
    std::snprintf(buffer, sizeof buffer, format, values...);
    return buffer;
}

/// The table job behind the study: the furnace value, and what f(V, L) is made of.
JobSpec table_job(const JobSpec& job) {
    JobSpec table = job;
    table.kind = Kind::lut;
    if (job.multiscatter != Multiscatter::none) {
        table.quantities.push_back(Quantity::multiscatter_albedo);
        table.quantities.push_back(Quantity::average_albedo);
    }
    table.quantities.push_back(specular_quantity(job));
    if (job.diffuse.model != DiffuseModel::none)
        table.quantities.push_back(Quantity::diffuse_albedo);
    return table;
}

Verdict positivity(const JobSpec& job, const Pointwise& found) {
    Verdict v{"positivity", found.least.value >= 0, true, found.least.value, 0.0, ""};
    const Reasons known = v.holds ? Reasons{} : known_negative(job);
    v.expected = known.empty();
    v.words = text("least f(V, L) = %.3g 1/sr at roughness %.3g, NoV %.3g, NoL %.3g",
                   found.least.value, found.least.roughness, found.least.NoV, found.least.NoL) +
              because(known);
    return v;
}

Verdict walked_reciprocity(const JobSpec& job, const Pointwise& found) {
    Verdict v{"reciprocity",  found.asymmetry.value <= kDeviationsMax,
              true,           found.asymmetry.value,
              kDeviationsMax, ""};
    const Reasons known = v.holds ? Reasons{} : known_asymmetry(job);
    v.expected = known.empty();
    v.words = text(
                  "|f(V, L) - f(L, V)| is at most %.2g of its standard errors, which are %.2g %% "
                  "of f on average",
                  found.asymmetry.value, 100 * found.relative_errors / found.walked) +
              because(known);
    return v;
}

Verdict reciprocity(const JobSpec& job, const Pointwise& found) {
    if (walks_over_facets(job)) return walked_reciprocity(job, found);
    Verdict v{"reciprocity", found.asymmetry.value <= kReciprocal,
              true,          found.asymmetry.value,
              kReciprocal,   ""};
    const Reasons known = v.holds ? Reasons{} : known_asymmetry(job);
    v.expected = known.empty();
    v.words = text("|f(V, L) - f(L, V)| is at most %.2g of the greater", found.asymmetry.value) +
              (v.holds ? ""
                       : text(", at roughness %.3g, NoV %.3g, NoL %.3g", found.asymmetry.roughness,
                              found.asymmetry.NoV, found.asymmetry.NoL)) +
              because(known);
    return v;
}

/// ", red" where there are three colours; "" where one value stands for all.
std::string in_colour(const FurnaceTables& tables, int colour) {
    constexpr std::array names{", red", ", green", ", blue"};
    const bool grey = tables.colours(Quantity::total_albedo) == 1;
    return grey ? "" : names[static_cast<std::size_t>(colour)];
}

/// The furnace value that lies furthest above 1 or below it, of the texels that are sure.
struct Furnace {
    Extreme most{-std::numeric_limits<double>::infinity()},
        least{std::numeric_limits<double>::infinity()};
    double most_error = 0, least_error = 0;  ///< standard errors there
    std::string most_colour, least_colour;   ///< as in_colour() has them
};

Furnace furnace_of(const FurnaceTables& tables) {
    Furnace found;
    for (std::size_t y = 0; y < tables.roughnesses(); ++y)
        for (std::size_t x = 0; x < tables.angles(); ++x)
            for (int c = 0; c < tables.colours(Quantity::total_albedo); ++c) {
                const double value = tables.value(Quantity::total_albedo, c, x, y);
                const double error = tables.standard_error(Quantity::total_albedo, c, x, y);
                if (value - 5 * error > found.most.value - 5 * found.most_error) {
                    found.most = {value, tables.roughness(y), tables.NoV(x), 0};
                    found.most_error = error;
                    found.most_colour = in_colour(tables, c);
                }
                if (value + 5 * error < found.least.value + 5 * found.least_error) {
                    found.least = {value, tables.roughness(y), tables.NoV(x), 0};
                    found.least_error = error;
                    found.least_colour = in_colour(tables, c);
                }
            }
    return found;
}

/// What the lobes return, and what there is beside the diffuse one, at most where a texel surely
/// returns more than it receives.
Excess excess_of(const JobSpec& job, const FurnaceTables& tables) {
    const bool lit = job.diffuse.model != DiffuseModel::none;
    Excess most;
    for (std::size_t y = 0; y < tables.roughnesses(); ++y)
        for (std::size_t x = 0; x < tables.angles(); ++x)
            for (int c = 0; c < tables.colours(Quantity::total_albedo); ++c) {
                const auto surely = [&](Quantity quantity) {
                    return tables.value(quantity, c, x, y) -
                           5 * tables.standard_error(quantity, c, x, y) - kRounding;
                };
                const double total = surely(Quantity::total_albedo);
                if (total <= 1) continue;
                most.specular = std::max(most.specular, surely(specular_quantity(job)));
                if (!lit) continue;
                most.diffuse = std::max(most.diffuse, surely(Quantity::diffuse_albedo));
                most.added =
                    std::max(most.added, total - tables.value(Quantity::diffuse_albedo, c, x, y));
            }
    return most;
}

Verdict conservation(const JobSpec& job, const FurnaceTables& tables, const Furnace& found) {
    const double bound = 1 + 5 * found.most_error + kRounding;
    Verdict v{"energy conservation", found.most.value <= bound, true, found.most.value, bound, ""};
    const Reasons known = v.holds ? Reasons{} : known_excess(job, excess_of(job, tables));
    v.expected = known.empty();
    v.words = text("it returns at most %.5f of a white furnace, at roughness %.3g, NoV %.3g",
                   found.most.value, found.most.roughness, found.most.NoV) +
              found.most_colour + because(known);
    return v;
}

Verdict preservation(const Furnace& found) {
    const double bound = 1 - 5 * found.least_error - kRounding;
    Verdict v{"nothing is lost", found.least.value >= bound, false, found.least.value, bound, ""};
    v.words = text("it returns at least %.5f of a white furnace, at roughness %.3g, NoV %.3g",
                   found.least.value, found.least.roughness, found.least.NoV) +
              found.least_colour;
    return v;
}

StudyTable table_of(const FurnaceTables& tables) {
    const int colours = tables.colours(Quantity::total_albedo);
    StudyTable table;
    table.columns = {"roughness", "NoV"};
    const std::array<std::string, 3> names{".R", ".G", ".B"};
    for (const char* figure : {"total_albedo", "standard_error"})
        for (int c = 0; c < colours; ++c)
            table.columns.push_back(figure +
                                    (colours == 1 ? "" : names[static_cast<std::size_t>(c)]));
    for (std::size_t y = 0; y < tables.roughnesses(); ++y)
        for (std::size_t x = 0; x < tables.angles(); ++x) {
            std::vector<Cell> row{tables.roughness(y), tables.NoV(x)};
            for (int c = 0; c < colours; ++c)
                row.push_back(tables.value(Quantity::total_albedo, c, x, y));
            for (int c = 0; c < colours; ++c)
                row.push_back(tables.standard_error(Quantity::total_albedo, c, x, y));
            table.rows.push_back(std::move(row));
        }
    return table;
}

/// Every other roughness.
std::vector<Chart> charts_of(const FurnaceTables& tables) {
    const int colours = tables.colours(Quantity::total_albedo);
    FurnaceBalls balls{
        "Balls in a white furnace: one brighter than it adds light, a darker one loses some, one "
        "that cannot be seen returns all",
        {}};
    std::vector<LineChart> lines;
    for (int c = 0; c < colours; ++c)
        lines.push_back(
            {"What it returns at each angle" + in_colour(tables, c) + "; 1 is all that comes in",
             "NoV",
             "total albedo",
             false,
             false,
             {},
             1.0});
    for (std::size_t y = 0; y < tables.roughnesses(); y += 2) {
        const std::string name = text("roughness %.3g", tables.roughness(y));
        FurnaceBall ball{name, {}};
        for (std::size_t x = 0; x < tables.angles(); ++x) {
            std::array<double, 3> value{};
            for (int c = 0; c < 3; ++c)
                value[static_cast<std::size_t>(c)] = tables.value(Quantity::total_albedo, c, x, y);
            ball.by_NoV.push_back(value);
        }
        balls.balls.push_back(std::move(ball));
        for (int c = 0; c < colours; ++c) {
            Series series{name, {}, {}, {}, {}};
            for (std::size_t x = 0; x < tables.angles(); ++x) {
                series.x.push_back(tables.NoV(x));
                series.y.push_back(tables.value(Quantity::total_albedo, c, x, y));
            }
            lines[static_cast<std::size_t>(c)].series.push_back(std::move(series));
        }
    }
    std::vector<Chart> charts{std::move(balls)};
    for (LineChart& chart : lines) charts.emplace_back(std::move(chart));
    return charts;
}

std::string title_of(const JobSpec& job) {
    std::string title = "Furnace: " + std::string(to_word(job.distribution)) + ", " +
                        std::string(to_word(job.masking)) + ", F " +
                        std::string(to_word(job.fresnel.model));
    if (job.diffuse.model != DiffuseModel::none)
        title += ", " + std::string(to_word(job.diffuse.model)) + ", coupling " +
                 std::string(to_word(job.coupling));
    if (job.multiscatter != Multiscatter::none)
        title += ", " + std::string(to_word(job.multiscatter));
    return title;
}

}  // namespace

Studied study_furnace(Engine& engine, const JobSpec& job, const Control& control) {
    const JobSpec table = table_job(job);
    FurnaceTables tables(table, engine.run(table, control, /*standard_error_planes=*/true));
    const Pointwise pointwise = look_at_pairs(job, tables, control);
    const Furnace furnace = furnace_of(tables);
    Studied made;
    made.study.title = title_of(job);
    made.study.verdicts = {positivity(job, pointwise), conservation(job, tables, furnace),
                           reciprocity(job, pointwise), preservation(furnace)};
    made.study.table = table_of(tables);
    made.study.charts = charts_of(tables);
    if (walks_over_facets(job))
        made.study.notes = {text(
            "f(V, L) of the facets is a mean of %d walks from either side of each of %d random "
            "pairs of directions at each roughness, cosines above %.2g; angles and standard "
            "errors from %lld samples each",
            kWalks, kWalkedPairs, kWalkedCosineMin, static_cast<long long>(job.sample_count))};
    else
        made.study.notes = {
            text("f(V, L) over %d random pairs of directions at each roughness; angles and "
                 "standard errors from %lld samples each",
                 kPairs, static_cast<long long>(job.sample_count))};
    made.report = tables.report();
    return made;
}

}  // namespace kiln
