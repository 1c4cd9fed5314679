// SPDX-License-Identifier: Apache-2.0
#include "server/http/service.h"

#include "server/base/error.h"
#include "server/spec/kinds.h"
#include "server/spec/limits.h"
#include "server/spec/measurement_names.h"
#include "server/spec/spec.h"

namespace kiln {

namespace {
/// A client that went away is noticed within this time.
constexpr std::chrono::milliseconds kGoneStep{1000};
const std::string kMeasurements = "/v1/measurements";
}  // namespace

bool is_final(JobState state) { return state != JobState::queued && state != JobState::running; }

Service::Service(ServiceParts parts) : parts_(std::move(parts)) {}

Admitted Service::admit(std::string_view job_text) {
    if (draining_) throw Error("draining", "the server is stopping; try again soon");
    const JobSpec spec = parse_job(job_text);
    const std::string id = job_id(spec), engine = engine_of(spec);
    const std::lock_guard lock(admission_);
    const std::optional<JobRecord> known = parts_.store.get(id);
    bool evicted = false;
    if (known && known->state == JobState::done && known->engine == engine) {
        if (parts_.blobs.contains(known->image_digest)) {
            ++parts_.metrics.cache_hits;
            return {*known, true};
        }
        evicted = true;
    }
    const bool live = known && !is_final(known->state);
    if (!live && is_measured(spec.kind)) require_measurements(spec, job_text);
    if (!live && parts_.store.counts().queued >= parts_.settings.queue_max) {
        ++parts_.metrics.refused;
        throw Error("queue_full", "the queue holds " + std::to_string(parts_.settings.queue_max) +
                                      " jobs, which is its limit; try again soon");
    }
    Submitted submitted = parts_.store.submit(id, canonical(spec), engine, evicted);
    count_post(id, submitted.created);
    if (submitted.created) {
        ++parts_.metrics.cache_misses;
        parts_.changes.notify(id, Changes::Interest::state);
        parts_.ring();
    } else {
        ++parts_.metrics.joined;
    }
    return {std::move(submitted.job), false};
}

void Service::count_post(const std::string& id, bool first) {
    // What has ended is forgotten before the list outgrows the jobs that can be live by far.
    if (posts_.size() > 2 * static_cast<std::size_t>(parts_.settings.queue_max) + 64)
        std::erase_if(posts_, [this](const auto& entry) {
            const std::optional<JobRecord> job = parts_.store.get(entry.first);
            return !job || is_final(job->state);
        });
    // A job from before this process started has had a post at least.
    std::size_t& posts = posts_.try_emplace(id, 1).first->second;
    posts = first ? 1 : posts + 1;
}

bool Service::release(const std::string& id) {
    const std::lock_guard lock(admission_);
    const auto at = posts_.find(id);
    if (at != posts_.end() && --at->second > 0) return false;
    if (at != posts_.end()) posts_.erase(at);
    return true;
}

std::string Service::engine_of(const JobSpec& job) const {
    return is_measured(job.kind) ? parts_.engine + "/" + std::to_string(parts_.readers)
                                 : parts_.engine;
}

void Service::require_measurements(const JobSpec& job, std::string_view job_text) {
    std::vector<Problem> problems;
    const auto most = static_cast<std::size_t>(limits().problems_max);
    const std::vector<MeasuredMaterial>& materials = job.measured.materials;
    for (std::size_t i = 0; i < materials.size() && problems.size() < most; ++i) {
        const auto found = parts_.measurements.find(materials[i].data);
        const std::string name = kMeasurementPrefix + materials[i].data;
        if (!found)
            problems.push_back({measurement_pointers(job_text).at(i),
                                "there is no measurement " + name + " here; upload it with POST " +
                                    kMeasurements});
        else if (!found->unfit.empty())
            problems.push_back({measurement_pointers(job_text).at(i),
                                "no table can be made of " + name + ": " + found->unfit});
    }
    if (!problems.empty()) throw InvalidJob(std::move(problems));
}

std::set<std::string> Service::measurements_in_use() {
    std::set<std::string> digests;
    for (const JobState state : {JobState::queued, JobState::running})
        for (std::string cursor;;) {
            const JobPage page =
                parts_.store.list(state, static_cast<int>(limits().list_limit_max), cursor);
            for (const JobRecord& job : page.jobs) named_measurements(job.spec, digests);
            cursor = page.next_cursor;
            if (cursor.empty()) break;
        }
    return digests;
}

Measurement Service::keep_measurement(IncomingBlob& blob, const Measurement& what) {
    blob.seal();
    const std::lock_guard lock(admission_);
    return parts_.measurements.keep(blob, what, [this] { return measurements_in_use(); });
}

JobRecord Service::wait_for_end(JobRecord job, std::chrono::milliseconds time,
                                const HttpRequest& request) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point deadline = Clock::now() + time;
    Watch watch(parts_.changes, job.id, Changes::Interest::state);
    for (;;) {
        job = find(job.id);
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
        if (is_final(job.state) || left.count() <= 0 || parts_.changes.closed() ||
            request.client_gone())
            return job;
        watch.wait(std::min({left, kGoneStep, Changes::kLookInterval}));
    }
}

JobRecord Service::find(const std::string& id) {
    if (auto job = parts_.store.get(id)) return std::move(*job);
    throw Error("unknown_job", "there is no job with this id");
}

Service::WaitingPlace::WaitingPlace(Service& service)
    : service_(service),
      taken_(++service.waiting_ <=
             static_cast<std::size_t>(service.parts_.settings.connections_max) / 2) {
    if (!taken_) --service_.waiting_;
}

Service::WaitingPlace::~WaitingPlace() {
    if (taken_) --service_.waiting_;
}

Router make_router(Service& service) {
    Router router;
    add_job_routes(router, service);
    add_batch_routes(router, service);
    add_plan_routes(router, service);
    add_measurement_routes(router, service);
    add_image_routes(router, service);
    add_event_routes(router, service);
    add_operation_routes(router, service);
    return router;
}

std::uint64_t body_bytes_max(const Settings& settings, const std::string& path) {
    if (path == kMeasurements) return static_cast<std::uint64_t>(settings.upload_mib) << 20;
    if (path == "/v1/jobs") return static_cast<std::uint64_t>(limits().job_bytes_max);
    if (path == "/v1/batches") return static_cast<std::uint64_t>(limits().batch_bytes_max);
    if (path == "/v1/plans") return static_cast<std::uint64_t>(limits().scene_bytes_max);
    return 0;
}

bool streams_body(const std::string& path) { return path == kMeasurements; }

}  // namespace kiln
