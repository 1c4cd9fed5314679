// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <semaphore>

#include "server/base/error.h"
#include "server/http/bounds.h"
#include "server/http/documents.h"
#include "server/http/measurement_documents.h"
#include "server/http/measurement_reader.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/spec/limits.h"

namespace kiln {

namespace {

using Uploads = std::counting_semaphore<kMeasurementUploadsMax>;
using Readers = std::counting_semaphore<kReadersMax>;

template <class Places>
class Place {
  public:
    Place(Places& places, std::chrono::milliseconds patience, const char* why) : places_(places) {
        if (!places_.try_acquire_for(patience)) throw Error("too_many_uploads", why);
    }
    ~Place() { places_.release(); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

  private:
    Places& places_;
};

class Measurements {
  public:
    explicit Measurements(Service& service) : service_(service) {}

    HttpResponse post(const HttpRequest& request) {
        expect_only(request, {});
        expect_bytes(request);
        if (service_.draining()) throw Error("draining", "the server is stopping; try again soon");
        if (request.content_length == 0)
            throw Error("malformed_measurement", "the body is empty; send a measured file's bytes");
        const Place coming(uploads_, std::chrono::milliseconds(0),
                           "as many measurements come in as may at a time; try again soon");
        const auto blob = store().receive();
        request.receive([&blob](std::string_view piece) { blob->write(piece); });
        if (const auto known = store().find_sound(blob->digest()))
            return answer(200, current(*known));
        const FileDescriptor file = blob->reader();
        const Measurement understood = read(file.get());
        return answer(201, service_.keep_measurement(*blob, understood));
    }

    HttpResponse get(const HttpRequest& request, const std::string& digest) {
        expect_only(request, {});
        const auto found = store().find(digest);
        if (!found)
            throw Error("missing_measurement",
                        "there is no measurement with this id; it was never here or was evicted");
        return answer(200, current(*found));
    }

    HttpResponse list(const HttpRequest& request) {
        expect_only(request, {"limit", "cursor"});
        const auto limit =
            integer_of(request, "limit", limits().list_limit_default, 1, limits().list_limit_max);
        const auto cursor = request.query.find("cursor");
        const MeasurementPage page = store().list(
            static_cast<int>(limit), cursor == request.query.end() ? "" : cursor->second);
        HttpResponse response = json_response(200, measurement_page_document(page));
        if (!page.next_cursor.empty())
            response.headers.emplace_back("Link",
                                          "</v1/measurements?limit=" + std::to_string(limit) +
                                              "&cursor=" + page.next_cursor + ">; rel=\"next\"");
        return response;
    }

  private:
    MeasurementStore& store() { return service_.parts().measurements; }

    Measurement read(int file) {
        const Place reading(readers_, kReaderPatienceMax,
                            "other measurements are being read; try again soon");
        return read_in_a_process(file, service_.parts().readers);
    }

    /// As today's readers understand it.
    Measurement current(Measurement known) {
        if (known.readers == service_.parts().readers) return known;
        const FileDescriptor file = store().open(known.digest);
        if (!file) throw Error("missing_measurement", "the measurement was evicted just now");
        Measurement afresh = read(file.get());
        afresh.digest = known.digest;
        afresh.bytes = known.bytes;
        afresh.created_ms = known.created_ms;
        store().update(afresh);
        return afresh;
    }

    static HttpResponse answer(int status, const Measurement& measurement) {
        HttpResponse response = json_response(status, measurement_document(measurement));
        response.headers.emplace_back("Location", "/v1/measurements/sha256:" + measurement.digest);
        return response;
    }

    Service& service_;
    Uploads uploads_{kMeasurementUploadsMax};
    Readers readers_{kReadersMax};
};

}  // namespace

void add_measurement_routes(Router& router, Service& service) {
    const auto measurements = std::make_shared<Measurements>(service);
    router.add("POST", "/v1/measurements",
               [measurements](const HttpRequest& request, const std::string&) {
                   return measurements->post(request);
               });
    router.add("GET", "/v1/measurements",
               [measurements](const HttpRequest& request, const std::string&) {
                   return measurements->list(request);
               });
    // A client may encode the colon.
    for (const std::string prefix : {"sha256:", "sha256%3A", "sha256%3a", ""})
        router.add("GET", "/v1/measurements/" + prefix + "{id}",
                   [measurements](const HttpRequest& request, const std::string& id) {
                       return measurements->get(request, id);
                   });
}

}  // namespace kiln
