// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <chrono>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "server/base/error.h"
#include "server/http/bounds.h"
#include "server/http/documents.h"
#include "server/http/measurement_documents.h"
#include "server/http/problems.h"
#include "server/http/query.h"
#include "server/http/service.h"

namespace kiln {

namespace {

/// Where the finished images are, kept for a moment so that hot ones cost no look into the store.
/// The time is short, as another front may have queued the job afresh.
class ImageIndex {
  public:
    struct Image {
        std::string digest, extension;
    };

    Image find(Service& service, const std::string& id) {
        const Clock::time_point now = Clock::now();
        {
            const std::lock_guard lock(mutex_);
            const auto found = entries_.find(id);
            if (found != entries_.end() && found->second.until > now) return found->second.image;
        }
        const JobRecord job = service.find(id);
        if (job.state != JobState::done)
            throw Error("not_done", "the job is " + std::string(to_word(job.state)) +
                                        ": it has no image" +
                                        (is_final(job.state) ? "; post it again" : " yet"));
        const Image image{job.image_digest, job.image_extension};
        const std::lock_guard lock(mutex_);
        if (entries_.size() >= kImageIndexEntriesMax) entries_.clear();
        entries_[id] = {image, now + kKept};
        return image;
    }

  private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::seconds kKept{1};
    struct Entry {
        Image image;
        Clock::time_point until;
    };
    std::mutex mutex_;
    std::unordered_map<std::string, Entry> entries_;
};

/// RFC 9110 13.1.2: "*" or a list of tags, compared weakly.
bool matches(std::string_view field, const std::string& tag) {
    // A tag is a quoted digest: where its text stands, it stands as a whole.
    return field == "*" || field.find(tag) != field.npos;
}

/// Narrows a 200 to the one range that was asked for. Throws Error("bad_range").
void apply_range(std::string_view field, HttpResponse& response) {
    constexpr std::string_view kUnit = "bytes=";
    if (field.substr(0, kUnit.size()) != kUnit) return;  // RFC 9110 14.2: unknown units are ignored
    field.remove_prefix(kUnit.size());
    const std::size_t size = response.length;
    const std::string satisfiable = "; the image has " + std::to_string(size) + " bytes";
    const std::size_t dash = field.find('-');
    const auto number = [&](std::string_view text) {
        std::size_t value = 0;
        const auto [stopped, error] =
            std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || stopped != text.data() + text.size())
            throw Error("bad_range", "give one range, bytes=FIRST-LAST" + satisfiable);
        return value;
    };
    if (dash == field.npos)
        throw Error("bad_range", "give one range, bytes=FIRST-LAST" + satisfiable);
    const std::string_view first_text = field.substr(0, dash), last_text = field.substr(dash + 1);
    std::size_t first = 0, last = size - 1;
    if (first_text.empty()) {
        const std::size_t suffix = number(last_text);
        if (suffix == 0) throw Error("bad_range", "an empty range" + satisfiable);
        first = size - std::min(size, suffix);
    } else {
        first = number(first_text);
        if (!last_text.empty()) last = std::min(last, number(last_text));
        if (first >= size || first > last)
            throw Error("bad_range", "the range holds no byte" + satisfiable);
    }
    response.status = 206;
    response.offset = first;
    response.length = last - first + 1;
    response.headers.emplace_back(
        "Content-Range",
        "bytes " + std::to_string(first) + "-" + std::to_string(last) + "/" + std::to_string(size));
}

HttpResponse get_image(Service& service, ImageIndex& index, const HttpRequest& request,
                       const std::string& id, const std::string& extension) {
    expect_only(request, {});
    const ImageIndex::Image image = index.find(service, id);
    if (!extension.empty() && extension != image.extension)
        throw Error("wrong_extension", "the image of this job is image." + image.extension);
    const std::string tag = '"' + image.digest + '"';
    HttpResponse response;
    response.headers = {{"ETag", tag},
                        {"Cache-Control", "public, max-age=31536000, immutable"},
                        {"Accept-Ranges", "bytes"}};
    if (const auto known = request.header("if-none-match"); known && matches(*known, tag)) {
        response.status = 304;
        return response;
    }
    response.blob = service.parts().blobs.get(image.digest);
    if (!response.blob)
        throw Error("gone", "the image was evicted from the cache; post the job again");
    response.length = response.blob->size();
    response.content_type = image.extension == "png" ? "image/png" : "image/x-exr";
    response.headers.emplace_back(
        "Content-Disposition",
        "inline; filename=\"kiln-" + id.substr(0, 16) + "." + image.extension + "\"");
    const auto range = request.header("range");
    const auto if_range = request.header("if-range");
    if (range && (!if_range || *if_range == tag)) {
        try {
            apply_range(*range, response);
        } catch (const Error& refusal) {
            HttpResponse refused = problem_of(refusal);
            refused.headers.emplace_back("Content-Range",
                                         "bytes */" + std::to_string(response.blob->size()));
            return refused;
        }
    }
    return response;
}

JobRecord find_done(Service& service, const std::string& id, const std::string& what) {
    JobRecord job = service.find(id);
    if (job.state != JobState::done)
        throw Error("not_done", "the job is " + std::string(to_word(job.state)) + ": it has no " +
                                    what + (is_final(job.state) ? "" : " yet"));
    return job;
}

HttpResponse get_report(Service& service, const HttpRequest& request, const std::string& id) {
    expect_only(request, {});
    return json_response(200, find_done(service, id, "report").report);
}

HttpResponse get_sidecar(Service& service, const HttpRequest& request, const std::string& id) {
    expect_only(request, {});
    return json_response(200, sidecar_document(find_done(service, id, "side-car").report));
}

}  // namespace

void add_image_routes(Router& router, Service& service) {
    const auto index = std::make_shared<ImageIndex>();
    for (const std::string extension : {"", "exr", "png"}) {
        const std::string path = "/v1/jobs/{id}/image" + (extension.empty() ? "" : "." + extension);
        router.add("GET", path,
                   [&service, index, extension](const HttpRequest& request, const std::string& id) {
                       return get_image(service, *index, request, id, extension);
                   });
    }
    router.add("GET", "/v1/jobs/{id}/report",
               [&](const HttpRequest& request, const std::string& id) {
                   return get_report(service, request, id);
               });
    router.add("GET", "/v1/jobs/{id}/sidecar",
               [&](const HttpRequest& request, const std::string& id) {
                   return get_sidecar(service, request, id);
               });
}

}  // namespace kiln
