// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <tuple>

#include "server/base/error.h"
#include "server/base/sha256.h"
#include "server/store/blob_folder.h"
#include "server/store/blob_store.h"
#include "server/store/folder_ledger.h"

namespace kiln {

namespace {

void require_digest(const std::string& digest) {
    if (!is_sha256_hex(digest))
        throw Error("store_failed", "a blob's name is 64 lower-case hexadecimal digits");
}

}  // namespace

// Several processes write into one folder. A walk over it tells its bytes, and the ledger what all
// of them have put since: together never less than what is there, so the budget holds at every
// moment. Once that bound passes the budget, the next put walks again, alone in the folder; and as
// eviction frees a tenth of the budget at once, walks stay rare.
struct DiskBlobStore::State {
    State(const std::string& directory, std::uint64_t limit)
        : folder(directory), ledger(folder.ledger_path()), bytes_max(limit) {}

    FolderLedger::Hold reserve(std::uint64_t bytes);
    void make_room(std::uint64_t bytes);
    void walk();
    void evict(std::uint64_t target);

    BlobFolder folder;
    FolderLedger ledger;
    const std::uint64_t bytes_max;
    std::atomic<std::uint64_t> evicted{0}, quarantined{0};

    std::mutex mutex;
    std::vector<BlobEntry> entries;  // as last walked; only held between walk and eviction
    std::uint64_t walked_bytes = 0, walked_count = 0;  // by the last walk, less what was evicted
    FolderLedger::Counts at_walk;
    std::chrono::steady_clock::time_point walked_at;
};

// By who is alone in the folder.
void DiskBlobStore::State::walk() {
    entries = folder.list();
    walked_bytes = 0;
    for (const BlobEntry& entry : entries) walked_bytes += entry.bytes;
    walked_count = entries.size();
    at_walk = ledger.read();
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

void DiskBlobStore::State::make_room(std::uint64_t bytes) {
    const std::uint64_t rest = bytes_max - bytes;
    // Entries that somebody uses between a walk and their turn stay, so one walk may not do.
    for (int walks = 0; walks < 8; ++walks) {
        walk();
        if (walked_bytes > rest) evict(rest - std::min(rest, bytes_max / 10));
        entries = {};
        if (walked_bytes <= rest) return;
    }
    throw Error("store_failed", "no room for a blob of " + std::to_string(bytes) +
                                    " bytes: " + std::to_string(walked_bytes) +
                                    " bytes in the blob folder cannot be removed");
}

FolderLedger::Hold DiskBlobStore::State::reserve(std::uint64_t bytes) {
    {
        FolderLedger::Hold shared = ledger.share();
        std::lock_guard lock(mutex);
        if (walked_bytes + (ledger.add(bytes) - at_walk.bytes) <= bytes_max) return shared;
        ledger.take_back(bytes);
    }
    FolderLedger::Hold alone = ledger.alone();
    std::lock_guard lock(mutex);
    make_room(bytes);
    ledger.add(bytes);
    return alone;
}

DiskBlobStore::DiskBlobStore(const std::string& directory, std::uint64_t bytes_max)
    : state_(std::make_unique<State>(directory, bytes_max)) {
    const FolderLedger::Hold alone = state_->ledger.alone();
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
    const FolderLedger::Hold hold = state_->reserve(bytes.size());
    try {
        state_->folder.write(digest, bytes);
    } catch (...) {
        state_->ledger.take_back(bytes.size());
        throw;
    }
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
    // Metrics may be asked for often, and the walk is long where entries are many. While a put is
    // under way the last one has to do: a metric does not wait for a disk.
    constexpr auto kFresh = std::chrono::seconds(1);
    const FolderLedger::Hold alone = state_->ledger.alone_if_free();
    std::lock_guard lock(state_->mutex);
    if (alone && std::chrono::steady_clock::now() - state_->walked_at > kFresh) {
        state_->walk();
        state_->entries = {};
    }
    const FolderLedger::Counts now = state_->ledger.read();
    return {.bytes = state_->walked_bytes + (now.bytes - state_->at_walk.bytes),
            .count = state_->walked_count + (now.files - state_->at_walk.files),
            .evicted = state_->evicted,
            .quarantined = state_->quarantined};
}

}  // namespace kiln
