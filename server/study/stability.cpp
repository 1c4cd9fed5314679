// SPDX-License-Identifier: Apache-2.0
#include "server/study/stability.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "server/base/error.h"
#include "server/compute/fresnel.h"
#include "server/study/studies.h"

// The stability study: every model on stiff and extreme inputs, its value in float and double
// beside what it should be.
namespace kiln {

namespace {

using namespace stability;

std::string text(const char* format, auto... values) {
    char buffer[320];
    std::snprintf(buffer, sizeof buffer, format, values...);
    return buffer;
}

std::string number(double value) { return std::isnan(value) ? "nan" : text("%.5g", value); }

/// As part of what is right, or of its scale; of 0, itself.
double shown_error(const Finding& f) {
    const double error = (f.error_float() ? f.error_float() : f.error_double()).value_or(0);
    const double size = std::max(std::abs(f.in_double.value), f.scale);
    if (error == 0 || !(size > 0)) return error;
    return std::isinf(size) ? std::numeric_limits<double>::infinity() : error / size;
}

std::string place_of(const Finding& f) {
    std::string words = f.row == f.model ? f.quantity : f.row + ": " + f.quantity;
    if (f.NoV) words += ", NoV " + number(*f.NoV);
    if (f.alpha) words += ", alpha " + number(*f.alpha);
    return f.input.empty() ? words : words + ", " + f.input;
}

struct Group {
    std::size_t count = 0, failed = 0;
    const Finding* worst = nullptr;
    void add(const Finding& finding) {
        ++count;
        if (!finding.passes()) ++failed;
        const auto rank = [](const Finding& f) {
            return std::pair(!f.passes(), std::isnan(f.strain()) ? 1e300 : f.strain());
        };
        if (!worst || rank(finding) > rank(*worst)) worst = &finding;
    }
};

/// The limit that a value was held to: what looks failed may be the rounding of an input that
/// moves the model so far, or what samples leave.
std::string allowed(const Finding& f) {
    std::string words;
    if (f.error_float()) words += " +- " + number(f.in_float.tolerance) + " in float";
    if (f.error_double())
        words += std::string(words.empty() ? "" : ",") + " +- " + number(f.in_double.tolerance) +
                 " in double";
    return words + ": " + f.limit;
}

Verdict verdict_of(const std::string& name, const Group& group) {
    const Finding& worst = *group.worst;
    Verdict v{name, group.failed == 0, true, worst.strain(), 1.0, ""};
    v.words = v.holds
                  ? text("every value within its tolerance, at %zu places; nearest: ", group.count)
                  : text("%zu of %zu places beyond tolerance; worst: ", group.failed, group.count);
    v.words += place_of(worst) + " (";
    constexpr const char* names[] = {"float ", "OpenCL ", "double ", "OpenCL double "};
    for (std::size_t a = 0; a < kArithmetics; ++a) {
        if (!worst.values[a]) continue;
        // What looks the same is said once.
        const std::string found = number(*worst.values[a]);
        double like = worst.in_double.value;
        if (is_opencl(a) && worst.values[a - 1]) like = *worst.values[a - 1];
        if (a == kNativeFloat || found != number(like)) v.words += names[a] + found + ", ";
    }
    v.words += "right " + number(worst.in_double.value) + allowed(worst) + ")";
    return v;
}

std::vector<Verdict> verdicts_of(const std::vector<Finding>& findings) {
    std::vector<std::string> order;
    std::map<std::string, Group> groups;
    for (const Finding& f : findings) {
        const std::string& name = f.model;
        if (!groups.contains(name)) order.push_back(name);
        groups[name].add(f);
    }
    std::vector<Verdict> verdicts;
    for (const std::string& name : order) verdicts.push_back(verdict_of(name, groups[name]));
    return verdicts;
}

/// Why an index of 1e10 is no input: |eps - 1|^2 ~ 4e40 is beyond float.
Verdict refusal() {
    Verdict v{"an index of 1e10 is refused", false, true, {}, {}, ""};
    try {
        FresnelModel model;
        model.model = Fresnel::conductor;
        model.eta = model.k = {1e10};
        fresnel_parameters(model, 0);
        v.words = "it is accepted, and |eps - 1|^2 = 4e40 is no float";
    } catch (const Error& error) {
        v.holds = true;
        v.words = "|eps - 1|^2 = 4e40 is no float, and F is within 4e-10 of 1: " +
                  std::string(error.what());
    }
    return v;
}

/// Claims that some models are known not to keep, with where.
Verdict claim(const char* name, const std::vector<Finding>& findings,
              const std::function<bool(const Finding&)>& breaks, const char* why) {
    std::size_t count = 0;
    const Finding* worst = nullptr;
    for (const Finding& f : findings)
        if (breaks(f)) {
            ++count;
            const double size = std::abs(f.in_double.value);
            if (!worst || size > std::abs(worst->in_double.value)) worst = &f;
        }
    Verdict v{name, count == 0, false, {}, {}, "it is so"};
    if (!worst) return v;
    v.value = worst->in_double.value;
    v.words = text("not at %zu places (%s): %s, ", count, why, worst->model.c_str()) +
              place_of(*worst) + ", " + number(worst->in_double.value);
    return v;
}

std::vector<Verdict> claims(const std::vector<Finding>& findings) {
    return {
        claim(
            "every model is finite", findings,
            [](const Finding& f) {
                return std::any_of(f.values.begin(), f.values.end(), [](const auto& value) {
                    return value && !std::isfinite(*value);
                });
            },
            "a lobe of alpha 0, as 1e-40 counts in float, is no function; charlie has a pole at "
            "NoV 0"),
        claim(
            "F is nowhere negative", findings,
            [](const Finding& f) { return f.quantity == "F" && f.in_double.value < -1e-9; },
            "F82's formula is, for dark tints"),
        claim(
            "no lobe reflects more than it gets", findings,
            [](const Finding& f) {
                const bool albedo = f.quantity == "E" || f.family == "Diffuse albedos";
                return albedo && f.in_double.value > 1 + 1e-6;
            },
            "as published"),
    };
}

StudyTable table_of(const std::vector<Finding>& findings) {
    StudyTable table;
    table.columns = {"family",
                     "model",
                     "case",
                     "quantity",
                     "NoV",
                     "alpha",
                     "input",
                     "right",
                     "source",
                     "native_float",
                     "opencl_float",
                     "native_double",
                     "opencl_double",
                     "error_float",
                     "error_double",
                     "tolerance_float",
                     "tolerance_double",
                     "limit",
                     "passes"};
    const auto cell = [](std::optional<double> value) { return value ? Cell(*value) : Cell(); };
    for (const Finding& f : findings)
        table.rows.push_back(
            {f.family, f.model, f.row, f.quantity, cell(f.NoV), cell(f.alpha), f.input,
             f.in_double.value, f.source, cell(f.values[0]), cell(f.values[1]), cell(f.values[2]),
             cell(f.values[3]), cell(f.error_float()), cell(f.error_double()), f.in_float.tolerance,
             f.in_double.tolerance, f.limit, std::string(f.passes() ? "yes" : "no")});
    return table;
}

template <typename Of>
std::vector<std::string> in_order(const std::vector<const Finding*>& findings, Of of) {
    std::vector<std::string> names;
    for (const Finding* f : findings)
        if (std::find(names.begin(), names.end(), of(*f)) == names.end()) names.push_back(of(*f));
    return names;
}

HeatMap map_of(const std::string& family, const std::vector<const Finding*>& findings) {
    const bool in_float = findings.front()->error_float().has_value();
    const std::string title = family + (in_float ? ": error in float" : ": error in double");
    HeatMap map{title, "", "", "of the value", {}, {}, {}, 1e-9, 1e-2, {}};
    if (findings.front()->column.find(kPlaceJoint) != std::string::npos)
        map.x_label = std::string("alpha") + kPlaceJoint + "NoV";
    if (family == "Fresnel") map.x_label = "VoH; of 1 - F, NoV";
    map.rows = in_order(findings, [](const Finding& f) { return f.row; });
    map.columns = in_order(findings, [](const Finding& f) { return f.column; });
    map.values.assign(map.rows.size() * map.columns.size(),
                      std::numeric_limits<double>::quiet_NaN());
    map.marked.assign(map.values.size(), false);
    for (const Finding* f : findings) {
        const auto at = [](const std::vector<std::string>& names, const std::string& name) {
            return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) -
                                            names.begin());
        };
        const std::size_t i =
            at(map.rows, f->row) * map.columns.size() + at(map.columns, f->column);
        const double shown = shown_error(*f);
        if (!(shown <= map.values[i])) map.values[i] = shown;
        if (!f->passes()) map.marked[i] = true;
    }
    return map;
}

std::vector<Chart> charts_of(const std::vector<Finding>& findings) {
    std::vector<std::string> order;
    std::map<std::string, std::vector<const Finding*>> families;
    for (const Finding& f : findings) {
        if (!families.contains(f.family)) order.push_back(f.family);
        families[f.family].push_back(&f);
    }
    std::vector<Chart> charts;
    for (const std::string& family : order) charts.push_back(map_of(family, families[family]));
    // By the width, then the height: narrow ones stand two a row, beside one of their size.
    std::stable_sort(charts.begin(), charts.end(), [](const Chart& a, const Chart& b) {
        const auto size = [](const Chart& chart) {
            const auto& map = std::get<HeatMap>(chart);
            return std::pair(map.columns.size() > 32, -static_cast<int>(map.rows.size()));
        };
        return size(a) < size(b);
    });
    return charts;
}

}  // namespace

Studied study_stability(Engine& engine, const JobSpec& job, const Control& control) {
    const auto start = std::chrono::steady_clock::now();
    Bench bench(engine, job, control);
    const std::vector<Part> parts = {fresnel_part(),    lobes_part(),     diffuse_part(),
                                     quadrature_part(), rules_part(),     diffuse_rules_part(),
                                     facets_part(),     sampled_part(),   diffuse_albedo_part(),
                                     averages_part(),   couplings_part(), spikes_part()};
    std::vector<KernelKind> kernels{
        QuadratureKind{SmithRule{Masking::smith_correlated, kSchlickWeight}},
        QuadratureKind{SmithRule{Masking::smith_separable, kSchlickWeight}}};
    for (const Part& part : parts)
        for (const KernelKind& what : part.programs)
            if (std::find(kernels.begin(), kernels.end(), what) == kernels.end())
                kernels.push_back(what);
    std::vector<KernelKind> wide = kernels;
    for (KernelKind& kernel : wide)
        std::visit([](auto& kind) { kind.precision = Precision::float64; }, kernel);
    bench.open(kernels, wide);
    const auto opened = std::chrono::steady_clock::now();
    Findings all;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        parts[i].run(bench, all);
        bench.look(static_cast<double>(i + 1) / static_cast<double>(parts.size()));
    }
    const std::vector<Finding>& findings = all.all();
    Studied made;
    made.study.title = "Stability: every model on stiff and extreme inputs";
    made.study.verdicts = verdicts_of(findings);
    made.study.verdicts.push_back(refusal());
    for (Verdict& verdict : refused_spikes()) made.study.verdicts.push_back(std::move(verdict));
    for (Verdict& verdict : claims(findings)) made.study.verdicts.push_back(std::move(verdict));
    made.study.table = table_of(findings);
    made.study.charts = charts_of(findings);
    made.study.notes = {
        text("%zu values in float and double; the worst of each cell is kept, %zu "
             "in all. A red frame: beyond tolerance. Bright without one: the sampling error, or "
             "rounding of the inputs alone, moves the value that far.",
             all.values(), findings.size())};
    const auto seconds = [](auto from, auto to) {
        return std::chrono::duration<double>(to - from).count();
    };
    made.report.device = bench.device();
    made.report.run_time_s.compile = seconds(start, opened);
    made.report.run_time_s.integrate = seconds(opened, std::chrono::steady_clock::now());
    made.report.work.brdf_evaluations = bench.evaluations();
    return made;
}

}  // namespace kiln
