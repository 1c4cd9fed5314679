// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "server/http/message.h"
#include "server/http/service.h"

namespace kiln {

/// The contract's JobStatus. `with_job` adds the canonical job.
std::string job_document(const JobRecord& job, bool cached, bool with_job);

/// The contract's JobList.
std::string page_document(const JobPage& page);

/// The contract's BatchAnswer from what each job would have been answered alone.
std::string batch_document(const std::vector<HttpResponse>& answers);

/// The contract's Capabilities.
std::string capabilities_document(const Service& service);

/// Unix milliseconds as RFC 3339 UTC.
std::string time_words(std::int64_t unix_ms);

HttpResponse json_response(int status, std::string body);

}  // namespace kiln
