// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite_job_text.h"

namespace kiln::text {

namespace {

const std::string kBeforeReport =
    "id, spec, engine, state, progress, standard_error_max, attempts, note, cancel_requested, "
    "worker, "
    "image_digest, image_extension, ";
const std::string kAfterReport = ", error_code, error_detail, created_ms, started_ms, finished_ms";
const std::string kColumns = kBeforeReport + "report" + kAfterReport;
const std::string kBriefColumns = kBeforeReport + "''" + kAfterReport;

}  // namespace

std::string submit() {
    return R"sql(
INSERT INTO jobs (id, spec, engine, state, created_ms) VALUES (?1, ?2, ?3, 'queued', ?4)
ON CONFLICT (id) DO UPDATE SET
  spec = excluded.spec, engine = excluded.engine, state = 'queued', progress = 0,
  standard_error_max = NULL, attempts_before = attempts, note = '', cancel_requested = 0,
  worker = '', image_digest = '', image_extension = '', report = '', error_code = '',
  error_detail = '', created_ms = excluded.created_ms, started_ms = 0, finished_ms = 0
WHERE state IN ('failed', 'cancelled') OR (state = 'done' AND (engine <> excluded.engine OR ?5))
RETURNING )sql" +
           kColumns;
}

std::string get() { return "SELECT " + kColumns + " FROM jobs WHERE id = ?1"; }

// One statement, hence one short write transaction: pick, decide and write cannot be torn apart.
// The two halves of the pick each walk an index in order.
std::string claim() {
    return R"sql(
UPDATE jobs SET
  state = verdict, note = note_next,
  worker = iif(verdict = 'running', ?1, worker),
  attempts = attempts + (verdict = 'running'),
  lease_until_ms = ?5, lease_boot = ?4, cancel_requested = 0,
  progress = 0, standard_error_max = NULL,
  started_ms = iif(verdict = 'running', ?2, started_ms),
  finished_ms = iif(verdict = 'running', 0, ?2),
  error_code = CASE verdict WHEN 'failed' THEN 'attempts_exhausted'
                            WHEN 'cancelled' THEN 'cancelled' ELSE '' END,
  error_detail = CASE verdict
    WHEN 'failed' THEN iif(note_next <> '', note_next, 'no attempt at this job came to an end')
    WHEN 'cancelled' THEN 'the job was cancelled' ELSE '' END
FROM (
  SELECT sequence AS due,
    CASE WHEN cancel_requested THEN 'cancelled'
         WHEN attempts - attempts_before >= ?6 THEN 'failed' ELSE 'running' END AS verdict,
    iif(state = 'running', 'worker ' || worker || ' let its lease run out', note) AS note_next
  FROM jobs WHERE sequence = (
    SELECT sequence FROM (
      SELECT * FROM (SELECT created_ms, sequence FROM jobs WHERE state = 'queued'
                     ORDER BY created_ms, sequence LIMIT 1)
      UNION ALL
      SELECT * FROM (SELECT created_ms, sequence FROM jobs
                     WHERE state = 'running' AND (lease_until_ms <= ?3 OR lease_boot <> ?4)
                     ORDER BY created_ms, sequence LIMIT 1)
    ) ORDER BY created_ms, sequence LIMIT 1)
) WHERE sequence = due
RETURNING )sql" +
           kColumns;
}

std::string list(bool by_state) {
    return "SELECT " + kBriefColumns +
           ", sequence FROM jobs WHERE (created_ms, sequence) < (?1, ?2)" +
           (by_state ? " AND state = ?4" : "") +
           " ORDER BY created_ms DESC, sequence DESC LIMIT ?3";
}

// A queued job will be computed by whatever engine claims it: the newest wish stands.
const char* const kJoin = R"sql(
UPDATE jobs SET cancel_requested = 0, engine = iif(state = 'queued', ?2, engine)
WHERE id = ?1 AND state IN ('queued', 'running'))sql";

const char* const kPrune = R"sql(
DELETE FROM jobs WHERE sequence IN (
  SELECT sequence FROM jobs WHERE finished_ms > 0 ORDER BY finished_ms, sequence
  LIMIT max(0, (SELECT sum(jobs) FROM tally WHERE state IN ('done', 'failed', 'cancelled')) - ?1)
))sql";

const char* const kRenew = R"sql(
UPDATE jobs SET lease_until_ms = ?3, lease_boot = ?4, progress = ?5, standard_error_max = ?6
WHERE id = ?1 AND attempts = ?2 AND state = 'running' RETURNING cancel_requested)sql";

const char* const kFinish = R"sql(
UPDATE jobs SET state = 'done', progress = 1, cancel_requested = 0, finished_ms = ?3,
  image_digest = ?4, image_extension = ?5, report = ?6
WHERE id = ?1 AND attempts = ?2 AND state = 'running')sql";

const char* const kFail = R"sql(
UPDATE jobs SET state = 'failed', cancel_requested = 0, finished_ms = ?3,
  error_code = ?4, error_detail = ?5
WHERE id = ?1 AND attempts = ?2 AND state = 'running')sql";

const char* const kCancelled = R"sql(
UPDATE jobs SET
  state = iif(cancel_requested, 'cancelled', 'queued'),
  progress = iif(cancel_requested, progress, 0),
  finished_ms = iif(cancel_requested, ?3, 0),
  error_code = iif(cancel_requested, 'cancelled', ''),
  error_detail = iif(cancel_requested, 'the job was cancelled', ''),
  note = iif(cancel_requested, note, 'cancelled, then asked for again'),
  cancel_requested = 0
WHERE id = ?1 AND attempts = ?2 AND state = 'running')sql";

const char* const kCancel = R"sql(
UPDATE jobs SET
  state = iif(state = 'queued', 'cancelled', state),
  finished_ms = iif(state = 'queued', ?2, 0),
  error_code = iif(state = 'queued', 'cancelled', ''),
  error_detail = iif(state = 'queued', 'the job was cancelled', ''),
  cancel_requested = (state = 'running')
WHERE id = ?1 AND state IN ('queued', 'running') RETURNING cancel_requested)sql";

const char* const kRelease = R"sql(
UPDATE jobs SET
  state = iif(cancel_requested, 'cancelled', 'queued'),
  progress = 0, standard_error_max = NULL, note = ?2, started_ms = 0,
  finished_ms = iif(cancel_requested, ?3, 0),
  error_code = iif(cancel_requested, 'cancelled', ''),
  error_detail = iif(cancel_requested, 'the job was cancelled', ''),
  cancel_requested = 0
WHERE worker = ?1 AND state = 'running')sql";

// An age below 0 would only say that the wall clock was set back.
const char* const kCounts = R"sql(
SELECT (SELECT jobs FROM tally WHERE state = 'queued'),
  (SELECT jobs FROM tally WHERE state = 'running'),
  (SELECT jobs FROM tally WHERE state = 'done'),
  (SELECT jobs FROM tally WHERE state = 'failed'),
  (SELECT jobs FROM tally WHERE state = 'cancelled'),
  max(0, ?1 - coalesce((SELECT min(created_ms) FROM jobs WHERE state = 'queued'), ?1)))sql";

}  // namespace kiln::text
