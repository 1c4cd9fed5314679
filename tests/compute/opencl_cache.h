// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <string>

namespace kiln::test {

/// A cache of PoCL's for this process, until its end: PoCL reads the name of the folder once.
inline void use_own_opencl_cache() {
    struct Folder {
        std::string name = KILN_BINARY_DIR "/opencl-cache-XXXXXX";
        Folder() {
            EXPECT_NE(mkdtemp(name.data()), nullptr);
            setenv("POCL_CACHE_DIR", name.c_str(), 1);
        }
        ~Folder() {
            std::error_code ignored;
            std::filesystem::remove_all(name, ignored);
        }
    };
    static const Folder folder;
}

/// One for all processes of a build, where most of the programs are compiled by several.
inline void share_opencl_cache() { setenv("POCL_CACHE_DIR", KILN_BINARY_DIR "/opencl-cache", 0); }

}  // namespace kiln::test
