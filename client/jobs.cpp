// SPDX-License-Identifier: Apache-2.0
// `ls` and `cancel`: the jobs of a server.
#include <time.h>

#include <algorithm>
#include <cstdio>

#include "client/api.h"
#include "client/commands.h"
#include "client/json.h"
#include "server/base/sha256.h"

namespace kiln::client {

namespace {

constexpr std::size_t kIdShown = 12;   // enough to name one job among millions
constexpr std::size_t kPrefixMin = 8;  // shorter starts are slips of the keyboard
constexpr std::size_t kSearchMax = 10000;

Api server_of(const ServerOptions& options) {
    return Api(options.server.empty() ? kDefaultServer : options.server, [] { return false; });
}

std::string full_id(Api& api, const std::string& id) {
    if (is_sha256_hex(id)) return id;
    const bool hex = id.find_first_not_of("0123456789abcdef") == std::string::npos;
    if (!hex || id.size() < kPrefixMin || id.size() > 64)
        throw Failure(Exit::usage, "bad_id",
                      "a job id is 64 lower-case hex digits, or the first " +
                          std::to_string(kPrefixMin) + " or more of them");
    std::string found;
    for (const JobStatus& job : api.list("", kSearchMax)) {
        if (!job.id.starts_with(id)) continue;
        if (!found.empty())
            throw Failure(Exit::usage, "ambiguous_id", "several jobs start with " + id);
        found = job.id;
    }
    if (found.empty()) throw Failure(Exit::failed, "not_found", "no job starts with " + id);
    return found;
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
}

/// "3 h" from "2026-01-31T12:00:00.000Z"; "" where there is no such time.
std::string age_of(const std::string& created, std::time_t now) {
    std::tm parts{};
    const char* end = strptime(created.c_str(), "%Y-%m-%dT%H:%M:%S", &parts);
    if (end == nullptr || (*end != '.' && *end != 'Z')) return "";
    // Clocks of two machines differ: what is younger than now is new.
    const auto age_s = std::max<long>(0, static_cast<long>(now - timegm(&parts)));
    struct Unit {
        long seconds;
        const char* name;
    };
    for (const auto& [seconds, name] : {Unit{86400, " d"}, Unit{3600, " h"}, Unit{60, " min"}})
        if (age_s >= 2 * seconds) return std::to_string(age_s / seconds) + name;
    return std::to_string(age_s) + " s";
}

}  // namespace

Exit list_jobs(const ServerOptions& options, const std::string& state, std::size_t count_max) {
    Api api = server_of(options);
    const std::vector<JobStatus> jobs = api.list(state, count_max);
    if (options.json) {
        std::printf("%s\n", jobs_json(jobs).c_str());
        return Exit::done;
    }
    if (jobs.empty()) {
        say("kiln: no jobs at " + printable(api.url()));
        return Exit::done;
    }
    const std::time_t now = std::time(nullptr);
    for (const JobStatus& job : jobs) {
        std::string what = joined(job.quantities);
        if (job.kind != "lut") what = job.kind + (what.empty() ? "" : " of ") + what;
        if (!job.error_code.empty() && job.error_code != job.state)
            what += (what.empty() ? "" : "; ") + job.error_code + ": " + job.error_detail;
        std::printf("%s  %-9s  %3.0f %%  %8s ago%s\n", job.id.substr(0, kIdShown).c_str(),
                    printable(job.state).c_str(), 100 * job.progress,
                    age_of(job.created, now).c_str(),
                    what.empty() ? "" : ("  " + printable(what)).c_str());
    }
    return Exit::done;
}

Exit cancel(const ServerOptions& options, const std::string& id) {
    Api api = server_of(options);
    const std::string full = full_id(api, id);
    const bool cancelled = api.cancel(full);
    if (!cancelled)
        throw Failure(Exit::failed, "finished", "job " + full + " has finished already");
    if (options.json)
        std::printf("{\"id\": \"%s\", \"cancelled\": true}\n", full.c_str());
    else
        say("kiln: cancelled " + full);
    return Exit::done;
}

}  // namespace kiln::client
