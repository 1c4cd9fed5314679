// SPDX-License-Identifier: Apache-2.0
#include "server/store/blob_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <memory>

#include "server/base/error.h"
#include "server/base/sha256.h"
#include "server/store/bounds.h"
#include "server/store/incoming_blob.h"

namespace kiln {

namespace {

constexpr std::string_view kTemporaryPrefix = ".tmp.";

constexpr int kDirectoryFlags = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;
// O_NONBLOCK: a FIFO in place of an entry must not hold the reader.
constexpr int kReadFlags = O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;

struct CloseDirectory {
    void operator()(DIR* directory) const { closedir(directory); }
};
using Directory = std::unique_ptr<DIR, CloseDirectory>;

// A new description, so that walks from several threads do not share one position.
Directory open_directory(int parent, const char* name) {
    FileDescriptor fd(openat(parent, name, kDirectoryFlags));
    if (!fd) return nullptr;
    Directory directory(fdopendir(fd.get()));
    if (directory) fd.release();
    return directory;
}

bool means_absent(int code) {
    return code == ENOENT || code == ENOTDIR || code == ELOOP || code == ENXIO || code == EISDIR;
}

std::string unique_suffix() {
    static std::atomic<std::uint64_t> counter{0};
    return std::to_string(getpid()) + "." + std::to_string(counter++);
}

bool same_time(const timespec& a, const timespec& b) {
    return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

// A writer holds a lock on its temporary file, and the kernel drops the lock with the process,
// however it ends: a temporary file that can be locked belongs to nobody. (Process ids would lie
// between containers, ages between clocks.)
void remove_if_abandoned(int folder, const char* name) {
    FileDescriptor file(openat(folder, name, kReadFlags));
    struct stat status {};
    if (!file || fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) return;
    if (flock(file.get(), LOCK_EX | LOCK_NB) == 0) unlinkat(folder, name, 0);
}

// Unlinks the temporary file unless it was renamed.
struct TemporaryName {
    int folder;
    const std::string& name;
    bool renamed = false;
    ~TemporaryName() {
        if (!renamed) unlinkat(folder, name.c_str(), 0);
    }
};

}  // namespace

BlobFolder::BlobFolder(const std::string& directory) : root_path_(directory + "/cas.v1") {
    make_private_directory(root_path_);
    root_ = FileDescriptor(::open(root_path_.c_str(), kDirectoryFlags));
    if (!root_) throw_errno("open", root_path_);
    static constexpr char kDigits[] = "0123456789abcdef";
    // All of them at once, durable before the first put: a put then syncs one directory only.
    for (int i = 0; i < 256; ++i) {
        const char name[3] = {kDigits[i >> 4], kDigits[i & 15], '\0'};
        if (mkdirat(root_.get(), name, S_IRWXU) != 0 && errno != EEXIST)
            throw_errno("mkdir", root_path_ + "/" + name);
    }
    const std::string quarantine_path = root_path_ + "/quarantine";
    if (mkdirat(root_.get(), "quarantine", S_IRWXU) != 0 && errno != EEXIST)
        throw_errno("mkdir", quarantine_path);
    quarantine_ = FileDescriptor(openat(root_.get(), "quarantine", kDirectoryFlags));
    if (!quarantine_) throw_errno("open", quarantine_path);
    if (fsync(root_.get()) != 0) throw_errno("fsync", root_path_);
}

std::string BlobFolder::path_of(const std::string& digest) const {
    return root_path_ + "/" + digest.substr(0, 2) + "/" + digest;
}

FileDescriptor BlobFolder::shard(const std::string& digest) const {
    return FileDescriptor(openat(root_.get(), digest.substr(0, 2).c_str(), kDirectoryFlags));
}

// Somebody may have removed the folder while we run.
FileDescriptor BlobFolder::make_shard(const std::string& digest) const {
    FileDescriptor folder = shard(digest);
    if (!folder && errno == ENOENT) {
        if (mkdirat(root_.get(), digest.substr(0, 2).c_str(), S_IRWXU) != 0 && errno != EEXIST)
            throw_errno("mkdir", path_of(digest));
        if (fsync(root_.get()) != 0) throw_errno("fsync", root_path_);
        folder = shard(digest);
    }
    if (!folder) throw_errno("open the folder of", path_of(digest));
    return folder;
}

BlobFolder::Content BlobFolder::read(const std::string& digest, std::uint64_t bytes_max) const {
    Content content;
    const FileDescriptor folder = shard(digest);
    if (!folder && means_absent(errno)) return content;
    if (!folder) throw_errno("open the folder of", path_of(digest));
    const FileDescriptor file(openat(folder.get(), digest.c_str(), kReadFlags));
    if (!file && means_absent(errno)) return content;
    if (!file) throw_errno("open", path_of(digest));
    struct stat status {};
    if (fstat(file.get(), &status) != 0) throw_errno("fstat", path_of(digest));
    if (!S_ISREG(status.st_mode)) return content;
    if (static_cast<std::uint64_t>(status.st_size) > bytes_max) return content;
    content.bytes.resize(static_cast<std::size_t>(status.st_size));
    const ssize_t got = read_from_start(file.get(), content.bytes.data(), content.bytes.size());
    if (got < 0) throw_errno("read", path_of(digest));
    content.bytes.resize(static_cast<std::size_t>(got));
    content.inode = status.st_ino;
    content.verdict = sha256_hex(content.bytes) == digest ? Verdict::good : Verdict::wrong;
    if (content.verdict == Verdict::wrong) content.bytes.clear();
    return content;
}

std::optional<std::uint64_t> BlobFolder::size(const std::string& digest) const {
    const FileDescriptor folder = shard(digest);
    if (!folder && means_absent(errno)) return std::nullopt;
    if (!folder) throw_errno("open the folder of", path_of(digest));
    struct stat status {};
    if (fstatat(folder.get(), digest.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0) {
        if (!S_ISREG(status.st_mode)) return std::nullopt;
        return static_cast<std::uint64_t>(status.st_size);
    }
    if (means_absent(errno)) return std::nullopt;
    throw_errno("stat", path_of(digest));
}

FileDescriptor BlobFolder::open(const std::string& digest) const {
    const FileDescriptor folder = shard(digest);
    if (!folder) return {};
    FileDescriptor file(openat(folder.get(), digest.c_str(), kReadFlags));
    struct stat status {};
    if (!file || fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) return {};
    return file;
}

void BlobFolder::touch(const std::string& digest) const {
    const FileDescriptor folder = shard(digest);
    if (folder) utimensat(folder.get(), digest.c_str(), nullptr, AT_SYMLINK_NOFOLLOW);
}

FileDescriptor BlobFolder::make_temporary(const FileDescriptor& folder, std::string& name) const {
    for (;;) {
        name = std::string(kTemporaryPrefix) + unique_suffix();
        FileDescriptor file(openat(folder.get(), name.c_str(),
                                   O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                                   S_IRUSR | S_IWUSR));
        // Another process-id namespace may use the same name.
        if (!file && errno == EEXIST) continue;
        if (!file) throw_errno("create", root_path_ + "/…/" + name);
        // A cleaner that got hold of it between these two lines has removed it, or is about to.
        struct stat status {};
        if (flock(file.get(), LOCK_EX | LOCK_NB) == 0 && fstat(file.get(), &status) == 0 &&
            status.st_nlink == 1)
            return file;
        unlinkat(folder.get(), name.c_str(), 0);
    }
}

void BlobFolder::write(const std::string& digest, std::string_view bytes) const {
    const FileDescriptor folder = make_shard(digest);
    std::string name;
    const FileDescriptor file = make_temporary(folder, name);
    TemporaryName temporary{folder.get(), name};
    if (!write_all(file.get(), bytes)) throw_errno("write", path_of(digest));
    // After a failed fsync the kernel may have dropped the pages: it is final, never retried.
    if (fsync(file.get()) != 0) throw_errno("fsync", path_of(digest));
    move_into_place(folder.get(), name, folder, digest);
    temporary.renamed = true;
}

void BlobFolder::move_into_place(int from, const std::string& name, const FileDescriptor& folder,
                                 const std::string& digest) const {
    if (renameat(from, name.c_str(), folder.get(), digest.c_str()) != 0) {
        // A directory stands in the way: the one thing that rename does not replace.
        const int code = errno;
        if (code == EISDIR) quarantine(digest, std::nullopt);
        errno = code;
        if (code != EISDIR || renameat(from, name.c_str(), folder.get(), digest.c_str()) != 0)
            throw_errno("rename", path_of(digest));
    }
    if (fsync(folder.get()) != 0) throw_errno("fsync the folder of", path_of(digest));
}

// In the first shard, where walks find it if this process ends before it has a name.
std::unique_ptr<IncomingBlob> BlobFolder::receive() const {
    FileDescriptor folder = make_shard("00");
    std::string name;
    FileDescriptor file = make_temporary(folder, name);
    return std::make_unique<IncomingBlob>(std::move(folder), std::move(file), std::move(name));
}

void BlobFolder::keep(IncomingBlob& blob) const {
    blob.seal();
    const std::string digest = blob.digest();
    move_into_place(blob.folder_.get(), blob.name_, make_shard(digest), digest);
    blob.name_.clear();
}

void BlobFolder::sync(const std::string& digest) const {
    const FileDescriptor folder = make_shard(digest);
    if (fsync(folder.get()) != 0) throw_errno("fsync the folder of", path_of(digest));
}

bool BlobFolder::quarantine(const std::string& digest, std::optional<ino_t> inode) const {
    const FileDescriptor folder = shard(digest);
    struct stat status {};
    if (!folder || fstatat(folder.get(), digest.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0)
        return false;
    if (inode && *inode != status.st_ino) return false;  // somebody has put it afresh meanwhile
    const std::string name = digest + "." + unique_suffix();
    if (renameat(folder.get(), digest.c_str(), quarantine_.get(), name.c_str()) != 0) return false;
    trim_quarantine();
    return true;
}

void BlobFolder::trim_quarantine() const {
    std::vector<std::pair<timespec, std::string>> files;
    const Directory directory = open_directory(root_.get(), "quarantine");
    if (!directory) return;
    while (const dirent* item = readdir(directory.get())) {
        struct stat status {};
        if (fstatat(quarantine_.get(), item->d_name, &status, AT_SYMLINK_NOFOLLOW) == 0 &&
            !S_ISDIR(status.st_mode))
            files.emplace_back(status.st_ctim, item->d_name);
    }
    if (files.size() <= kQuarantineFilesMax) return;
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
        return std::tie(a.first.tv_sec, a.first.tv_nsec, a.second) <
               std::tie(b.first.tv_sec, b.first.tv_nsec, b.second);
    });
    for (std::size_t i = 0; i < files.size() - kQuarantineFilesMax; ++i)
        unlinkat(quarantine_.get(), files[i].second.c_str(), 0);
}

void BlobFolder::list_shard(const std::string& name, std::vector<BlobEntry>& entries) const {
    const Directory directory = open_directory(root_.get(), name.c_str());
    if (!directory) {
        if (means_absent(errno)) return;
        throw_errno("open", root_path_ + "/" + name);
    }
    const int folder = dirfd(directory.get());
    while (const dirent* item = readdir(directory.get())) {
        const std::string_view file = item->d_name;
        if (file.starts_with(kTemporaryPrefix)) remove_if_abandoned(folder, item->d_name);
        if (!is_sha256_hex(file) || file.substr(0, 2) != name) continue;
        struct stat status {};
        if (fstatat(folder, item->d_name, &status, AT_SYMLINK_NOFOLLOW) != 0) continue;
        if (!S_ISREG(status.st_mode)) continue;
        entries.push_back(
            {std::string(file), static_cast<std::uint64_t>(status.st_size), status.st_mtim});
    }
}

std::vector<BlobEntry> BlobFolder::list() const {
    std::vector<BlobEntry> entries;
    static constexpr char kDigits[] = "0123456789abcdef";
    for (int i = 0; i < 256; ++i)
        list_shard(std::string{kDigits[i >> 4], kDigits[i & 15]}, entries);
    return entries;
}

bool BlobFolder::remove(const BlobEntry& entry) const {
    const FileDescriptor folder = shard(entry.digest);
    if (!folder) return means_absent(errno);
    struct stat status {};
    if (fstatat(folder.get(), entry.digest.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0)
        return errno == ENOENT;
    if (!same_time(status.st_mtim, entry.used)) return false;
    return unlinkat(folder.get(), entry.digest.c_str(), 0) == 0 || errno == ENOENT;
}

}  // namespace kiln
