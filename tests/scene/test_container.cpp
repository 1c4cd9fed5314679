// SPDX-License-Identifier: Apache-2.0
#include "server/scene/container.h"

#include <gtest/gtest.h>

#include "tests/scene/scenes.h"

namespace kiln {
namespace {

TEST(Container, TakesABinaryApart) {
    const std::string bytes = test::glb_of("{\"a\":1}", "12345");
    const Container container = open_container(bytes);
    EXPECT_TRUE(container.is_glb);
    EXPECT_EQ(container.json, "{\"a\":1} ");
    EXPECT_EQ(container.binary, std::string_view("12345\0\0\0", 8));
    EXPECT_EQ(open_container("{}").json, "{}");
    EXPECT_FALSE(open_container("{}").is_glb);
}

}  // namespace
}  // namespace kiln
