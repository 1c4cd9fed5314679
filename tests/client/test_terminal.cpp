// SPDX-License-Identifier: Apache-2.0
#include "client/terminal.h"

#include <gtest/gtest.h>

namespace kiln::client {
namespace {

TEST(Terminal, text_of_others_cannot_steer_it) {
    EXPECT_EQ(printable("plain, tab\there"), "plain, tab\\x09here");
    EXPECT_EQ(printable("\x1b[31m\x7f\r\n"), "\\x1B[31m\\x7F\\x0D\\x0A");
    EXPECT_EQ(printable("\xc2\x9b"), "\\x9B");  // U+009B, the one-character form of ESC [
    EXPECT_EQ(printable("×Ω\xc2\xa0"), "×Ω\xc2\xa0");
}

TEST(Terminal, columns_line_up_by_characters_not_bytes) {
    EXPECT_EQ(columns({{"", "a", "bb"}, {"é×", "100", ""}}),
              (std::vector<std::string>{"      a  bb", "é×  100"}));
}

TEST(Terminal, figures) {
    EXPECT_EQ(format_size(256, 1), "256 x 1");
    EXPECT_EQ(format_size(4, 15, 3), "4 x 15 (3 slices of 4 x 5)");
    EXPECT_EQ(format_bytes(999), "999 B");
    EXPECT_EQ(format_bytes(197400), "197 kB");
    EXPECT_EQ(format_bytes(4300000000), "4.3 GB");
    EXPECT_EQ(format_seconds(0.02134), "21.3 ms");
    EXPECT_EQ(format_seconds(0.0999), "0.1 s");
    EXPECT_EQ(format_seconds(9.94), "9.9 s");
    EXPECT_EQ(format_seconds(59.6), "60 s");
    EXPECT_EQ(format_seconds(185), "3 min 05 s");
    EXPECT_EQ(format_error(0), "0");
    EXPECT_EQ(format_error(0.000213), "2.1e-04");
}

}  // namespace
}  // namespace kiln::client
