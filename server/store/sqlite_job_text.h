// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

/// The text of every statement of the job store, with its parameters. All are constants of the
/// program: values come in as parameters only.
namespace kiln::text {

inline constexpr int kSequenceColumn = 18;  ///< behind the columns of a JobRecord

std::string submit();  ///< id, spec, engine, now, again; the row if it was created or queued afresh
std::string get();     ///< id
std::string claim();   ///< worker, now, lease clock, boot, lease end, attempts_max
std::string list(bool by_state);  ///< created_ms, sequence, limit[, state]

extern const char* const kJoin;       ///< id, engine
extern const char* const kPrune;      ///< finished rows to keep
extern const char* const kRenew;      ///< id, attempt, lease end, boot, progress, error
extern const char* const kFinish;     ///< id, attempt, now, digest, extension, report
extern const char* const kFail;       ///< id, attempt, now, code, detail
extern const char* const kCancelled;  ///< id, attempt, now
extern const char* const kCancel;     ///< id, now; gives 1 for a running job, 0 for a queued one
extern const char* const kRelease;    ///< worker, note, now
extern const char* const kCounts;     ///< now

}  // namespace kiln::text
