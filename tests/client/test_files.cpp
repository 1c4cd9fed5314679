// SPDX-License-Identifier: Apache-2.0
#include "client/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>

#include "client/failure.h"

namespace kiln::client {
namespace {

namespace fs = std::filesystem;

class Files : public testing::Test {
  protected:
    void SetUp() override {
        std::string name = std::string(KILN_BINARY_DIR) + "/client-files-XXXXXX";
        ASSERT_NE(mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    std::ptrdiff_t file_count() const {
        return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
    }

  private:
    fs::path folder_;
};

TEST_F(Files, what_is_written_is_read_and_nothing_else_stays) {
    const std::string bytes("\0\n\xff", 3);
    write_output(path("a"), bytes);
    write_output(path("a"), bytes + bytes);
    EXPECT_EQ(read_input(path("a"), 100), bytes + bytes);
    EXPECT_EQ(file_count(), 1);
}

TEST_F(Files, the_bound_of_a_read) {
    write_output(path("a"), std::string(200000, 'x'));
    EXPECT_EQ(read_input(path("a"), 200000).size(), 200000u);
    EXPECT_THROW(read_input(path("a"), 199999), Failure);
}

TEST_F(Files, a_write_that_fails_leaves_no_temporary_file) {
    fs::create_directories(path("a/b"));  // a folder that is not empty cannot be renamed over
    EXPECT_THROW(write_output(path("a"), "x"), Failure);
    EXPECT_EQ(file_count(), 1);
}

TEST_F(Files, the_umask_decides_for_a_new_file) {
    const mode_t before = umask(027);
    write_output(path("a"), "x");
    umask(before);
    struct stat info {};
    ASSERT_EQ(stat(path("a").c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777, 0640u);
}

TEST_F(Files, extensions) {
    EXPECT_EQ(extension_of("a.b/c.EXR"), "exr");
    EXPECT_EQ(extension_of("a.b/c"), "");
    EXPECT_EQ(extension_of("-"), "");
}

TEST_F(Files, compiled_programs_are_kept_in_a_private_folder) {
    unsetenv("POCL_CACHE_DIR");
    setenv("XDG_CACHE_HOME", path("cache").c_str(), 1);
    keep_opencl_programs();
    const std::string folder = path("cache/kiln/pocl");
    EXPECT_STREQ(getenv("POCL_CACHE_DIR"), folder.c_str());
    struct stat info {};
    ASSERT_EQ(stat(folder.c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777, 0700u);

    setenv("POCL_CACHE_DIR", "/elsewhere", 1);
    keep_opencl_programs();
    EXPECT_STREQ(getenv("POCL_CACHE_DIR"), "/elsewhere");
    unsetenv("POCL_CACHE_DIR");
}

}  // namespace
}  // namespace kiln::client
