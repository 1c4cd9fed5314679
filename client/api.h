// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "client/http.h"
#include "client/json.h"

namespace kiln::client {

/// A Kiln server's HTTP API, version 1. Every call throws Failure(unreachable) where no answer
/// comes, Failure(invalid_job) with the server's problems where it refuses a job, Failure(failed)
/// for every other refusal, and Cancelled where `stop` ended it. A server that is full is asked
/// again when it says so, for at most a minute.
class Api {
  public:
    Api(std::string url, std::function<bool()> stop);

    /// True where a Kiln server answers at once; throws nothing but Cancelled.
    bool answers();
    JobStatus submit(const std::string& job, double wait_s);
    /// Many jobs in one request, each as submit() would tell of it.
    std::vector<JobStatus> submit_batch(const std::vector<std::string>& jobs);
    JobStatus status(const std::string& id, double wait_s);
    /// The bytes, which have the SHA-256 that the server's ETag promised.
    std::string image(const std::string& id);
    std::string report(const std::string& id);
    /// JSON, of a job of measured kind.
    std::string sidecar(const std::string& id);
    /// By SHA-256, 64 hex digits.
    bool has_measurement(const std::string& digest);
    /// What the server understood of a measured file, as JSON; the same bytes again are no work.
    std::string upload(std::string bytes);
    /// What the server bakes with.
    Makers makers();
    /// False: it had finished already.
    bool cancel(const std::string& id);
    /// Takes one submit() back: others that submitted the same job keep it.
    void release(const std::string& id);
    /// Newest first; state "" = all; pages are followed until `count_max` are there.
    std::vector<JobStatus> list(const std::string& state, std::size_t count_max);

    const std::string& url() const { return url_; }

  private:
    HttpAnswer send(HttpRequest request);
    HttpAnswer ask(HttpRequest request);
    JobStatus job_in(const HttpAnswer& answer);

    std::string url_;  ///< without a slash at the end
    std::function<bool()> stop_;
    HttpClient http_;
};

}  // namespace kiln::client
