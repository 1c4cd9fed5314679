// SPDX-License-Identifier: Apache-2.0
#include "server/store/measurement_store.h"

#include <algorithm>
#include <charconv>
#include <ctime>
#include <mutex>

#include "server/base/error.h"
#include "server/base/sha256.h"
#include "server/store/blob_folder.h"
#include "server/store/bounds.h"
#include "server/store/sqlite.h"

namespace kiln {

namespace {

constexpr std::int64_t kSchemaVersion = 1;

// used: a counter, not a time, so that setting the clock changes no order.
constexpr const char* kSchema = R"sql(
CREATE TABLE measurements (
  sequence INTEGER PRIMARY KEY AUTOINCREMENT,
  digest TEXT NOT NULL UNIQUE,
  bytes INTEGER NOT NULL,
  format TEXT NOT NULL,
  title TEXT NOT NULL,
  unfit TEXT NOT NULL,
  account TEXT NOT NULL,
  readers INTEGER NOT NULL,
  created_ms INTEGER NOT NULL,
  used INTEGER NOT NULL
) STRICT;
CREATE INDEX measurements_used ON measurements (used);
PRAGMA user_version = 1;
)sql";

const std::string kSelect =
    "SELECT digest, bytes, format, title, unfit, account, readers, created_ms FROM measurements ";

std::string folder_of(const std::string& data_dir) { return data_dir + "/measurements"; }

std::string index_of(const std::string& data_dir) {
    make_private_directory(folder_of(data_dir));
    return folder_of(data_dir) + "/index.db";
}

std::int64_t unix_ms() {
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    return std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000;
}

Measurement read_row(const Rows& row) {
    return {.digest = row.text(0),
            .bytes = static_cast<std::uint64_t>(row.integer(1)),
            .format = row.text(2),
            .title = row.text(3),
            .unfit = row.text(4),
            .account = row.text(5),
            .readers = row.integer(6),
            .created_ms = row.integer(7)};
}

/// A database that has this schema, or gets it.
struct Index : Database {
    explicit Index(const std::string& path) : Database(path) {
        execute("switch to WAL", "PRAGMA journal_mode = WAL");
        execute("set synchronous", "PRAGMA synchronous = FULL");
        Transaction transaction(*this);
        Statement ask(*this, "read schema version", "PRAGMA user_version");
        std::int64_t version = 0;
        for (Rows rows = ask.run(); rows.next();) version = rows.integer(0);
        if (version > kSchemaVersion)
            throw Error("store_failed", "measurements: " + path + " has schema " +
                                            std::to_string(version) +
                                            "; this Kiln knows schemas up to 1");
        if (version == 0) execute("create schema", kSchema);
        transaction.commit();
    }
};

std::int64_t sequence_of(const std::string& cursor) {
    if (cursor.empty()) return INT64_MAX;
    std::int64_t sequence = 0;
    const char* end = cursor.data() + cursor.size();
    const auto [stopped, error] = std::from_chars(cursor.data(), end, sequence);
    if (error != std::errc() || stopped != end || sequence < 1 ||
        std::to_string(sequence) != cursor)
        throw Error("bad_cursor", "the cursor is not one that a list of measurements returned");
    return sequence;
}

}  // namespace

struct MeasurementStore::State {
    State(const std::string& data_dir, std::uint64_t limit)
        : bytes_max(static_cast<std::int64_t>(limit)),
          folder(folder_of(data_dir)),
          index(index_of(data_dir)) {}

    std::optional<Measurement> find(const std::string& digest) {
        std::optional<Measurement> found;
        for (Rows rows = get.run(digest); rows.next();) found = read_row(rows);
        if (!found || !folder.size(digest)) return std::nullopt;
        use.run(digest).finish();
        return found;
    }

    void forget(const BlobEntry& entry) {
        drop.run(entry.digest).finish();
        folder.remove(entry);
    }

    void forget_strays();
    void make_room(std::int64_t bytes, const std::set<std::string>& in_use);

    const std::int64_t bytes_max;
    std::mutex mutex;
    BlobFolder folder;
    Index index;
    Statement get{index, "find", kSelect + "WHERE digest = ?1"};
    Statement use{index, "use",
                  "UPDATE measurements SET used = (SELECT max(used) FROM measurements) + 1 "
                  "WHERE digest = ?1"};
    Statement drop{index, "drop", "DELETE FROM measurements WHERE digest = ?1"};
    Statement total{index, "total",
                    "SELECT coalesce(sum(bytes + length(account)), 0), count(*) "
                    "FROM measurements"};
    Statement oldest{index, "oldest",
                     "SELECT digest, bytes + length(account) FROM measurements ORDER BY used"};
    Statement insert{index, "insert", R"sql(
INSERT INTO measurements (digest, bytes, format, title, unfit, account, readers, created_ms, used)
VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, (SELECT coalesce(max(used), 0) FROM measurements) + 1)
ON CONFLICT (digest) DO UPDATE SET format = excluded.format, title = excluded.title,
  unfit = excluded.unfit, account = excluded.account, readers = excluded.readers,
  used = excluded.used)sql"};
    Statement page{index, "list",
                   "SELECT digest, bytes, format, title, unfit, '', readers, created_ms, sequence "
                   "FROM measurements WHERE sequence < ?1 ORDER BY sequence DESC LIMIT ?2"};
};

// What a process that died left behind: files without a row, rows without a file.
void MeasurementStore::State::forget_strays() {
    std::set<std::string> rows_known;
    for (Rows rows = oldest.run(); rows.next();) rows_known.insert(rows.text(0));
    for (const BlobEntry& entry : folder.list())
        if (rows_known.erase(entry.digest) == 0) folder.remove(entry);
    for (const std::string& digest : rows_known) drop.run(digest).finish();
}

// For `bytes` more: least recently used first.
void MeasurementStore::State::make_room(std::int64_t bytes, const std::set<std::string>& in_use) {
    std::int64_t held = 0, count = 0;
    for (Rows rows = total.run(); rows.next();) {
        held = rows.integer(0);
        count = rows.integer(1);
    }
    std::vector<std::string> going;
    for (Rows rows = oldest.run(); rows.next();) {
        if (held + bytes <= bytes_max && count < kMeasurementsMax) continue;
        if (in_use.contains(rows.text(0))) continue;
        going.push_back(rows.text(0));
        held -= rows.integer(1);
        --count;
    }
    if (held + bytes > bytes_max || count >= kMeasurementsMax)
        throw Error("measurements_full",
                    "jobs that wait or run use the measurements that are here, and they fill the " +
                        std::to_string(bytes_max >> 20) + " MiB for them; try again later");
    if (going.empty()) return;
    const std::set<std::string> names(going.begin(), going.end());
    for (const BlobEntry& entry : folder.list())
        if (names.contains(entry.digest)) forget(entry);
}

MeasurementStore::MeasurementStore(const std::string& data_dir, std::uint64_t bytes_max)
    : state_(std::make_unique<State>(data_dir, bytes_max)) {
    state_->forget_strays();
}

MeasurementStore::~MeasurementStore() = default;

std::unique_ptr<IncomingBlob> MeasurementStore::receive() { return state_->folder.receive(); }

std::optional<Measurement> MeasurementStore::find(const std::string& digest) {
    const std::lock_guard lock(state_->mutex);
    return state_->find(digest);
}

std::optional<Measurement> MeasurementStore::find_sound(const std::string& digest) {
    auto found = find(digest);
    if (!found) return found;
    const BlobFolder::Content content = state_->folder.read(digest, found->bytes);
    if (content.verdict == BlobFolder::Verdict::good) return found;
    if (content.verdict == BlobFolder::Verdict::wrong)
        state_->folder.quarantine(digest, content.inode);
    return std::nullopt;
}

Measurement MeasurementStore::keep(IncomingBlob& blob, Measurement what,
                                   const std::function<std::set<std::string>()>& in_use) {
    blob.seal();
    what.digest = blob.digest();
    what.bytes = blob.size();
    what.created_ms = unix_ms();
    const std::lock_guard lock(state_->mutex);
    state_->make_room(static_cast<std::int64_t>(what.bytes + what.account.size()), in_use());
    state_->folder.keep(blob);
    state_->insert
        .run(what.digest, static_cast<std::int64_t>(what.bytes), what.format, what.title,
             what.unfit, what.account, what.readers, what.created_ms)
        .finish();
    return what;
}

void MeasurementStore::update(const Measurement& what) {
    const std::lock_guard lock(state_->mutex);
    state_->insert
        .run(what.digest, static_cast<std::int64_t>(what.bytes), what.format, what.title,
             what.unfit, what.account, what.readers, what.created_ms)
        .finish();
}

FileDescriptor MeasurementStore::open(const std::string& digest) {
    return state_->folder.open(digest);
}

MeasurementPage MeasurementStore::list(int limit, const std::string& cursor) {
    const std::lock_guard lock(state_->mutex);
    MeasurementPage page;
    std::int64_t last = 0;
    for (Rows rows = state_->page.run(sequence_of(cursor), std::int64_t{limit} + 1); rows.next();) {
        if (page.measurements.size() == static_cast<std::size_t>(limit)) {
            page.next_cursor = std::to_string(last);
            continue;
        }
        page.measurements.push_back(read_row(rows));
        last = rows.integer(8);
    }
    return page;
}

std::string measurement_bytes(const std::string& data_dir, const std::string& digest) {
    const BlobFolder folder(folder_of(data_dir));
    const std::optional<std::uint64_t> size = folder.size(digest);
    BlobFolder::Content content;
    if (size) content = folder.read(digest, *size);
    if (content.verdict == BlobFolder::Verdict::good) return std::move(content.bytes);
    throw Error("measurement_missing",
                "the measurement sha256:" + digest +
                    (size ? " is damaged on the server's disk" : " is no longer on the server") +
                    "; upload it again and post the job again");
}

}  // namespace kiln
