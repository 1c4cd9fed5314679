// SPDX-License-Identifier: Apache-2.0
#include "server/scene/container.h"

#include <cstdint>

#include "server/spec/spec.h"

namespace kiln {

namespace {

// glTF 2.0 specification, 4.4: little-endian magic, version, length, then chunks of length, type.
constexpr std::string_view kMagic = "glTF";
constexpr std::size_t kHeaderBytes = 12, kChunkHeaderBytes = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

[[noreturn]] void refuse(std::size_t at, const std::string& message) {
    throw Malformed("the binary glTF cannot be read: byte " + std::to_string(at) + ": " + message,
                    {{"", "byte " + std::to_string(at) + ": " + message}});
}

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i)
        word |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
    return word;
}

}  // namespace

Container open_container(std::string_view bytes) {
    if (!bytes.starts_with(kMagic)) return {bytes, {}, false};
    if (bytes.size() < kHeaderBytes + kChunkHeaderBytes)
        refuse(bytes.size(), "it ends within its header");
    if (const auto version = word_at(bytes, 4); version != 2)
        refuse(4, "version " + std::to_string(version) + "; allowed: 2");
    if (const auto length = word_at(bytes, 8); length != bytes.size())
        refuse(8, "it says that it has " + std::to_string(length) + " bytes, and has " +
                      std::to_string(bytes.size()));
    Container container{{}, {}, true};
    std::size_t chunk_index = 0;
    for (std::size_t at = kHeaderBytes; at < bytes.size(); ++chunk_index) {
        if (bytes.size() - at < kChunkHeaderBytes) refuse(at, "a chunk ends within its header");
        const std::size_t length = word_at(bytes, at);
        const std::uint32_t type = word_at(bytes, at + 4);
        if (length > bytes.size() - at - kChunkHeaderBytes)
            refuse(at, "a chunk of " + std::to_string(length) + " bytes goes past the end");
        const std::string_view data = bytes.substr(at + kChunkHeaderBytes, length);
        if ((chunk_index == 0) != (type == kJsonChunk))
            refuse(at + 4, chunk_index == 0 ? "the first chunk must hold JSON"
                                            : "only the first chunk may hold JSON");
        if (chunk_index == 0) container.json = data;
        if (chunk_index == 1 && type == kBinaryChunk) container.binary = data;
        at += kChunkHeaderBytes + length;
    }
    return container;
}

}  // namespace kiln
