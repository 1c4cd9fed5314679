// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/compare.h"
#include "server/base/error.h"
#include "server/compute/advice.h"
#include "server/compute/engine.h"
#include "server/compute/report.h"
#include "server/image/image.h"
#include "server/spec/spec.h"

/// Every JSON text that the command line reads or writes passes here.
namespace kiln::client {

/// A job as a server tells of it.
struct JobStatus {
    std::string id, state;
    double progress = 0;
    bool cached = false;
    std::optional<double> standard_error_max;
    std::string error_code, error_detail;
    std::string created;                  ///< RFC 3339 in UTC, "" where unknown
    std::string kind;                     ///< "" where the answer does not carry the job
    std::vector<std::string> quantities;  ///< empty there too, and of kinds without them
    std::string document;                 ///< the JSON it was read from
};

struct JobList {
    std::vector<JobStatus> jobs;
    std::string next_cursor;  ///< "" on the last page
};

struct BatchEntry {
    long status = 0;
    std::string document;  ///< of the job, or the problem
};

/// A measurement as a server tells of it.
struct MeasurementAnswer {
    std::string id, format, title;
    std::string unfit;  ///< why no table can be made of it, "" where one can
};

struct ProblemDocument {
    std::string code, detail;
    std::vector<Problem> problems;
};

// Readers of a server's answers; nullopt where the text is not what the contract says.
std::optional<JobStatus> read_job_status(std::string_view text);
std::optional<JobList> read_job_list(std::string_view text);
std::optional<ProblemDocument> read_problem(std::string_view text);
std::optional<Report> read_report(std::string_view text);
std::optional<std::vector<BatchEntry>> read_batch_answer(std::string_view text);
std::optional<MeasurementAnswer> read_measurement_answer(std::string_view text);
/// What results come from, by GET /v1/capabilities; "" where it does not say.
struct Makers {
    std::string tables;    ///< kernel digest "/" encoder revision
    std::string measured;  ///< the same "/" reader revision
};
Makers read_makers(std::string_view text);
/// What bilinear lookup adds to a slice, as a share of the integral of f cos.
struct SliceError {
    double theta_in = 0;  ///< degrees
    double lookup_error = 0;
};
/// Of each slice of a side-car's cell; empty where it does not say.
std::vector<SliceError> read_lookup_errors(std::string_view sidecar, std::size_t cell);

/// True for an answer of GET /v1/capabilities.
bool is_capabilities(std::string_view text);

/// True for a job document that could name /output/format and does not.
bool lacks_output_format(std::string_view job_text);
/// The study of that kind of what a job document is of: fields that such a study does not read are
/// left out. A document that is one already, or is no JSON object, is given back as it is.
std::string as_study(std::string_view job_text, Kind kind);

// Documents for --json, each one line of text or an indented object, without a line break at the
// end.
std::string batch_json(const std::vector<std::string>& jobs);
std::string problem_json(const ProblemDocument& problem);
std::string info_json(const Decoded& file, const std::vector<ChannelStatistics>& statistics,
                      const std::vector<std::string>& convention);
std::string difference_json(const Comparison& comparison, double max_error);
std::string advice_json(const std::vector<Candidate>& candidates, double max_error);
std::string devices_json(const std::vector<DeviceInfo>& devices);
/// Of the servers' own documents.
std::string measurements_json(const std::vector<std::string>& documents);
std::string jobs_json(const std::vector<JobStatus>& jobs);

}  // namespace kiln::client
