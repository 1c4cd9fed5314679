// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "server/compute/engine.h"
#include "server/study/study.h"

namespace kiln {

/// What one run says of its own errors, held against the truth.
struct JudgedRun {
    Importance importance = Importance::vndf;
    double missed = 0;       ///< share of its values that lie outside their 95 % intervals
    bool suspected = false;  ///< its report says itself that the errors are not to be trusted
};

/// Of a run with planes of standard errors, which are taken `times` as large as they are.
JudgedRun judged_run(const JobSpec& job, const Outcome& outcome, const Table& truth,
                     double times = 1);

/// Largest mean of the shares of `runs` runs that honest reports exceed with a probability below
/// `level`.
///
/// Values of a run share their points: whatever ties them, the share that misses is one number in
/// [0, 1], of a mean of 8 % at most, since intervals hold 92 to 99 % of the truths (N10). For the
/// mean of n independent such numbers Hoeffding (1963), theorem 1, has P(mean >= q) <= exp(-n D),
/// D the relative entropy of q to 8 %.
double most_missed(std::size_t runs, double level);

/// "reported errors are honest": of runs, which have to be independent, that draw the lobe and of
/// those that are blind to it, whose standard errors fail in the same places.
Verdict honest_errors(const std::vector<JudgedRun>& runs);

}  // namespace kiln
