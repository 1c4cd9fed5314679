// SPDX-License-Identifier: Apache-2.0
#include "server/store/folder_ledger.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <atomic>
#include <cerrno>

namespace kiln {

namespace {

using Word = std::atomic_ref<std::uint64_t>;
static_assert(Word::is_always_lock_free, "processes share the words");

FileDescriptor open_ledger(const std::string& path) {
    FileDescriptor file(open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC,
                             S_IRUSR | S_IWUSR));
    if (!file) throw_errno("open", path);
    return file;
}

}  // namespace

FolderLedger::FolderLedger(const std::string& path) : path_(path) {
    const FileDescriptor file = open_ledger(path);
    // A mapped page that the disk has no room for would be a SIGBUS at the first count.
    errno = posix_fallocate(file.get(), 0, sizeof(Counts));
    if (errno != 0) throw_errno("reserve space for", path);
    void* const mapped =
        mmap(nullptr, sizeof(Counts), PROT_READ | PROT_WRITE, MAP_SHARED, file.get(), 0);
    if (mapped == MAP_FAILED) throw_errno("map", path);
    counts_ = static_cast<Counts*>(mapped);
}

FolderLedger::~FolderLedger() { munmap(counts_, sizeof(Counts)); }

// A description of its own: locks belong to descriptions, and one process's threads exclude each
// other too.
FolderLedger::Hold FolderLedger::hold(int operation) const {
    FileDescriptor file = open_ledger(path_);
    while (flock(file.get(), operation) != 0) {
        if (errno == EWOULDBLOCK) return {};
        if (errno != EINTR) throw_errno("lock", path_);
    }
    return file;
}

FolderLedger::Counts FolderLedger::read() const {
    return {Word(counts_->bytes), Word(counts_->files)};
}

std::uint64_t FolderLedger::add(std::uint64_t bytes) {
    ++Word(counts_->files);
    return Word(counts_->bytes) += bytes;
}

void FolderLedger::take_back(std::uint64_t bytes) {
    --Word(counts_->files);
    Word(counts_->bytes) -= bytes;
}

}  // namespace kiln
