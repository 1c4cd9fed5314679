// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <tuple>

#include "server/base/error.h"
#include "server/base/sha256.h"
#include "server/store/blob_folder.h"
#include "server/store/blob_store.h"

namespace kiln {

namespace {

void require_digest(const std::string& digest) {
    if (!is_sha256_hex(digest))
        throw Error("store_failed", "a blob's name is 64 lower-case hexadecimal digits");
}

}  // namespace

// Several processes write into one folder and none knows the others' puts, so a count of bytes
// ages. Usage is taken from a walk over the folder, plus this process's own puts since; and the
// walk is repeated when those pass half of the room that it found. Two writers together then stay
// within the budget, and as eviction frees a tenth of the budget at once, walks stay rare.
struct DiskBlobStore::State {
    State(const std::string& directory, std::uint64_t limit)
        : folder(directory), bytes_max(limit) {}

    void reserve(std::uint64_t bytes);
    void settle(std::uint64_t bytes, bool stored);
    void make_room(std::uint64_t bytes);
    void walk();
    void evict(std::uint64_t target);

    BlobFolder folder;
    const std::uint64_t bytes_max;
    std::atomic<std::uint64_t> evicted{0}, quarantined{0};

    std::mutex mutex;
    std::condition_variable settled;
    std::vector<BlobEntry> entries;  // as last walked; only held between walk and eviction
    std::uint64_t walked_bytes = 0, walked_count = 0;  // by the last walk, less what was evicted
    std::uint64_t put_bytes = 0, put_count = 0;        // by this process since
    std::uint64_t in_flight = 0;                       // reserved by puts under way
    std::chrono::steady_clock::time_point walked_at;
};

void DiskBlobStore::State::walk() {
    entries = folder.list();
    walked_bytes = 0;
    for (const BlobEntry& entry : entries) walked_bytes += entry.bytes;
    walked_count = entries.size();
    put_bytes = put_count = 0;
    walked_at = std::chrono::steady_clock::now();
}

// Least recently used first, until at most `target` bytes are left.
void DiskBlobStore::State::evict(std::uint64_t target) {
    std::sort(entries.begin(), entries.end(), [](const BlobEntry& a, const BlobEntry& b) {
        return std::tie(a.used.tv_sec, a.used.tv_nsec, a.digest) <
               std::tie(b.used.tv_sec, b.used.tv_nsec, b.digest);
    });
    for (const BlobEntry& entry : entries) {
        if (walked_bytes <= target) break;
        if (!folder.remove(entry)) continue;
        walked_bytes -= entry.bytes;
        --walked_count;
        ++evicted;
    }
}

// For `bytes` beside all that is under way.
void DiskBlobStore::State::make_room(std::uint64_t bytes) {
    walk();
    const std::uint64_t rest = bytes_max - in_flight - bytes;
    if (walked_bytes > rest) evict(rest - std::min(rest, bytes_max / 10));
    entries = {};
}

void DiskBlobStore::State::reserve(std::uint64_t bytes) {
    std::unique_lock lock(mutex);
    settled.wait(lock, [&] { return in_flight + bytes <= bytes_max; });
    const std::uint64_t room = bytes_max - std::min(bytes_max, walked_bytes);
    if (put_bytes + in_flight + bytes > room / 2) make_room(bytes);
    in_flight += bytes;
}

void DiskBlobStore::State::settle(std::uint64_t bytes, bool stored) {
    {
        std::lock_guard lock(mutex);
        in_flight -= bytes;
        if (stored) {
            put_bytes += bytes;
            ++put_count;
        }
    }
    settled.notify_all();
}

DiskBlobStore::DiskBlobStore(const std::string& directory, std::uint64_t bytes_max)
    : state_(std::make_unique<State>(directory, bytes_max)) {
    state_->make_room(0);
}

DiskBlobStore::~DiskBlobStore() = default;

std::string DiskBlobStore::put(std::string_view bytes) {
    if (bytes.size() > state_->bytes_max)
        throw Error("store_failed", "a blob of " + std::to_string(bytes.size()) +
                                        " bytes does not fit into the blob store's budget of " +
                                        std::to_string(state_->bytes_max) + " bytes");
    const std::string digest = sha256_hex(bytes);
    // An entry that is there is read and compared in full: whoever puts is told that the content is
    // safe, and reading costs a small part of the fsync that it saves.
    const BlobFolder::Content old = state_->folder.read(digest, bytes.size());
    if (old.verdict == BlobFolder::Verdict::good) {
        state_->folder.touch(digest);
        state_->folder.sync(digest);
        return digest;
    }
    if (old.verdict == BlobFolder::Verdict::wrong && state_->folder.quarantine(digest, old.inode))
        ++state_->quarantined;
    state_->reserve(bytes.size());
    try {
        state_->folder.write(digest, bytes);
    } catch (...) {
        state_->settle(bytes.size(), false);
        throw;
    }
    state_->settle(bytes.size(), true);
    return digest;
}

Bytes DiskBlobStore::get(const std::string& digest) {
    require_digest(digest);
    BlobFolder::Content content = state_->folder.read(digest, state_->bytes_max);
    if (content.verdict == BlobFolder::Verdict::wrong &&
        state_->folder.quarantine(digest, content.inode))
        ++state_->quarantined;
    if (content.verdict != BlobFolder::Verdict::good) return nullptr;
    state_->folder.touch(digest);
    return std::make_shared<const std::string>(std::move(content.bytes));
}

bool DiskBlobStore::contains(const std::string& digest) {
    require_digest(digest);
    if (!state_->folder.size(digest)) return false;
    state_->folder.touch(digest);
    return true;
}

std::optional<std::uint64_t> DiskBlobStore::size(const std::string& digest) {
    require_digest(digest);
    return state_->folder.size(digest);
}

BlobStats DiskBlobStore::stats() {
    // Metrics may be asked for often, and the walk is long where entries are many.
    constexpr auto kFresh = std::chrono::seconds(1);
    std::lock_guard lock(state_->mutex);
    if (std::chrono::steady_clock::now() - state_->walked_at > kFresh) {
        state_->walk();
        state_->entries = {};
    }
    return {.bytes = state_->walked_bytes + state_->put_bytes,
            .count = state_->walked_count + state_->put_count,
            .evicted = state_->evicted,
            .quarantined = state_->quarantined};
}

}  // namespace kiln
