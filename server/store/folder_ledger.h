// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/file.h>

#include <cstdint>
#include <string>

#include "server/store/posix_file.h"

namespace kiln {

/// What all processes together have put into one folder since it was made: a count of bytes and of
/// files in a file that they map, and a lock on that file. Whoever puts shares the lock until the
/// entry is in place; whoever counts the folder's files holds it alone, so that no put is half
/// way. The counts only say how far a listing has aged, so it does no harm that a process which
/// dies in a put leaves them too high.
/// Any thread may call anything. Throws Error("store_failed").
class FolderLedger {
  public:
    struct Counts {
        std::uint64_t bytes = 0, files = 0;
    };
    /// Held until destroyed; the kernel drops it with the process.
    using Hold = FileDescriptor;

    explicit FolderLedger(const std::string& path);
    ~FolderLedger();
    FolderLedger(const FolderLedger&) = delete;
    FolderLedger& operator=(const FolderLedger&) = delete;

    /// Beside others that share; waits while one holds it alone.
    Hold share() const { return hold(LOCK_SH); }
    /// Waits until nobody else holds it.
    Hold alone() const { return hold(LOCK_EX); }
    /// Without waiting: false where somebody else holds it.
    Hold alone_if_free() const { return hold(LOCK_EX | LOCK_NB); }

    Counts read() const;
    /// The bytes with these. Before the put, by who holds the lock.
    std::uint64_t add(std::uint64_t bytes);
    /// For a put that did not happen.
    void take_back(std::uint64_t bytes);

  private:
    Hold hold(int operation) const;

    std::string path_;
    Counts* counts_ = nullptr;
};

}  // namespace kiln
