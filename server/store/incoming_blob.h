// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "server/base/sha256.h"
#include "server/store/posix_file.h"

namespace kiln {

/// Bytes on their way into a BlobFolder, hashed as they come: a temporary file that goes with this
/// object unless the folder keeps it. Throws Error("store_failed").
class IncomingBlob {
  public:
    /// `file` is open for writing as `name` in `folder`.
    IncomingBlob(FileDescriptor folder, FileDescriptor file, std::string name);
    ~IncomingBlob();
    IncomingBlob(const IncomingBlob&) = delete;
    IncomingBlob& operator=(const IncomingBlob&) = delete;

    void write(std::string_view bytes);
    /// There are no more bytes. Returns their SHA-256, 64 hex digits.
    const std::string& digest();
    /// Makes them durable.
    void seal();
    std::uint64_t size() const { return size_; }
    /// The file opened afresh, for reading alone.
    FileDescriptor reader() const;

  private:
    friend class BlobFolder;
    FileDescriptor folder_, file_;
    std::string name_;  ///< "" once it is kept
    Sha256 hash_;
    std::string digest_;  ///< "" while bytes come
    bool sealed_ = false;
    std::uint64_t size_ = 0;
};

}  // namespace kiln
