// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace kiln {

using Bytes = std::shared_ptr<const std::string>;

/// Immutable bytes under the SHA-256 of their content. Safe from any thread; several processes may share one.
class BlobStore {
  public:
    virtual ~BlobStore() = default;
    /// Returns the digest (64 hex digits) once the bytes are durable. Throws Error("store_failed").
    virtual std::string put(std::string_view bytes) = 0;
    /// Verified on every read: bytes whose digest does not match are set aside and count as absent.
    virtual Bytes get(const std::string& digest) = 0;  ///< null when absent
    virtual bool contains(const std::string& digest) = 0;
};

struct BlobStats {
    std::uint64_t bytes = 0, count = 0, evicted = 0, quarantined = 0;
};

/// Files DIR/cas.v1/ab/<sha256>, written as temp + fsync + rename + fsync of the directory. When the sum of
/// sizes passes `bytes_max`, the least recently used go. Foreign files in the folder are left alone.
class DiskBlobStore : public BlobStore {
  public:
    DiskBlobStore(const std::string& directory, std::uint64_t bytes_max);
    ~DiskBlobStore() override;
    std::string put(std::string_view bytes) override;
    Bytes get(const std::string& digest) override;
    bool contains(const std::string& digest) override;
    BlobStats stats();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Keeps hot blobs of another store in memory, verified once as they enter; least recently used go first.
class CachedBlobStore : public BlobStore {
  public:
    CachedBlobStore(BlobStore& below, std::uint64_t bytes_max);
    ~CachedBlobStore() override;
    std::string put(std::string_view bytes) override;
    Bytes get(const std::string& digest) override;
    bool contains(const std::string& digest) override;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace kiln
