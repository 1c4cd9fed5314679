// SPDX-License-Identifier: Apache-2.0
#include "client/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "client/failure.h"
#include "server/spec/settings.h"

namespace kiln::client {

namespace {

namespace fs = std::filesystem;

Failure unreadable(const std::string& path, const std::string& why) {
    return {Exit::usage, "cannot_read", "cannot read " + path + ": " + why};
}

Failure unwritable(Exit exit, const std::string& path, const std::string& why) {
    return {exit, "cannot_write", "cannot write " + path + ": " + why};
}

class Descriptor {
  public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() {
        if (number_ > STDERR_FILENO) ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int number() const { return number_; }

  private:
    int number_;
};

/// Removes the temporary file unless it was renamed into place.
class Temporary {
  public:
    explicit Temporary(std::string path) : path_(std::move(path)) {}
    ~Temporary() {
        if (!path_.empty()) ::unlink(path_.c_str());
    }
    Temporary(const Temporary&) = delete;
    Temporary& operator=(const Temporary&) = delete;
    bool rename_to(const std::string& target) {
        if (::rename(path_.c_str(), target.c_str()) != 0) return false;
        path_.clear();
        return true;
    }

  private:
    std::string path_;
};

void write_all(int descriptor, std::string_view bytes, const std::string& name) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) throw unwritable(Exit::failed, name, std::strerror(errno));
        bytes.remove_prefix(static_cast<std::size_t>(count));
    }
}

/// A symbolic link is followed: the file that it names is replaced, not the link.
std::string target_of(const std::string& path) {
    std::error_code error;
    const fs::path target = fs::canonical(path, error);
    return error ? path : target.string();
}

std::string folder_of(const std::string& path) {
    const std::string folder = fs::path(path).parent_path().string();
    return folder.empty() ? "." : folder;
}

/// Devices and pipes (/dev/null, /dev/stdout, <(…)) cannot be renamed over; they are written in
/// place.
bool is_special(const std::string& path) {
    struct stat info {};
    return ::stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

void replace_file(const std::string& path, std::string_view bytes) {
    std::string name = folder_of(path) + "/." + fs::path(path).filename().string() + ".XXXXXX";
    const Descriptor file(::mkostemp(name.data(), O_CLOEXEC));
    if (file.number() < 0) throw unwritable(Exit::failed, path, std::strerror(errno));
    Temporary temporary(name);
    const mode_t mask = ::umask(0);
    ::umask(mask);
    struct stat old {};
    const mode_t mode = ::stat(path.c_str(), &old) == 0 ? old.st_mode & 0777 : 0666 & ~mask;
    write_all(file.number(), bytes, path);
    if (::fchmod(file.number(), mode) != 0 || ::fsync(file.number()) != 0 ||
        !temporary.rename_to(path))
        throw unwritable(Exit::failed, path, std::strerror(errno));
}

}  // namespace

std::string read_input(const std::string& path, std::size_t bytes_max) {
    const std::string name = path == "-" ? "standard input" : path;
    const Descriptor file(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.number() < 0) throw unreadable(name, std::strerror(errno));
    std::string text;
    constexpr std::size_t kChunk = 1 << 16;
    while (true) {
        const std::size_t size = text.size();
        text.resize(size + kChunk);
        const ssize_t count = ::read(file.number(), text.data() + size, kChunk);
        const int error = errno;
        text.resize(size + (count > 0 ? static_cast<std::size_t>(count) : 0));
        if (count < 0 && error == EINTR) continue;
        if (count < 0) throw unreadable(name, std::strerror(error));
        if (text.size() > bytes_max)
            throw unreadable(name, "it holds more than " + std::to_string(bytes_max) + " bytes");
        if (count == 0) return text;
    }
}

std::string read_job(const std::string& path, const std::vector<std::string>& settings) {
    // Far above the contract's job_bytes_max, which parse_job judges; only there so that reading
    // ends.
    constexpr std::size_t kBytesMax = 16u << 20;
    const std::string text = path.empty() ? "{}" : read_input(path, kBytesMax);
    if (settings.empty()) return text;
    apply_settings(text, {});  // a document that cannot be read is the document's fault …
    try {
        return apply_settings(text, settings);
    } catch (const Malformed& error) {  // … and this one the argument's
        throw Failure(Exit::usage, "bad_setting", std::string("--set: ") + error.what());
    }
}

void make_folder(const std::string& path) {
    std::error_code error;
    fs::create_directories(path, error);
    if (!error && !fs::is_directory(path, error))
        error = std::make_error_code(std::errc::not_a_directory);
    if (error) throw unwritable(Exit::usage, path, error.message());
}

void check_output(const std::string& path) {
    if (path == "-") {
        if (::isatty(STDOUT_FILENO) == 1)
            throw unwritable(Exit::usage, "the image to a terminal", "redirect standard output");
        return;
    }
    const std::string target = target_of(path);
    if (path.empty() || path.back() == '/' || fs::is_directory(target))
        throw unwritable(Exit::usage, path, "it is a folder; name a file");
    if (is_special(target)) return;
    const std::string folder = folder_of(target);
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        throw unwritable(Exit::usage, path, "folder " + folder + ": " + std::strerror(errno));
}

void write_output(const std::string& path, std::string_view bytes) {
    if (path == "-") return write_all(STDOUT_FILENO, bytes, "standard output");
    const std::string target = target_of(path);
    if (!is_special(target)) return replace_file(target, bytes);
    const Descriptor file(::open(target.c_str(), O_WRONLY | O_CLOEXEC));
    if (file.number() < 0) throw unwritable(Exit::failed, path, std::strerror(errno));
    write_all(file.number(), bytes, path);
}

std::string extension_of(const std::string& path) {
    std::string extension = fs::path(path).extension().string();
    if (!extension.empty()) extension.erase(0, 1);
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

void keep_opencl_programs() {
    if (std::getenv("POCL_CACHE_DIR") != nullptr) return;
    const char* cache = std::getenv("XDG_CACHE_HOME");
    const char* home = std::getenv("HOME");
    fs::path folder;
    if (cache != nullptr && *cache == '/')
        folder = cache;
    else if (home != nullptr && *home == '/')
        folder = fs::path(home) / ".cache";
    else
        return;
    folder = folder / "kiln" / "pocl";
    std::error_code error;
    fs::create_directories(folder.parent_path(), error);
    if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) return;
    ::setenv("POCL_CACHE_DIR", folder.c_str(), 1);
}

}  // namespace kiln::client
