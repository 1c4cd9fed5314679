// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/types.h>

#include <string>
#include <string_view>

namespace kiln {

/// Owns one file descriptor.
class FileDescriptor {
  public:
    FileDescriptor() = default;
    explicit FileDescriptor(int fd) : fd_(fd) {}
    FileDescriptor(FileDescriptor&& other) noexcept : fd_(other.release()) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept;
    ~FileDescriptor();

    int get() const { return fd_; }
    int release();
    explicit operator bool() const { return fd_ >= 0; }

  private:
    int fd_ = -1;
};

/// Throws Error("store_failed") "CALL PATH: reason" from errno.
[[noreturn]] void throw_errno(const char* call, const std::string& path);

/// Makes `path` and its missing parents with mode 0700 and makes their names durable. An existing
/// directory keeps its mode. Throws Error("store_failed").
void make_private_directory(const std::string& path);

/// All of `bytes`, or errno and false.
bool write_all(int fd, std::string_view bytes);

/// At most `byte_count` bytes from the start; fewer at the end of the file. Negative with errno
/// set.
ssize_t read_from_start(int fd, char* out, std::size_t byte_count);

}  // namespace kiln
