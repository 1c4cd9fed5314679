// SPDX-License-Identifier: Apache-2.0
#include "server/study/studies.h"

#include "server/base/error.h"

namespace kiln {

Studied make_study(Engine& engine, const JobSpec& job, const Control& control) {
    switch (job.kind) {
        case Kind::convergence:
            return study_convergence(engine, job, control);
        case Kind::furnace:
            return study_furnace(engine, job, control);
        default:
            throw Error("internal", "a table is no study");
    }
}

}  // namespace kiln
