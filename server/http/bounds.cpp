// SPDX-License-Identifier: Apache-2.0
#include "server/http/bounds.h"

namespace kiln {

namespace {
template <typename Duration>
std::uint64_t count_of(Duration time) {
    return static_cast<std::uint64_t>(time.count());
}
}  // namespace

Bounds http_bounds() {
    return {
        {"head_bytes_max", kHeadBytesMax, "bytes", "Largest head of a request."},
        {"head_lines_max", kHeadLinesMax, "fields", "Most header fields of a request."},
        {"path_bytes_max", kPathBytesMax, "bytes", "Longest path of a request."},
        {"target_bytes_max", kTargetBytesMax, "bytes", "Longest path and query together."},
        {"backlog_max", kBacklogMax, "connections", "Waiting to be accepted."},
        {"linger_ms_max", count_of(kLingerTimeMax), "ms",
         "What a refused client still sends is read and dropped this long."},
        {"linger_bytes_max", kLingerBytesMax, "bytes", "The same, how far."},
        {"send_rate_min", kSendBytesPerSecondMin, "bytes/s",
         "A client that takes an answer more slowly is cut off."},
        {"receive_rate_min", kReceiveBytesPerSecondMin, "bytes/s",
         "A measurement that comes in more slowly is refused, once body_timeout_s is over."},
        {"measurement_uploads_max", kMeasurementUploadsMax, "measurements", "Coming in at a time."},
        {"readers_max", kReadersMax, "processes", "That read a measurement, at a time."},
        {"reader_patience_s_max", count_of(kReaderPatienceMax), "s",
         "For a measurement to wait until others are read."},
        {"reader_s_max", count_of(kReaderTimeMax), "s", "Of a core, for a measurement to be read."},
        {"reader_wait_s_max", count_of(kReaderWaitMax), "s",
         "For a measurement to be read, however busy the machine is."},
        {"reader_memory_bytes_max", kReaderMemoryMax, "bytes",
         "Of a process that reads a measurement."},
        {"reader_answer_bytes_max", kReaderAnswerBytesMax, "bytes",
         "What is understood of a measurement, as text."},
        {"coalesced_bytes_max", kCoalescedBytesMax, "bytes",
         "Of an answer, held back until more is there to send."},
        {"upload_bytes_max", kUploadBytesMax, "bytes",
         "Of all bodies larger than a batch that are held at one time."},
        {"plans_max", kPlansMax, "scenes", "Read at a time."},
        {"plan_patience_s_max", count_of(kPlanPatienceMax), "s",
         "For a scene to wait until others are read."},
        {"image_index_entries_max", kImageIndexEntriesMax, "jobs",
         "Whose image is found without a look into the store."},
        {"worker_line_bytes_max", kWorkerLineBytesMax, "bytes",
         "Longest line of a worker to the server."},
        {"worker_backoff_ms_max", count_of(kBackoffMax), "ms",
         "Between two starts of a worker that keeps dying."},
        {"worker_abandon_s_max", count_of(kAbandonTimeMax), "s",
         "For a worker to drop its job and end, once told to."},
    };
}

}  // namespace kiln
