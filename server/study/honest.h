// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

namespace kiln {

/// Largest ratio of a true rms error to the reported one that honest reports leave to chance, in
/// 19 of 20 studies of `points` such ratios; a ratio is of `runs` runs, each of `replicates`
/// randomised sets.
///
/// Texels and channels of a run share their points: taken as one draw, which is the worst, the
/// squared ratio follows F with `runs` and runs (replicates - 1) degrees of freedom. Šidák (1967)
/// for the greatest of many, which is too wide where they go together. What errors are skewed, as
/// those of rare samples are, is beyond it: there a study says that reports were not honest.
double honest_ratio(std::size_t runs, std::size_t replicates, std::size_t points);

/// x that F with these degrees of freedom exceeds with this probability.
double f_quantile(double numerator, double denominator, double probability);

}  // namespace kiln
