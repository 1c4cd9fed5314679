// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <future>
#include <list>
#include <mutex>
#include <unordered_map>

#include "server/base/error.h"
#include "server/store/blob_store.h"

namespace kiln {

namespace {

using Clock = std::chrono::steady_clock;
// How often a hot blob tells the store below that it is in use, lest it be evicted there first.
constexpr auto kTouchEvery = std::chrono::seconds(60);
// What an entry costs beside its bytes; bounds the count of tiny ones.
constexpr std::uint64_t kEntryOverheadBytes = 256;

}  // namespace

struct CachedBlobStore::State {
    struct Entry {
        std::string digest;
        Bytes bytes;
        Clock::time_point touched;
    };

    State(BlobStore& store, std::uint64_t limit) : below(store), bytes_max(limit) {}
    std::uint64_t cost(const Bytes& bytes) const { return bytes->size() + kEntryOverheadBytes; }
    void insert(const std::string& digest, const Bytes& bytes);
    Bytes load(const std::string& digest);

    BlobStore& below;
    const std::uint64_t bytes_max;
    std::mutex mutex;
    std::list<Entry> recent;  // most recently used first
    std::unordered_map<std::string, std::list<Entry>::iterator> by_digest;
    std::uint64_t bytes_held = 0;
    // Reads of the store below under way: a crowd that asks for one cold blob costs one read.
    std::unordered_map<std::string, std::shared_future<Bytes>> loading;
    // Blobs too large to be kept, as long as somebody uses them.
    std::unordered_map<std::string, std::weak_ptr<const std::string>> passing;
};

// With the mutex held.
void CachedBlobStore::State::insert(const std::string& digest, const Bytes& bytes) {
    if (bytes == nullptr) return;
    if (cost(bytes) > bytes_max / 4) {
        std::erase_if(passing, [](const auto& item) { return item.second.expired(); });
        passing[digest] = bytes;
        return;
    }
    recent.push_front({digest, bytes, Clock::now()});
    by_digest[digest] = recent.begin();
    bytes_held += cost(bytes);
    while (bytes_held > bytes_max) {
        bytes_held -= cost(recent.back().bytes);
        by_digest.erase(recent.back().digest);
        recent.pop_back();
    }
}

Bytes CachedBlobStore::State::load(const std::string& digest) {
    std::promise<Bytes> promise;
    {
        std::unique_lock lock(mutex);
        if (auto found = by_digest.find(digest); found != by_digest.end())
            return found->second->bytes;
        if (auto found = passing.find(digest); found != passing.end())
            if (Bytes bytes = found->second.lock()) return bytes;
        if (auto found = loading.find(digest); found != loading.end()) {
            std::shared_future<Bytes> other = found->second;
            lock.unlock();
            return other.get();
        }
        loading.emplace(digest, promise.get_future().share());
    }
    try {
        Bytes bytes = below.get(digest);
        std::lock_guard lock(mutex);
        insert(digest, bytes);
        loading.erase(digest);
        promise.set_value(bytes);
        return bytes;
    } catch (...) {
        std::lock_guard lock(mutex);
        loading.erase(digest);
        promise.set_exception(std::current_exception());
        throw;
    }
}

CachedBlobStore::CachedBlobStore(BlobStore& below, std::uint64_t bytes_max)
    : state_(std::make_unique<State>(below, bytes_max)) {}
CachedBlobStore::~CachedBlobStore() = default;

// Not kept in memory here: who puts seldom reads, and the first get brings it in, verified.
std::string CachedBlobStore::put(std::string_view bytes) { return state_->below.put(bytes); }

Bytes CachedBlobStore::get(const std::string& digest) {
    Bytes bytes;
    bool touch = false;
    {
        std::lock_guard lock(state_->mutex);
        auto found = state_->by_digest.find(digest);
        if (found != state_->by_digest.end()) {
            State::Entry& entry = *found->second;
            state_->recent.splice(state_->recent.begin(), state_->recent, found->second);
            bytes = entry.bytes;
            const Clock::time_point now = Clock::now();
            touch = now - entry.touched > kTouchEvery;
            if (touch) entry.touched = now;
        }
    }
    if (bytes == nullptr) return state_->load(digest);
    if (touch) {
        try {
            state_->below.contains(digest);
        } catch (const Error&) {
            // The bytes in hand are verified; a failing disk shows at the next cold read.
        }
    }
    return bytes;
}

bool CachedBlobStore::contains(const std::string& digest) {
    {
        std::lock_guard lock(state_->mutex);
        if (state_->by_digest.contains(digest)) return true;
    }
    return state_->below.contains(digest);
}

}  // namespace kiln
