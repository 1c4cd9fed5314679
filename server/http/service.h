// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/bound.h"
#include "server/http/changes.h"
#include "server/http/message.h"
#include "server/http/metrics.h"
#include "server/http/router.h"
#include "server/settings/settings.h"
#include "server/spec/job_spec.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"
#include "server/store/measurement_store.h"

namespace kiln {

struct WorkerStatus {
    std::string name;
    bool alive = false;
    std::string devices_json;  ///< a JSON array, as the worker last told; "" until then
};

/// What the endpoints work with. Everything outlives the service.
struct ServiceParts {
    JobStore& store;
    BlobStore& blobs;
    MeasurementStore& measurements;
    const Settings& settings;
    Changes& changes;
    Metrics& metrics;
    std::string engine;  ///< names what a result comes from: kernel digest "/" encoder revision
    std::int64_t readers = 0;    ///< revision of what reads measurements
    Bounds bounds;               ///< of every room, beside the contract's and the settings
    std::function<void()> ring;  ///< tells the workers that there is work or a cancel
    std::function<std::vector<WorkerStatus>()> workers;
    std::function<std::size_t()> connections;
};

/// A posted job as it was taken in.
struct Admitted {
    JobRecord job;
    bool cached = false;  ///< its result was at hand
};

/// The part that all endpoints share: admission, waiting, draining.
class Service {
  public:
    explicit Service(ServiceParts parts);

    /// Validates and queues a job, or finds it known. Throws Malformed, InvalidJob,
    /// Error("queue_full" | "draining" | "store_failed").
    Admitted admit(std::string_view job_text);
    /// The job once it has ended, or as it is after `time`, when the client leaves, or at shutdown.
    JobRecord wait_for_end(JobRecord job, std::chrono::milliseconds time,
                           const HttpRequest& request);
    /// Takes one post of a job back. True where no other post stands: then it may be cancelled.
    /// Posts are counted since this process started.
    bool release(const std::string& id);
    /// Keeps a measurement that was read. Throws Error("measurements_full" | "store_failed").
    Measurement keep_measurement(IncomingBlob& blob, const Measurement& what);
    /// Throws Error("unknown_job").
    JobRecord find(const std::string& id);

    void drain() { draining_ = true; }
    bool draining() const { return draining_; }
    const ServiceParts& parts() const { return parts_; }

    /// A place among the requests that may wait; they hold at most half of the connections.
    class WaitingPlace {
      public:
        explicit WaitingPlace(Service& service);
        ~WaitingPlace();
        WaitingPlace(const WaitingPlace&) = delete;
        WaitingPlace& operator=(const WaitingPlace&) = delete;
        bool taken() const { return taken_; }

      private:
        Service& service_;
        bool taken_;
    };
    std::size_t waiting() const { return waiting_; }

  private:
    /// What a result of the job comes from.
    std::string engine_of(const JobSpec& job) const;
    /// Throws InvalidJob naming the measurements that are not here, or of which nothing can be
    /// made.
    void require_measurements(const JobSpec& job, std::string_view job_text);
    /// Of jobs that wait or run.
    std::set<std::string> measurements_in_use();

    ServiceParts parts_;
    void count_post(const std::string& id, bool first);

    /// Between looking (into the queue, for measurements) and adding to the queue; of `posts_` too.
    std::mutex admission_;
    std::map<std::string, std::size_t> posts_;  ///< of jobs that had not ended when last looked at
    std::atomic<bool> draining_{false};
    std::atomic<std::size_t> waiting_{0};
};

bool is_final(JobState state);

// Each adds the endpoints of one file. The service outlives the router.
void add_job_routes(Router& router, Service& service);
void add_batch_routes(Router& router, Service& service);
void add_plan_routes(Router& router, Service& service);
void add_measurement_routes(Router& router, Service& service);
void add_image_routes(Router& router, Service& service);
void add_event_routes(Router& router, Service& service);
void add_operation_routes(Router& router, Service& service);

/// Every endpoint.
Router make_router(Service& service);

/// Largest request body at a path, in bytes; 0 where none is taken.
std::uint64_t body_bytes_max(const Settings& settings, const std::string& path);
/// Whether the body there goes to its handler piece by piece.
bool streams_body(const std::string& path);

}  // namespace kiln
