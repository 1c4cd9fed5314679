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

std::string number(double value) { return text("%.6g", value); }

/// As part of what is right; of 0, itself.
double relative(double error, double right) {
    const double size = std::abs(right);
    if (error == 0) return 0;
    if (std::isinf(right)) return std::numeric_limits<double>::infinity();
    return size > 0 ? std::min(error / size, error / 1e-30) : error;
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

Verdict verdict_of(const std::string& name, const Group& group) {
    const Finding& worst = *group.worst;
    Verdict v{name, group.failed == 0, true, worst.strain(), 1.0, ""};
    if (v.holds) {
        v.words = text("every value within its tolerance; closest to it at ");
    } else {
        v.words = text("%zu of %zu places beyond tolerance; worst at ", group.failed, group.count);
    }
    v.words += place_of(worst);
    std::string found;
    for (std::size_t a = 0; a < kArithmetics; ++a) {
        constexpr const char* names[] = {"native ", "OpenCL ", "double "};
        if (worst.values[a] && (a != kOpenClFloat || worst.values[a] != worst.values[kNativeFloat]))
            found += (found.empty() ? "" : ", ") + (names[a] + number(*worst.values[a]));
    }
    v.words += " (" + found + ", right " + number(worst.in_double.value) + ")";
    return v;
}

std::vector<Verdict> verdicts_of(const std::vector<Finding>& findings) {
    std::vector<std::string> order;
    std::map<std::string, Group> groups;
    for (const Finding& f : findings) {
        const std::string name = f.family + ": " + f.model;
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

Verdict finite(const std::vector<Finding>& findings) {
    std::size_t infinite = 0;
    const Finding* first = nullptr;
    for (const Finding& f : findings)
        if (std::isinf(f.in_float.value)) {
            ++infinite;
            if (!first) first = &f;
        }
    Verdict v{"every model has a finite value everywhere", infinite == 0, false, {}, {}, ""};
    v.words = infinite == 0 ? "it has"
                            : text("%zu places are rightly infinite (alpha = 0 is a mirror's lobe; "
                                   "some visibilities have a pole at NoV = 0): ",
                                   infinite) +
                                  first->model + ", " + place_of(*first);
    return v;
}

StudyTable table_of(const std::vector<Finding>& findings) {
    StudyTable table;
    table.columns = {"family",          "model",        "case",           "quantity",
                     "NoV",             "alpha",        "input",          "right",
                     "source",          "native_float", "opencl_float",   "native_double",
                     "error_float",     "error_double", "tolerance_float", "tolerance_double",
                     "passes"};
    const auto cell = [](std::optional<double> value) { return value ? Cell(*value) : Cell(); };
    for (const Finding& f : findings)
        table.rows.push_back({f.family, f.model, f.row, f.quantity, cell(f.NoV), cell(f.alpha),
                              f.input, f.in_double.value, f.source, cell(f.values[0]),
                              cell(f.values[1]), cell(f.values[2]), cell(f.error_float()),
                              cell(f.error_double()), f.in_float.tolerance, f.in_double.tolerance,
                              std::string(f.passes() ? "yes" : "no")});
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
    HeatMap map{family + ": error in float", "alpha | NoV", "", "of the value", {}, {}, {}, 1e-9,
                1e-2, {}};
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
        const std::size_t i = at(map.rows, f->row) * map.columns.size() + at(map.columns, f->column);
        const auto error = f->error_float() ? f->error_float() : f->error_double();
        const double shown = relative(*error, f->in_double.value);
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
    return charts;
}

}  // namespace

Studied study_stability(Engine& engine, const JobSpec& job, const Control& control) {
    const auto start = std::chrono::steady_clock::now();
    Bench bench(engine, job, control);
    const std::vector<Part> parts = {fresnel_part(), lobes_part(), diffuse_part()};
    std::vector<Specialisation> programs;
    for (const Part& part : parts)
        for (const Specialisation& what : part.programs)
            if (std::find(programs.begin(), programs.end(), what) == programs.end())
                programs.push_back(what);
    const QuadratureKind rules[] = {{Masking::smith_correlated, true, Precision::float32},
                                    {Masking::smith_separable, true, Precision::float32}};
    bench.open(programs, rules);
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
    made.study.verdicts.push_back(finite(findings));
    made.study.table = table_of(findings);
    made.study.charts = charts_of(findings);
    made.study.notes = {text("%zu values in float and double; the worst of each cell is kept, %zu "
                             "in all. Cells with a frame are beyond tolerance.",
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
