// SPDX-License-Identifier: Apache-2.0
#include "server/compute/kernel_digest.h"

#include "server/base/sha256.h"

namespace kiln {

namespace embedded {
extern const std::string_view kernel_text;
}

std::string_view kernel_text() { return embedded::kernel_text; }

const std::string& kernel_digest() {
    static const std::string digest = sha256_hex(embedded::kernel_text);
    return digest;
}

}  // namespace kiln
