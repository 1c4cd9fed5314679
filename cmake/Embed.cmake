# SPDX-License-Identifier: Apache-2.0
# Writes IN's bytes into OUT as a string_view named kiln::embedded::SYMBOL. Bytes go as hex escapes in
# an array, so that no byte of the text can end the literal.
file(READ ${IN} hex HEX)
string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${hex}")
string(REGEX REPLACE "(.................................................................................,)" "\\1\n" bytes "${bytes}")
file(WRITE ${OUT} "#include <string_view>
namespace kiln::embedded {
static const char bytes[] = {${bytes}'\\0'};
extern const std::string_view ${SYMBOL};
const std::string_view ${SYMBOL}{bytes, sizeof(bytes) - 1};
}
")
