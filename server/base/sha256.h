// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace kiln {

/// SHA-256 over a stream of bytes.
class Sha256 {
  public:
    Sha256();
    ~Sha256();
    Sha256(const Sha256&) = delete;
    Sha256& operator=(const Sha256&) = delete;

    void update(const void* data, std::size_t byte_count);
    void update(std::string_view text) { update(text.data(), text.size()); }
    /// 64 lower-case hex digits. The object is spent afterwards.
    std::string hex();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// 64 lower-case hex digits of SHA-256(bytes).
std::string sha256_hex(std::string_view bytes);

/// True for exactly 64 lower-case hex digits: the only form in which an id may reach a path or a
/// query.
bool is_sha256_hex(std::string_view text);

}  // namespace kiln
