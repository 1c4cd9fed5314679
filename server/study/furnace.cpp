// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>

#include "server/base/error.h"
#include "server/compute/axes.h"
#include "server/spec/channels.h"
#include "server/spec/words.h"
#include "server/study/reflectance.h"
#include "server/study/studies.h"

// The furnace study: what a material returns of a white surroundings at each angle and roughness,
// whether its BRDF is positive, and whether it is the same with V and L exchanged.
namespace kiln {

namespace {

/// Pairs of directions at each roughness; a million and more in all.
constexpr int kPairs = 1 << 17;
/// Between two looks at the clock.
constexpr int kPairsALook = 1 << 14;
/// Relative: the kernels' functions in double differ by some 1e-15 with V and L exchanged.
constexpr double kReciprocal = 1e-5;
/// What float arithmetic may add to a sum, beside five standard errors.
constexpr double kRounding = 2e-6;

std::string text(const char* format, auto... values) {
    char buffer[256];
    std::snprintf(buffer, sizeof buffer, format, values...);
    return buffer;
}

/// The largest of something, and where it was found.
struct Extreme {
    double value;
    double roughness = 0, NoV = 0, NoL = 0;
};

/// The tables that the study is made of, row by row of roughness.
class Tables {
  public:
    Tables(const JobSpec& job, Outcome outcome)
        : channels_(channels_of(job)), axes_(job.axes), outcome_(std::move(outcome)) {}

    std::size_t angles() const { return outcome_.table.width; }
    std::size_t roughnesses() const { return outcome_.table.height; }
    double NoV(std::size_t x) const { return on_axis(0, x, angles()); }
    double roughness(std::size_t y) const { return on_axis(1, y, roughnesses()); }

    /// How many colours a quantity has here: 1 or 3.
    int colours(Quantity quantity) const {
        return static_cast<int>(
            std::count_if(channels_.begin(), channels_.end(),
                          [&](const Channel& channel) { return channel.quantity == quantity; }));
    }
    double value(Quantity quantity, int colour, std::size_t x, std::size_t y) const {
        return outcome_.table.planes[index(quantity, colour)][y * angles() + x];
    }
    double standard_error(Quantity quantity, int colour, std::size_t x, std::size_t y) const {
        return outcome_.standard_errors[index(quantity, colour)][y * angles() + x];
    }
    std::vector<double> row(Quantity quantity, int colour, std::size_t y) const {
        std::vector<double> values;
        if (colours(quantity) == 0) return values;
        for (std::size_t x = 0; x < angles(); ++x) values.push_back(value(quantity, colour, x, y));
        return values;
    }
    const Report& report() const { return outcome_.report; }

  private:
    double on_axis(std::size_t axis, std::size_t i, std::size_t count) const {
        return axis_value(axes_[axis], static_cast<std::int64_t>(i),
                          static_cast<std::int64_t>(count));
    }
    std::size_t index(Quantity quantity, int colour) const {
        for (std::size_t c = 0; c < channels_.size(); ++c)
            if (channels_[c].quantity == quantity &&
                channels_[c].colour == std::min(colour, colours(quantity) - 1))
                return c;
        __builtin_unreachable();
    }
    std::vector<Channel> channels_;
    std::vector<Axis> axes_;
    Outcome outcome_;
};

/// The table job behind the study: the furnace value, and what f(V, L) is made of.
JobSpec table_job(const JobSpec& job) {
    JobSpec table = job;
    table.kind = Kind::lut;
    if (job.multiscatter != Multiscatter::none) {
        table.quantities.push_back(Quantity::multiscatter_albedo);
        table.quantities.push_back(Quantity::average_albedo);
    }
    if (job.coupling == Coupling::kelemen) table.quantities.push_back(Quantity::compensated_albedo);
    return table;
}

Albedos albedos_of(const Tables& tables, int colour, std::size_t y) {
    Albedos albedos;
    albedos.deficit = tables.row(Quantity::multiscatter_albedo, 0, y);
    albedos.compensated = tables.row(Quantity::compensated_albedo, colour, y);
    if (tables.colours(Quantity::average_albedo) != 0)
        albedos.average_deficit = 1 - tables.value(Quantity::average_albedo, 0, 0, y);
    return albedos;
}

/// f(V, L) over random pairs of directions at all roughnesses.
struct Pointwise {
    Extreme least{std::numeric_limits<double>::infinity()};
    Extreme asymmetry{0};  ///< |f(V, L) − f(L, V)| over the greater of the two
};

class PairWalk {
  public:
    PairWalk(const JobSpec& job, const Tables& tables, const Control& control)
        : job_(job), tables_(tables), control_(control), engine_(job.seed) {}

    Pointwise run() {
        const int colours = tables_.colours(Quantity::total_albedo);
        for (std::size_t y = 0; y < tables_.roughnesses(); ++y) {
            for (int colour = 0; colour < colours; ++colour) walk(colour, y, kPairs / colours);
        }
        return found_;
    }

  private:
    void walk(int colour, std::size_t y, int count) {
        const Albedos albedos = albedos_of(tables_, colour, y);
        const double roughness = tables_.roughness(y);
        const Reflectance f(job_, colour, roughness, albedos);
        std::uniform_real_distribution<double> cosine(1e-4, 1), azimuth(0, std::numbers::pi);
        for (int i = 0; i < count; ++i) {
            if (i % kPairsALook == 0) {
                control_.progress({1, {}});
                if (control_.cancelled()) throw Cancelled();
            }
            const Directions d{cosine(engine_), cosine(engine_), std::cos(azimuth(engine_))};
            const double there = f(d), back = f(d.swapped());
            if (std::min(there, back) < found_.least.value)
                found_.least = {std::min(there, back), roughness, d.NoV, d.NoL};
            const double greater = std::max(std::abs(there), std::abs(back));
            // Narrow lobes fall below the least double; 0 beside 0 is the same.
            if (greater < 1e-300) continue;
            const double apart = std::abs(there - back) / greater;
            if (!(apart <= found_.asymmetry.value))
                found_.asymmetry = {apart, roughness, d.NoV, d.NoL};
        }
    }

    const JobSpec& job_;
    const Tables& tables_;
    const Control& control_;
    std::mt19937_64 engine_;
    Pointwise found_;
};

/// Why a material as published exceeds 1, where that is known; "" else.
std::string known_excess(const JobSpec& job) {
    const DiffuseModel model = job.diffuse.model;
    if (job.distribution == Distribution::charlie) return "Charlie's lobe exceeds 1 as published";
    if (model != DiffuseModel::none && job.coupling == Coupling::none)
        return "nothing takes from the diffuse lobe what the specular one reflects";
    if (model != DiffuseModel::none && job.coupling == Coupling::half_vector)
        return "F(VoH) depends on the light, so the two lobes do not share what there is";
    if (model == DiffuseModel::burley || model == DiffuseModel::oren_nayar ||
        model == DiffuseModel::oren_nayar_full || model == DiffuseModel::eon_unreal)
        return std::string(to_word(model)) + " exceeds 1 as published";
    if (job.masking == Masking::karis_ibl || job.masking == Masking::karis_direct ||
        job.masking == Masking::unreal_joint)
        return "the masking is an approximation";
    return "";
}

std::string known_asymmetry(const JobSpec& job) {
    if (job.coupling == Coupling::view) return "F(NoV) stands without its like for L";
    if (job.multiscatter == Multiscatter::turquin) return "Turquin's factor depends on V alone";
    if (job.terminator_softening) return "the softening changes the light's term alone";
    if (job.diffuse.model == DiffuseModel::eon_unreal && job.coupling != Coupling::kelemen)
        return "eon_unreal is not reciprocal as published";
    return "";
}

std::string known_negative(const JobSpec& job) {
    return job.fresnel.model == Fresnel::f82_tint ? "F82's formula is negative there" : "";
}

std::string because(const std::string& why) { return why.empty() ? "" : " (" + why + ")"; }

Verdict positivity(const JobSpec& job, const Pointwise& found) {
    Verdict v{"positivity", found.least.value >= 0, true, found.least.value, 0.0, ""};
    const std::string known = v.holds ? "" : known_negative(job);
    v.expected = known.empty();
    v.words = text("least f(V, L) = %.3g 1/sr at roughness %.3g, NoV %.3g, NoL %.3g",
                   found.least.value, found.least.roughness, found.least.NoV, found.least.NoL) +
              because(known);
    return v;
}

Verdict reciprocity(const JobSpec& job, const Pointwise& found) {
    Verdict v{"reciprocity", found.asymmetry.value <= kReciprocal,
              true,          found.asymmetry.value,
              kReciprocal,   ""};
    const std::string known = v.holds ? "" : known_asymmetry(job);
    v.expected = known.empty();
    v.words = text("|f(V, L) - f(L, V)| is at most %.2g of the greater", found.asymmetry.value) +
              (v.holds ? ""
                       : text(", at roughness %.3g, NoV %.3g, NoL %.3g", found.asymmetry.roughness,
                              found.asymmetry.NoV, found.asymmetry.NoL)) +
              because(known);
    return v;
}

/// The furnace value that lies furthest above 1 or below it, of the texels that are sure.
struct Furnace {
    Extreme most{-std::numeric_limits<double>::infinity()},
        least{std::numeric_limits<double>::infinity()};
    double most_error = 0, least_error = 0;  ///< standard errors there
};

Furnace furnace_of(const Tables& tables) {
    Furnace found;
    for (std::size_t y = 0; y < tables.roughnesses(); ++y)
        for (std::size_t x = 0; x < tables.angles(); ++x)
            for (int c = 0; c < tables.colours(Quantity::total_albedo); ++c) {
                const double value = tables.value(Quantity::total_albedo, c, x, y);
                const double error = tables.standard_error(Quantity::total_albedo, c, x, y);
                if (value - 5 * error > found.most.value - 5 * found.most_error) {
                    found.most = {value, tables.roughness(y), tables.NoV(x), 0};
                    found.most_error = error;
                }
                if (value + 5 * error < found.least.value + 5 * found.least_error) {
                    found.least = {value, tables.roughness(y), tables.NoV(x), 0};
                    found.least_error = error;
                }
            }
    return found;
}

Verdict conservation(const JobSpec& job, const Furnace& found) {
    const double bound = 1 + 5 * found.most_error + kRounding;
    Verdict v{"energy conservation", found.most.value <= bound, true, found.most.value, bound, ""};
    const std::string known = v.holds ? "" : known_excess(job);
    v.expected = known.empty();
    v.words = text("it returns at most %.5f of a white furnace, at roughness %.3g, NoV %.3g",
                   found.most.value, found.most.roughness, found.most.NoV) +
              because(known);
    return v;
}

Verdict preservation(const Furnace& found) {
    const double bound = 1 - 5 * found.least_error - kRounding;
    Verdict v{"nothing is lost", found.least.value >= bound, false, found.least.value, bound, ""};
    v.words = text("it returns at least %.5f of a white furnace, at roughness %.3g, NoV %.3g",
                   found.least.value, found.least.roughness, found.least.NoV);
    return v;
}

StudyTable table_of(const Tables& tables) {
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
std::vector<Chart> charts_of(const Tables& tables) {
    const int colours = tables.colours(Quantity::total_albedo);
    FurnaceBalls balls{"Seen in a white furnace: what is brighter than the surroundings adds light",
                       {}};
    LineChart lines{colours == 1 ? "Furnace value over angle" : "Furnace value over angle, green",
                    "NoV",
                    "total albedo",
                    false,
                    false,
                    {}};
    for (std::size_t y = 0; y < tables.roughnesses(); y += 2) {
        const std::string name = text("roughness %.3g", tables.roughness(y));
        FurnaceBall ball{name, {}};
        Series series{name, {}, {}, {}, {}};
        for (std::size_t x = 0; x < tables.angles(); ++x) {
            std::array<double, 3> value{};
            for (int c = 0; c < 3; ++c)
                value[static_cast<std::size_t>(c)] = tables.value(Quantity::total_albedo, c, x, y);
            ball.by_NoV.push_back(value);
            series.x.push_back(tables.NoV(x));
            series.y.push_back(value[1]);
        }
        balls.balls.push_back(std::move(ball));
        lines.series.push_back(std::move(series));
    }
    return {balls, lines};
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
    Tables tables(table, engine.run(table, control, /*standard_error_planes=*/true));
    const Pointwise pointwise = PairWalk(job, tables, control).run();
    const Furnace furnace = furnace_of(tables);
    Studied made;
    made.study.title = title_of(job);
    made.study.verdicts = {positivity(job, pointwise), conservation(job, furnace),
                           reciprocity(job, pointwise), preservation(furnace)};
    made.study.table = table_of(tables);
    made.study.charts = charts_of(tables);
    made.study.notes = {
        text("f(V, L) over %d random pairs of directions at each roughness; angles and "
             "standard errors from %lld samples each",
             kPairs, static_cast<long long>(job.sample_count))};
    made.report = tables.report();
    return made;
}

}  // namespace kiln
