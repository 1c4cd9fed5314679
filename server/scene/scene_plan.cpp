// SPDX-License-Identifier: Apache-2.0
#include "server/scene/scene_plan.h"

#include <algorithm>
#include <charconv>

#include "server/scene/atlas_jobs.h"
#include "server/scene/table_jobs.h"
#include "server/spec/spec.h"
#include "server/spec/words.h"

namespace kiln {

namespace {

using rules::Need;
using enum Multiscatter;

std::string text_of(double value) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string text_of(const Range& range) {
    return range.fixed() ? text_of(range.lo)
                         : "[" + text_of(range.lo) + ", " + text_of(range.hi) + "]";
}

std::string counted(std::size_t count, const std::string& noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

class Planner {
  public:
    Planner(SceneUse scene, const PlanOptions& options)
        : needs_(rules::needs_of(scene)), options_(options) {
        plan_.scene = std::move(scene);
        plan_.options = options;
    }

    ScenePlan make() {
        for (std::size_t i = 0; i < plan_.scene.materials.size(); ++i)
            plan_.materials.push_back({i});
        make_full();
        tell_unlit();
        plan_specular();
        plan_sheen();
        plan_diffuse();
        plan_measured();
        tell_unserved();
        for (PlannedTable& table : plan_.tables) finish(table);
        return std::move(plan_);
    }

  private:
    void leave(const char* rule, std::string what, std::string why) {
        plan_.left_out.push_back({std::move(what), std::move(why), rule});
    }

    static void finish(PlannedTable& table) {
        table.id = job_id(table.job);
        table.estimate = estimate_of(table.job);
    }

    /// What an engine with these options bakes once for all scenes.
    void make_full() {
        const Range all{0, 1};
        const auto take = [&](const char* name, JobSpec job) {
            PlannedTable table{name, std::move(job), "", {}, {}};
            finish(table);
            plan_.full.push_back(std::move(table));
        };
        const auto add = [&](const char* name, TableKind kind, const Range& piece) {
            take(name, table_job(kind, piece, options_, {}));
        };
        add("specular", TableKind::specular, all);
        if (reads_average({})) add("average", TableKind::average, all);
        add("sheen", TableKind::sheen, {kSheenRoughnessLeast, 1});
        if (rules::diffuse_needs_table(options_.diffuse)) add("diffuse", TableKind::diffuse, all);
        const rules::MeasuredUse measured = rules::measured_use(plan_.scene);
        std::vector<std::string> ids = measured.used;
        ids.insert(ids.end(), measured.unused.begin(), measured.unused.end());
        for (JobSpec& job : atlas_jobs(std::move(ids), options_)) take("atlas", std::move(job));
    }

    bool reads_average(const std::optional<rules::Reflectance>& one) const {
        return rules::reads_average(options_.multiscatter, one);
    }

    void tell_unlit() {
        std::size_t count = 0;
        for (const MaterialUse& material : plan_.scene.materials) count += material.unlit ? 1 : 0;
        if (count > 0)
            leave("unlit", "every table of " + counted(count, "unlit material"),
                  "an unlit material is its colour");
    }

    std::vector<Need> needs_within(const std::vector<Need>& needs, const Range& piece) const {
        std::vector<Need> within;
        for (const Need& need : needs)
            if (piece.lo <= need.roughness.lo && need.roughness.hi <= piece.hi)
                within.push_back(need);
        return within;
    }

    std::size_t add_table(const std::string& kind_name, JobSpec job,
                          const std::vector<Need>& needs = {}) {
        std::size_t same_kind = 1;
        for (const PlannedTable& table : plan_.tables)
            same_kind += table.name == kind_name || table.name.starts_with(kind_name + "_");
        PlannedTable table{same_kind == 1 ? kind_name : kind_name + "_" + std::to_string(same_kind),
                           std::move(job),
                           "",
                           {},
                           {}};
        for (const Need& need : needs) table.serves.push_back({need.material, need.lobe});
        plan_.tables.push_back(std::move(table));
        return plan_.tables.size() - 1;
    }

    void give(const std::vector<Need>& needs, Reading reading,
              std::optional<std::size_t> table = {}, std::optional<std::size_t> average = {},
              Multiscatter added = none) {
        for (const Need& need : needs)
            plan_.materials[need.material].lobes.push_back({need, reading, added, table, average});
    }

    void tell_pieces(const std::string& name, const std::vector<Range>& pieces,
                     std::size_t need_count, double full_lo) {
        for (const Range& piece : pieces) {
            if (rules::is_row(piece))
                leave("row", name + ": every roughness but " + text_of(piece.lo),
                      "nothing reads another near it; one row takes the place of a table");
            else if (rules::is_part(piece, full_lo))
                leave("range", name + ": roughness outside " + text_of(piece),
                      "nothing reads it; the axis runs over that range alone");
        }
        const std::size_t equal = rules::equal_tables(need_count, pieces.size());
        if (equal > 0)
            leave("equal", name + ": " + counted(equal, "further table"),
                  std::to_string(need_count) + " lobes of materials read " +
                      (pieces.size() == 1 ? "the same one"
                                          : std::to_string(pieces.size()) + " between them"));
    }

    void plan_specular() {
        std::vector<Need> needs, mirrors;
        for (const Need& need : rules::needs_with(
                 needs_,
                 {Lobe::metal, Lobe::dielectric, Lobe::specular_glossiness, Lobe::clearcoat}))
            (rules::is_mirror(need.roughness) ? mirrors : needs).push_back(need);
        if (needs.empty() && mirrors.empty()) {
            leave("no_specular", "split sum A, B",
                  "no lit surface of the scene has a specular lobe");
            if (reads_average({})) leave("no_specular", "average albedo", "nothing reads it");
            return;
        }
        std::vector<Range> used;
        for (const Need& need : needs) used.push_back(need.roughness);
        const std::vector<Range> pieces = rules::roughness_pieces(used, options_.resolution);
        // A mirror within a range reads its table; alone it needs none.
        const bool zero_there = !pieces.empty() && pieces.front().lo == 0;
        if (zero_there) needs.insert(needs.end(), mirrors.begin(), mirrors.end());
        if (!zero_there && !mirrors.empty()) {
            leave("mirror", "a table for roughness 0",
                  "a mirror's albedo is F(NoV) in closed form (" + counted(mirrors.size(), "lobe") +
                      ")");
            give(mirrors, Reading::closed_form);
        }
        tell_pieces("specular", pieces, needs.size(), 0);
        for (const Range& piece : pieces) add_specular(piece, needs_within(needs, piece));
        if (pieces.empty() && reads_average({}))
            leave("average", "average albedo", "a mirror has nothing to compensate");
    }

    void add_specular(const Range& piece, const std::vector<Need>& needs) {
        const std::string place = "specular, roughness " + text_of(piece);
        PlanOptions options = options_;
        if (options.multiscatter != none &&
            rules::compensation_is_invisible(needs, options.multiscatter, options.pixel)) {
            leave("multiscatter", place + ": compensation of multiple scattering",
                  "it adds at most " +
                      text_of(rules::multiscatter_most(needs, options.multiscatter)) +
                      ", and half a step of " + std::string(to_word(options.pixel)) +
                      " pixels is " + text_of(rules::half_quantum(options.pixel)));
            options.multiscatter = none;
        }
        const bool compensated = options.multiscatter != none;
        const auto one = rules::one_reflectance(needs);
        if (one) {
            const bool white = *one == rules::Reflectance{1, 1};
            leave("one_reflectance", place + ": one of the channels A, B",
                  "every lobe there has F0 = " + text_of(one->f0) + ", F90 = " + text_of(one->f90) +
                      ": one channel holds F0 A + F90 B" +
                      (compensated && !white ? ", compensated" : ""));
            const std::size_t table =
                add_table("specular", table_job(TableKind::specular, piece, options, one), needs);
            give(needs, white && compensated ? Reading::all_reflected : Reading::one_channel,
                 table);
            if (compensated && reads_average({}) && !reads_average(one))
                leave("average", place + ": average albedo",
                      white ? "F = 1 gives back all that is missing"
                            : "the compensation is in the table");
            return;
        }
        const std::size_t table =
            add_table("specular", table_job(TableKind::specular, piece, options, {}), needs);
        std::optional<std::size_t> average;
        if (compensated && reads_average(one))
            average =
                add_table("average", table_job(TableKind::average, piece, options, {}), needs);
        give(needs, Reading::two_channels, table, average, options.multiscatter);
        if (!compensated && reads_average(one))
            leave("average", place + ": average albedo", "compensation alone reads it");
    }

    void plan_sheen() {
        std::vector<Need> needs;
        std::vector<Range> used;
        bool below = false;
        for (Need need : rules::needs_with(needs_, {Lobe::sheen})) {
            below |= need.roughness.lo < kSheenRoughnessLeast;
            for (double* end : {&need.roughness.lo, &need.roughness.hi})
                *end = std::max(*end, kSheenRoughnessLeast);
            used.push_back(need.roughness);
            needs.push_back(need);
        }
        if (needs.empty())
            return leave("no_sheen", "sheen albedo (Charlie)", "nothing in the scene has sheen");
        if (below)
            plan_.scene.warnings.push_back(
                "sheen of a roughness below " + text_of(kSheenRoughnessLeast) +
                " reads the row of " + text_of(kSheenRoughnessLeast) +
                ": below it Charlie's lobe is a spike at the horizon that no table resolves");
        const auto pieces = rules::roughness_pieces(used, options_.resolution);
        tell_pieces("sheen", pieces, needs.size(), kSheenRoughnessLeast);
        for (const Range& piece : pieces) {
            const auto within = needs_within(needs, piece);
            const std::size_t table =
                add_table("sheen", table_job(TableKind::sheen, piece, options_, {}), within);
            give(within, Reading::one_channel, table);
        }
    }

    void plan_diffuse() {
        const std::vector<Need> needs = rules::needs_with(needs_, {Lobe::diffuse});
        std::vector<Range> used;
        bool behind = false;
        for (const MaterialUse& material : plan_.scene.materials)
            behind |= material.lobes.has(Lobe::diffuse_transmission);
        if (behind)
            leave("lambert", "a table of diffuse transmission",
                  "what glTF lets through is Lambert's: its colour at every angle");
        for (const Need& need : needs) used.push_back(need.roughness);
        if (needs.empty())
            return leave("no_diffuse", "diffuse tables",
                         !rules::needs_with(needs_, {Lobe::metal}).empty()
                             ? "every lit surface of the scene is a metal or lets light through"
                             : "nothing in the scene is diffuse");
        if (!rules::diffuse_needs_table(options_.diffuse)) {
            leave("lambert", "diffuse tables",
                  "Lambert's albedo is the base colour at every angle");
            return give(needs, Reading::base_colour);
        }
        const auto pieces = rules::roughness_pieces(used, options_.resolution);
        tell_pieces("diffuse", pieces, needs.size(), 0);
        for (const Range& piece : pieces) {
            const auto within = needs_within(needs, piece);
            const std::size_t table =
                add_table("diffuse", table_job(TableKind::diffuse, piece, options_, {}), within);
            give(within, Reading::times_colour, table);
        }
        if (options_.diffuse != DiffuseModel::burley)
            plan_.scene.warnings.push_back(
                "the diffuse table is that of a white surface; under model " +
                std::string(to_word(options_.diffuse)) +
                " a darker one is not exactly its colour times that");
    }

    void plan_measured() {
        const rules::MeasuredUse use = rules::measured_use(plan_.scene);
        plan_.measured = use.used;
        for (const std::string& id : use.unused)
            leave("measured", "measured material " + called(id), "no object uses it");
        std::size_t readers = 0;
        for (JobSpec& job : atlas_jobs(use.used, options_)) {
            const std::size_t table = add_table("atlas", std::move(job));
            const auto& cells = plan_.tables[table].job.measured.materials;
            for (std::size_t cell = 0; cell < cells.size(); ++cell)
                readers += give_cell(kMeasurementPrefix + cells[cell].data, {table, cell});
        }
        const std::size_t equal = rules::equal_tables(readers, use.used.size());
        if (equal > 0)
            leave("equal", "atlas: " + counted(equal, "further cell"),
                  std::to_string(readers) + " materials are measured, and " +
                      (use.used.size() == 1
                           ? "all by the same data"
                           : "by " + std::to_string(use.used.size()) + " sets of data"));
    }

    /// An unused id with the name of the first material that has it.
    std::string called(const std::string& id) const {
        for (const UnusedMaterial& material : plan_.scene.unused)
            if (material.measured == id && !material.name.empty()) return material.name + ", " + id;
        return id;
    }

    /// Materials that read the cell.
    std::size_t give_cell(const std::string& id, const MeasuredPlace& place) {
        std::size_t readers = 0;
        for (std::size_t i = 0; i < plan_.scene.materials.size(); ++i) {
            if (plan_.scene.materials[i].measured != id) continue;
            plan_.materials[i].measured = place;
            plan_.tables[place.table].serves.push_back({i});
            ++readers;
        }
        return readers;
    }

    void tell_unserved() {
        LobeSet lobes;
        for (const MaterialUse& material : plan_.scene.materials) lobes.add(material.lobes);
        const auto tell = [&](const char* what, const char* why) {
            plan_.unserved.push_back({what, why, "unserved"});
        };
        if (lobes.has(Lobe::transmission))
            tell("transmission",
                 "reflection is served; no table holds what goes through a surface");
        if (lobes.has(Lobe::anisotropy))
            tell("anisotropy", "the tables are of isotropic lobes, which stand in for it");
        if (lobes.has(Lobe::iridescence))
            tell("iridescence", "A and B take the film's reflectance at normal incidence as F0");
    }

    std::vector<Need> needs_;
    PlanOptions options_;
    ScenePlan plan_;
};

}  // namespace

std::string albedo_in_symbols(const LobePlan& lobe) {
    const std::string average = ", F_avg = F0 + (F90 - F0) / 21, E = A + B";
    switch (lobe.reading) {
        case Reading::closed_form:
            return "F0 + (F90 - F0) (1 - NoV)^5";
        case Reading::base_colour:
            return "base colour";
        case Reading::one_channel:
            return "T";
        case Reading::all_reflected:
            return "1 (E = T, and compensation adds 1 - T)";
        case Reading::times_colour:
            return "base colour T";
        case Reading::two_channels:
            break;
    }
    switch (lobe.added) {
        case none:
            return "F0 A + F90 B";
        case kulla_conty:
            return "F0 A + F90 B + F_avg^2 E_avg / (1 - F_avg (1 - E_avg)) (1 - E)" + average;
        case kulla_conty_linear:
            return "F0 A + F90 B + F_avg E_avg / (1 - F_avg (1 - E_avg)) (1 - E)" + average;
        case turquin:
            return "(F0 A + F90 B) (1 + F0 (1 - E) / E), E = A + B";
    }
    __builtin_unreachable();
}

ScenePlan plan_scene(SceneUse scene, const PlanOptions& options) {
    return Planner(std::move(scene), options).make();
}

}  // namespace kiln
