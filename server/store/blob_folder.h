// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/stat.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/posix_file.h"

namespace kiln {

/// What a walk over the folder found.
struct BlobEntry {
    std::string digest;
    std::uint64_t bytes = 0;
    timespec used{};  ///< last use: the file's modification time
};

class IncomingBlob;

/// The files of one blob store: names, reading, writing, listing, setting aside. Knows nothing of
/// budgets and keeps no state but the open folder, so any thread may call anything.
/// All names are digests that passed is_sha256_hex. Throws Error("store_failed").
class BlobFolder {
  public:
    explicit BlobFolder(const std::string& directory);

    /// Of the ledger over the folder.
    std::string ledger_path() const { return root_path_ + "/ledger"; }

    enum class Verdict { absent, good, wrong };
    struct Content {
        Verdict verdict = Verdict::absent;
        std::string bytes;  ///< when good
        ino_t inode = 0;    ///< of the file that was read
    };
    /// Verified against the digest. Anything that is not a regular file is absent, and so are files
    /// larger than `bytes_max`. A failing disk is an Error, never an absent entry.
    Content read(const std::string& digest, std::uint64_t bytes_max) const;
    /// Of a regular file.
    std::optional<std::uint64_t> size(const std::string& digest) const;
    /// For reading; not verified. Empty where there is no regular file.
    FileDescriptor open(const std::string& digest) const;
    /// Notes a use, for eviction. A failure costs no more than a worse choice later.
    void touch(const std::string& digest) const;
    /// Returns once file and name are durable; on failure nothing half-written stays.
    void write(const std::string& digest, std::string_view bytes) const;
    /// A blob whose bytes come piece by piece, and whose digest is known at the end.
    std::unique_ptr<IncomingBlob> receive() const;
    /// Under its digest, durable.
    void keep(IncomingBlob& blob) const;
    /// Makes an entry's name durable that some process, maybe another, has just renamed into place.
    void sync(const std::string& digest) const;
    /// Moves the entry to quarantine/ if it still is the file `inode`. True if it moved.
    bool quarantine(const std::string& digest, std::optional<ino_t> inode) const;
    /// All entries; removes temporary files whose writer is gone on the way.
    std::vector<BlobEntry> list() const;
    /// Removes the entry unless it was used or rewritten since it was listed. An entry that another
    /// process removed first counts as removed.
    bool remove(const BlobEntry& entry) const;

  private:
    FileDescriptor shard(const std::string& digest) const;
    FileDescriptor make_shard(const std::string& digest) const;
    FileDescriptor make_temporary(const FileDescriptor& folder, std::string& name) const;
    void move_into_place(int from, const std::string& name, const FileDescriptor& folder,
                         const std::string& digest) const;
    void list_shard(const std::string& name, std::vector<BlobEntry>& entries) const;
    void trim_quarantine() const;
    std::string path_of(const std::string& digest) const;

    std::string root_path_;
    FileDescriptor root_, quarantine_;
};

}  // namespace kiln
