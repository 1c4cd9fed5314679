// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
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

std::uint64_t cost_of(std::uint64_t bytes) { return bytes + kEntryOverheadBytes; }

/// Memory that is taken from the moment a blob is about to be read until nobody holds it.
class Place {
  public:
    Place(std::shared_ptr<std::atomic<std::uint64_t>> taken, std::uint64_t cost)
        : taken_(std::move(taken)), cost_(cost) {
        *taken_ += cost_;
    }
    ~Place() { *taken_ -= cost_; }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

  private:
    std::shared_ptr<std::atomic<std::uint64_t>> taken_;
    std::uint64_t cost_;
};

/// Bytes that keep their place; the bytes go first.
struct Held {
    std::unique_ptr<Place> place;
    Bytes bytes;
};

}  // namespace

struct CachedBlobStore::State {
    struct Entry {
        std::string digest;
        Bytes bytes;
        Clock::time_point touched;
    };

    State(BlobStore& store, std::uint64_t limit, std::uint64_t loose_limit)
        : below(store), bytes_max(limit), loose_bytes_max(loose_limit) {}
    std::uint64_t cost(const Bytes& bytes) const { return cost_of(bytes->size()); }
    std::unique_ptr<Place> take_place(std::uint64_t bytes);
    Bytes read(const std::string& digest);
    void insert(const std::string& digest, const Bytes& bytes);
    Bytes load(const std::string& digest);

    BlobStore& below;
    const std::uint64_t bytes_max, loose_bytes_max;
    std::mutex mutex;
    std::list<Entry> recent;  // most recently used first
    std::unordered_map<std::string, std::list<Entry>::iterator> by_digest;
    std::uint64_t bytes_held = 0;
    // By all blobs in being, those of the cache included. Callers may outlive the store.
    std::shared_ptr<std::atomic<std::uint64_t>> taken =
        std::make_shared<std::atomic<std::uint64_t>>(0);
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

std::unique_ptr<Place> CachedBlobStore::State::take_place(std::uint64_t bytes) {
    const std::lock_guard lock(mutex);
    const std::uint64_t loose = *taken - std::min<std::uint64_t>(*taken, bytes_held);
    if (loose > 0 && loose + cost_of(bytes) > loose_bytes_max)
        throw Error("too_many_downloads", "the results that are being sent fill the " +
                                              std::to_string(loose_bytes_max >> 20) +
                                              " MiB of memory that they may take; try again soon");
    return std::make_unique<Place>(taken, cost_of(bytes));
}

Bytes CachedBlobStore::State::read(const std::string& digest) {
    const std::optional<std::uint64_t> bytes = below.size(digest);
    if (!bytes) return nullptr;
    const auto held = std::make_shared<Held>();
    held->place = take_place(*bytes);
    held->bytes = below.get(digest);
    return held->bytes == nullptr ? nullptr : Bytes(held, held->bytes.get());
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
        Bytes bytes = read(digest);
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

CachedBlobStore::CachedBlobStore(BlobStore& below, std::uint64_t bytes_max,
                                 std::uint64_t loose_bytes_max)
    : state_(std::make_unique<State>(below, bytes_max, loose_bytes_max)) {}
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

std::optional<std::uint64_t> CachedBlobStore::size(const std::string& digest) {
    return state_->below.size(digest);
}

}  // namespace kiln
