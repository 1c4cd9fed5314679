// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "client/scene.h"

namespace kiln::client {

/// What an earlier bake of a scene left in its folder, and where this one writes.
class SceneFolder {
  public:
    /// Makes the folder. Throws Failure(usage) where it is none or cannot be written.
    explicit SceneFolder(std::string path);
    /// The bytes of a table that are there, whole, and made by `engine`.
    std::optional<SceneBytes> find(const std::string& id, const std::string& engine) const;
    void write(const SceneTable& table) const;
    void write(const std::string& file, const std::string& bytes) const;
    /// Removes what the manifest before named and this one does not.
    void clear(const std::vector<SceneTable>& now) const;

  private:
    std::string path_;
    std::vector<SceneFile> files_;
};

}  // namespace kiln::client
