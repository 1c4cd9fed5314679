// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/store/incoming_blob.h"

namespace kiln {

/// A measured file that was read once, and what was understood of it.
struct Measurement {
    std::string digest;  ///< SHA-256, 64 hex digits
    std::uint64_t bytes = 0;
    std::string format, title;
    std::string unfit;            ///< why no table can be made of it, "" where one can
    std::string account;          ///< JSON; left empty in pages
    std::int64_t readers = 0;     ///< revision of what read it
    std::int64_t created_ms = 0;  ///< Unix time, for display only
};

struct MeasurementPage {
    std::vector<Measurement> measurements;  ///< newest first
    std::string next_cursor;                ///< "" on the last page
};

/// The measurements of a data directory: files DIR/measurements/cas.v1/ab/<sha256> and an index
/// beside them. Beyond `bytes_max` (files and accounts) and kMeasurementsMax, the least recently
/// used go. One process writes (the front); workers read the files through measurement_bytes().
/// Safe from any thread. Throws Error("store_failed").
class MeasurementStore {
  public:
    MeasurementStore(const std::string& data_dir, std::uint64_t bytes_max);
    ~MeasurementStore();
    MeasurementStore(const MeasurementStore&) = delete;
    MeasurementStore& operator=(const MeasurementStore&) = delete;

    std::unique_ptr<IncomingBlob> receive();
    /// Notes a use. Empty where the index or the file lacks it.
    std::optional<Measurement> find(const std::string& digest);
    /// As find, and the file's bytes are what they were: damaged ones are set aside and count as
    /// absent.
    std::optional<Measurement> find_sound(const std::string& digest);
    /// Keeps a blob (seal it before: that may take long) under `what`, whose digest and bytes are
    /// filled in. `in_use` gives the digests that must stay; throws Error("measurements_full")
    /// where they leave no room.
    Measurement keep(IncomingBlob& blob, Measurement what,
                     const std::function<std::set<std::string>()>& in_use);
    /// Replaces what was understood, after readers have changed.
    void update(const Measurement& what);
    /// The file, for reading; empty where it is gone.
    FileDescriptor open(const std::string& digest);
    /// limit ≥ 1; throws Error("bad_cursor").
    MeasurementPage list(int limit, const std::string& cursor);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// A measurement's bytes, verified. Throws Error("measurement_missing") where they are gone or
/// damaged.
std::string measurement_bytes(const std::string& data_dir, const std::string& digest);

}  // namespace kiln
