// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "client/bakery.h"
#include "client/cmgen.h"
#include "client/commands.h"
#include "client/files.h"
#include "client/json.h"
#include "server/spec/words.h"
#include "server/study/draw.h"

namespace kiln::client {

namespace {

JobSpec load_study(const StudyOptions& options) {
    return parse_job(as_study(read_job(options.job, options.settings), options.kind));
}

void write_files(const StudyOptions& options, const Study& study, const Baking& result) {
    const std::string start = options.folder + "/" + std::string(to_word(options.kind));
    write_output(start + ".png", draw_png(study));
    write_output(start + ".svg", draw_svg(study));
    write_output(start + ".csv", to_csv(study.table));
    write_output(start + ".json", result.report + "\n");
    if (!options.json) say("wrote " + printable(start) + ".png, .svg, .csv and .json");
}

void print_verdicts(const Study& study) {
    std::string text = study.title + "\n";
    std::size_t longest = 0;
    for (const Verdict& verdict : study.verdicts) longest = std::max(longest, verdict.name.size());
    for (const Verdict& verdict : study.verdicts) {
        const std::string answer = verdict.answer();
        text += "  " + answer + std::string(7 - answer.size(), ' ') + printable(verdict.name) +
                std::string(longest + 2 - verdict.name.size(), ' ') + printable(verdict.words) +
                "\n";
    }
    for (const std::string& note : study.notes) text += "  " + printable(note) + "\n";
    write_output("-", text);
}

}  // namespace

Exit study(const StudyOptions& options) {
    const JobSpec job = load_study(options);
    if (!options.folder.empty()) make_folder(options.folder);
    const Interrupt interrupt(options.timeout_s);
    const Stop stop(interrupt, options.timeout_s);
    Baking result = run_job(options, job, stop);
    auto found = study_of_report(result.report);
    if (!found)
        throw Failure(Exit::failed, "bad_answer",
                      "the answer of " + result.where + " has no study");
    if (options.kind == Kind::convergence && add_cmgen(job, *found))
        result.report = with_study(result.report, *found);
    if (interrupt.requested()) stop.leave();
    if (!options.folder.empty()) write_files(options, *found, result);
    if (options.json)
        write_output("-", result.report + "\n");
    else
        print_verdicts(*found);
    const bool surprise =
        std::any_of(found->verdicts.begin(), found->verdicts.end(),
                    [](const Verdict& verdict) { return !verdict.holds && verdict.expected; });
    return surprise ? Exit::different : Exit::done;
}

}  // namespace kiln::client
