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

TEST(Container, DataUris) {
    // RFC 4648, section 10.
    const std::pair<const char*, const char*> vectors[] = {{"", ""},
                                                           {"Zg==", "f"},
                                                           {"Zm8=", "fo"},
                                                           {"Zm9v", "foo"},
                                                           {"Zm9vYg==", "foob"},
                                                           {"Zm9vYmE=", "fooba"},
                                                           {"Zm9vYmFy", "foobar"}};
    for (const auto& [code, text] : vectors)
        EXPECT_EQ(data_uri_bytes(std::string("data:x/y;base64,") + code), text);
    EXPECT_EQ(data_uri_bytes("data:;base64,Zm8"), "fo");
    for (const char* wrong : {"x.png", "data:,foo", "data:;base64,Z", "data:;base64,Zm9$",
                              "data:;base64,Zm 9", "data:;base64"})
        EXPECT_EQ(data_uri_bytes(wrong), std::nullopt) << wrong;
}

}  // namespace
}  // namespace kiln
