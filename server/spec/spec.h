// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "server/base/error.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// One thing that is wrong with a document: where (RFC 6901 pointer, "" for the whole) and what is
/// allowed.
struct Problem {
    std::string pointer;
    std::string message;
};

/// The text is not a JSON document that may be looked at (syntax, encoding, size, depth, duplicate
/// keys). HTTP 400.
class Malformed : public Error {
  public:
    Malformed(const std::string& detail, std::vector<Problem> found)
        : Error("malformed", detail), problems(std::move(found)) {}
    std::vector<Problem> problems;
};

/// The document is JSON but no meaningful job; all problems at once. HTTP 422.
class InvalidJob : public Error {
  public:
    explicit InvalidJob(std::vector<Problem> found);
    std::vector<Problem> problems;
};

/// Job document (RFC 8259 text, at most limits().job_bytes_max) to a job that cannot be invalid.
/// Throws Malformed or InvalidJob.
JobSpec parse_job(std::string_view text);

/// The one spelling of a job: sorted keys, every default present, numbers from the typed values, no
/// white space. parse_job(canonical(job)) == job.
std::string canonical(const JobSpec& job);

/// 64 hex digits: SHA-256("kiln/job/1\n" + canonical(job)).
std::string job_id(const JobSpec& job);

/// The contract as served: api/openapi.json, byte for byte.
std::string_view openapi_text();

}  // namespace kiln
