// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/compute/engine.h"
#include "server/study/study.h"

namespace kiln {

/// A study, and the report of what was computed for it.
struct Studied {
    Study study;
    Report report;
};

/// Makes the study that job.kind names. Throws what Engine::run throws.
Studied make_study(Engine& engine, const JobSpec& job, const Control& control);

// One a file.
Studied study_convergence(Engine& engine, const JobSpec& job, const Control& control);
Studied study_furnace(Engine& engine, const JobSpec& job, const Control& control);

}  // namespace kiln
