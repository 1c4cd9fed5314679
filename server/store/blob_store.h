// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace kiln {

using Bytes = std::shared_ptr<const std::string>;

/// Immutable bytes under the SHA-256 of their content. Safe from any thread; several processes may
/// share one.
class BlobStore {
  public:
    virtual ~BlobStore() = default;
    /// Returns the digest (64 hex digits) once the bytes are durable. Throws Error("store_failed").
    virtual std::string put(std::string_view bytes) = 0;
    /// Verified on every read: bytes whose digest does not match are set aside and count as absent.
    virtual Bytes get(const std::string& digest) = 0;  ///< null when absent
    /// By name only, like the next: unlike get, it does not read the bytes.
    virtual bool contains(const std::string& digest) = 0;
    virtual std::optional<std::uint64_t> size(const std::string& digest) = 0;  ///< in bytes
};

struct BlobStats {
    std::uint64_t bytes = 0, count = 0, evicted = 0, quarantined = 0;
};

/// Files DIR/cas.v1/ab/<sha256>, written as temp + fsync + rename + fsync of the directory. When
/// the sum of sizes would pass `bytes_max`, the least recently used go until a tenth is free. Wrong
/// bytes move to DIR/cas.v1/quarantine (the last 16 are kept, outside the budget). Foreign files
/// are left alone. An unreadable disk is Error("store_failed") from any call, never an absent blob.
class DiskBlobStore : public BlobStore {
  public:
    DiskBlobStore(const std::string& directory, std::uint64_t bytes_max);
    ~DiskBlobStore() override;
    std::string put(std::string_view bytes) override;
    Bytes get(const std::string& digest) override;
    bool contains(const std::string& digest) override;
    std::optional<std::uint64_t> size(const std::string& digest) override;
    /// `bytes` and `count` never less than what is there, and exact a second after the last put.
    BlobStats stats();  ///< evicted and quarantined by this object

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Keeps hot blobs of another store in memory, verified once as they enter; least recently used go
/// first. Blobs above a quarter of `bytes_max` pass through. What callers hold or wait for beside
/// the cache is at most `loose_bytes_max` together, or one blob if that is larger; get() beyond it
/// throws Error("too_many_downloads"). `below` must outlive it.
class CachedBlobStore : public BlobStore {
  public:
    CachedBlobStore(BlobStore& below, std::uint64_t bytes_max, std::uint64_t loose_bytes_max);
    ~CachedBlobStore() override;
    std::string put(std::string_view bytes) override;
    Bytes get(const std::string& digest) override;
    bool contains(const std::string& digest) override;
    std::optional<std::uint64_t> size(const std::string& digest) override;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace kiln
