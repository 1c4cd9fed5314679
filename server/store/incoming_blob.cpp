// SPDX-License-Identifier: Apache-2.0
#include "server/store/incoming_blob.h"

#include <fcntl.h>
#include <unistd.h>

namespace kiln {

IncomingBlob::IncomingBlob(FileDescriptor folder, FileDescriptor file, std::string name)
    : folder_(std::move(folder)), file_(std::move(file)), name_(std::move(name)) {}

IncomingBlob::~IncomingBlob() {
    if (!name_.empty()) unlinkat(folder_.get(), name_.c_str(), 0);
}

void IncomingBlob::write(std::string_view bytes) {
    if (!write_all(file_.get(), bytes)) throw_errno("write", name_);
    hash_.update(bytes);
    size_ += bytes.size();
}

const std::string& IncomingBlob::digest() {
    if (digest_.empty()) digest_ = hash_.hex();
    return digest_;
}

void IncomingBlob::seal() {
    if (sealed_) return;
    // After a failed fsync the kernel may have dropped the pages: it is final, never retried.
    if (fsync(file_.get()) != 0) throw_errno("fsync", name_);
    sealed_ = true;
}

FileDescriptor IncomingBlob::reader() const {
    FileDescriptor file(openat(folder_.get(), name_.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
    if (!file) throw_errno("open", name_);
    return file;
}

}  // namespace kiln
