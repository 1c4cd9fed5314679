// SPDX-License-Identifier: Apache-2.0
#include "server/base/sha256.h"

#include <openssl/evp.h>

#include <array>

#include "server/base/error.h"

namespace kiln {

struct Sha256::State {
    EVP_MD_CTX* context = EVP_MD_CTX_new();
    ~State() { EVP_MD_CTX_free(context); }
};

namespace {
void check(int ok, const char* call) {
    if (ok != 1) throw Error("internal", std::string(call) + " failed");
}
}  // namespace

Sha256::Sha256() : state_(std::make_unique<State>()) {
    check(state_->context != nullptr, "EVP_MD_CTX_new");
    check(EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr), "EVP_DigestInit_ex");
}
Sha256::~Sha256() = default;

void Sha256::update(const void* data, std::size_t byte_count) {
    check(EVP_DigestUpdate(state_->context, data, byte_count), "EVP_DigestUpdate");
}

std::string Sha256::hex() {
    std::array<unsigned char, 32> digest{};
    unsigned int length = 0;
    check(EVP_DigestFinal_ex(state_->context, digest.data(), &length), "EVP_DigestFinal_ex");
    static constexpr char kDigits[] = "0123456789abcdef";
    std::string text;
    text.reserve(2 * digest.size());
    for (unsigned char byte : digest) {
        text += kDigits[byte >> 4];
        text += kDigits[byte & 15];
    }
    return text;
}

std::string sha256_hex(std::string_view bytes) {
    Sha256 hash;
    hash.update(bytes);
    return hash.hex();
}

bool is_sha256_hex(std::string_view text) {
    if (text.size() != 64) return false;
    for (char c : text)
        if (!((c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'))) return false;
    return true;
}

}  // namespace kiln
