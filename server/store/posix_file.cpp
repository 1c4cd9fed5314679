// SPDX-License-Identifier: Apache-2.0
#include "server/store/posix_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "server/base/error.h"

namespace kiln {

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
    if (this != &other) {
        if (fd_ >= 0) close(fd_);
        fd_ = other.release();
    }
    return *this;
}

FileDescriptor::~FileDescriptor() {
    if (fd_ >= 0) close(fd_);
}

int FileDescriptor::release() {
    int fd = fd_;
    fd_ = -1;
    return fd;
}

void throw_errno(const char* call, const std::string& path) {
    const int code = errno;
    throw Error("store_failed",
                std::string(call) + " " + path + ": " + std::generic_category().message(code));
}

namespace {

void fsync_directory(const std::string& path) {
    FileDescriptor directory(open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!directory) throw_errno("open", path);
    if (fsync(directory.get()) != 0) throw_errno("fsync", path);
}

void make_one(const std::filesystem::path& path) {
    if (path.empty()) return;
    if (mkdir(path.c_str(), S_IRWXU) == 0) {
        const std::filesystem::path parent = path.parent_path();
        fsync_directory(parent.empty() ? "." : parent.string());
        return;
    }
    if (errno == ENOENT && path.has_parent_path() && path.parent_path() != path) {
        make_one(path.parent_path());
        make_one(path);
        return;
    }
    struct stat status {};
    const int code = errno;
    if (code == EEXIST && stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode)) return;
    errno = code;
    throw_errno("mkdir", path.string());
}

}  // namespace

void make_private_directory(const std::string& path) {
    std::filesystem::path cleaned = std::filesystem::path(path).lexically_normal();
    if (!cleaned.has_filename()) cleaned = cleaned.parent_path();  // a trailing slash
    make_one(cleaned);
}

bool write_all(int fd, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = write(fd, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
}

ssize_t read_from_start(int fd, char* out, std::size_t byte_count) {
    std::size_t filled = 0;
    while (filled < byte_count) {
        const ssize_t got =
            pread(fd, out + filled, byte_count - filled, static_cast<off_t>(filled));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return -1;
        if (got == 0) break;
        filled += static_cast<std::size_t>(got);
    }
    return static_cast<ssize_t>(filled);
}

}  // namespace kiln
