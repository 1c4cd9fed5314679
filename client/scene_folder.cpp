// SPDX-License-Identifier: Apache-2.0
#include "client/scene_folder.h"

#include <algorithm>
#include <filesystem>

#include "client/failure.h"
#include "client/files.h"
#include "server/base/sha256.h"

namespace kiln::client {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kManifestBytesMost = 64u << 20, kFileBytesMost = std::size_t{1} << 30;

/// The file's bytes where it is there and has that SHA-256.
std::optional<std::string> whole(const std::string& path, const std::string& sha256) {
    std::error_code failed;
    if (!fs::is_regular_file(path, failed)) return std::nullopt;
    std::string bytes = read_input(path, kFileBytesMost);
    if (sha256_hex(bytes) != sha256) return std::nullopt;
    return bytes;
}

}  // namespace

SceneFolder::SceneFolder(std::string path) : path_(std::move(path)) {
    std::error_code failed;
    fs::create_directories(path_, failed);
    if (!fs::is_directory(path_, failed))
        throw Failure(Exit::usage, "cannot_write", "-o " + path_ + " is no folder");
    check_output(path_ + "/manifest.json");
    if (fs::is_regular_file(path_ + "/manifest.json", failed))
        files_ = read_manifest(read_input(path_ + "/manifest.json", kManifestBytesMost));
}

std::optional<SceneBytes> SceneFolder::find(const std::string& id,
                                            const std::string& engine) const {
    for (const SceneFile& file : files_) {
        if (file.id != id || file.engine != engine || engine.empty()) continue;
        auto image = whole(path_ + "/" + file.file, file.sha256);
        auto sidecar = file.sidecar.empty()
                           ? std::optional<std::string>("")
                           : whole(path_ + "/" + file.sidecar, file.sidecar_sha256);
        if (image && sidecar) return SceneBytes{std::move(*image), std::move(*sidecar)};
    }
    return std::nullopt;
}

void SceneFolder::write(const SceneTable& table) const {
    write(table.file.file, table.bytes.image);
    if (!table.file.sidecar.empty()) write(table.file.sidecar, table.bytes.sidecar);
}

void SceneFolder::write(const std::string& file, const std::string& bytes) const {
    write_output(path_ + "/" + file, bytes);
}

void SceneFolder::clear(const std::vector<SceneTable>& now) const {
    const auto named = [&](const std::string& name) {
        return std::any_of(now.begin(), now.end(), [&](const SceneTable& table) {
            return table.file.file == name || table.file.sidecar == name;
        });
    };
    for (const SceneFile& file : files_)
        for (const std::string& name : {file.file, file.sidecar}) {
            std::error_code ignored;
            if (!name.empty() && !named(name)) fs::remove(path_ + "/" + name, ignored);
        }
}

}  // namespace kiln::client
