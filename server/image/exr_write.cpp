// SPDX-License-Identifier: Apache-2.0
#include <ImathVec.h>
#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <half.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <mutex>
#include <thread>

#include "server/base/error.h"
#include "server/image/codec.h"

namespace kiln::codec {
namespace {

constexpr float kHalfMax = 65504.0F;   // largest finite binary16
constexpr std::size_t kZipLines = 16;  // scan lines that EXR's ZIP compresses as one block
// OpenEXR's own default, named here so that equal tables give equal bytes whatever the process has
// set.
constexpr int kZipLevel = 4;
// From here on compression takes tenths of a second, and threads are worth their start.
constexpr std::size_t kThreadedValues = std::size_t{1} << 20U;

class StringStream : public Imf::OStream {
  public:
    explicit StringStream(std::string& out) : Imf::OStream("memory"), out_(out) {}
    void write(const char data[], int byte_count) override {
        const auto n = static_cast<std::size_t>(byte_count);
        if (position_ + n > out_.size()) out_.resize(position_ + n);
        std::memcpy(out_.data() + position_, data, n);
        position_ += n;
    }
    std::uint64_t tellp() override { return position_; }
    // OpenEXR seeks back to fill in its table of line offsets.
    void seekp(std::uint64_t position) override { position_ = position; }

  private:
    std::string& out_;
    std::size_t position_ = 0;
};

// OpenEXR compresses blocks on a pool that its process shares. It is made once and kept, since
// taking it away would race with another encode(); the bytes do not depend on it.
int thread_count_for(const Table& table, unsigned asked) {
    if (table.width * table.height * table.planes.size() < kThreadedValues || asked == 1) return 0;
    static std::once_flag once;
    static unsigned pool = 0;
    std::call_once(once, [] {
        pool = std::clamp(std::thread::hardware_concurrency(), 1U, 64U);
        Imf::setGlobalThreadCount(static_cast<int>(pool));
    });
    return static_cast<int>(asked == 0 ? pool : std::min(asked, pool));
}

std::vector<std::string> channel_names(const Table& table) {
    if (table.planes.size() > 4) return table.channels;
    const std::vector<std::string> rgba = {"R", "G", "B", "A"};
    return {rgba.begin(), rgba.begin() + static_cast<std::ptrdiff_t>(table.planes.size())};
}

// Fills lines [y, y + lines) of one channel, and counts what did not fit.
void to_half(const Table& table, std::size_t channel, std::size_t y, std::size_t lines,
             std::vector<half>& out, Encoded& account) {
    const float* in = table.planes[channel].data() + y * table.width;
    double worst = account.quantisation_max[channel];
    std::uint64_t clamped = 0;
    for (std::size_t i = 0; i < lines * table.width; ++i) {
        if (std::abs(in[i]) > kHalfMax) {
            out[i] = half(std::copysign(kHalfMax, in[i]));
            ++clamped;
        } else {
            out[i] = half(in[i]);  // to nearest, ties to even
            worst = std::max(worst, std::abs(static_cast<double>(float(out[i])) - double(in[i])));
        }
    }
    account.quantisation_max[channel] = worst;
    account.clamped[channel] += clamped;
}

Imf::Slice slice(Imf::PixelType type, const void* data, std::size_t y, const Table& table,
                 std::size_t lines) {
    const std::size_t size = type == Imf::HALF ? sizeof(half) : sizeof(float);  // or UINT
    return Imf::Slice::Make(type, data, Imath::V2i(0, static_cast<int>(y)),
                            static_cast<std::int64_t>(table.width),
                            static_cast<std::int64_t>(lines), size, size * table.width);
}

void write_half(Imf::OutputFile& file, const Table& table, const std::vector<std::string>& names,
                std::size_t block_lines, Encoded& account,
                const std::function<void()>& between_lines) {
    std::vector<std::vector<half>> block(names.size(),
                                         std::vector<half>(block_lines * table.width));
    for (std::size_t y = 0; y < table.height; y += block_lines) {
        const std::size_t lines = std::min(block_lines, table.height - y);
        Imf::FrameBuffer frame;
        for (std::size_t c = 0; c < names.size(); ++c) {
            to_half(table, c, y, lines, block[c], account);
            frame.insert(names[c], slice(Imf::HALF, block[c].data(), y, table, lines));
        }
        between_lines();
        file.setFrameBuffer(frame);
        file.writePixels(static_cast<int>(lines));
    }
}

void write_float(Imf::OutputFile& file, const Table& table, const std::vector<std::string>& names,
                 std::size_t block_lines, const std::function<void()>& between_lines) {
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < names.size(); ++c)
        frame.insert(names[c], slice(Imf::FLOAT, table.planes[c].data(), 0, table, table.height));
    file.setFrameBuffer(frame);
    for (std::size_t y = 0; y < table.height; y += block_lines) {
        between_lines();
        file.writePixels(static_cast<int>(std::min(block_lines, table.height - y)));
    }
}

/// Three planes as one of packed integers, and a fourth as integers beside it.
void write_rgb9e5(Imf::OutputFile& file, const Table& table, std::size_t block_lines,
                  Encoded& account, const std::function<void()>& between_lines) {
    std::vector<std::uint32_t> packed(block_lines * table.width), origin(packed.size());
    for (std::size_t y = 0; y < table.height; y += block_lines) {
        const std::size_t lines = std::min(block_lines, table.height - y);
        pack_rgb9e5(table, y, lines, packed.data(), account);
        Imf::FrameBuffer frame;
        frame.insert(kRgb9e5Channel, slice(Imf::UINT, packed.data(), y, table, lines));
        if (table.planes.size() > 3) {
            const float* from = table.planes[3].data() + y * table.width;
            std::transform(from, from + lines * table.width, origin.begin(),
                           [](float value) { return static_cast<std::uint32_t>(value); });
            frame.insert(table.channels[3], slice(Imf::UINT, origin.data(), y, table, lines));
        }
        between_lines();
        file.setFrameBuffer(frame);
        file.writePixels(static_cast<int>(lines));
    }
}

Imf::PixelType type_of(PixelType pixel) {
    return pixel == PixelType::half     ? Imf::HALF
           : pixel == PixelType::rgb9e5 ? Imf::UINT
                                        : Imf::FLOAT;
}

std::vector<std::string> stored_names(const Table& table, PixelType pixel) {
    if (pixel != PixelType::rgb9e5) return channel_names(table);
    std::vector<std::string> names = {kRgb9e5Channel};
    if (table.planes.size() > 3) names.push_back(table.channels[3]);
    return names;
}

}  // namespace

Encoded encode_exr(const Table& table, PixelType pixel, const Metadata& metadata,
                   unsigned asked_threads, const std::function<void()>& between_lines) {
    if (pixel == PixelType::uint8 || pixel == PixelType::uint16)
        throw Error("cannot_encode", "EXR holds half or float, no 8-bit or 16-bit integers");
    const bool as_half = pixel == PixelType::half;
    const auto names = stored_names(table, pixel);

    Imf::Header header(static_cast<int>(table.width), static_cast<int>(table.height));
    header.compression() = Imf::ZIP_COMPRESSION;
    header.zipCompressionLevel() = kZipLevel;
    for (const auto& name : names) {
        // A longer name would raise a flag that old readers refuse.
        if (name.size() > 31) throw Error("cannot_encode", "channel name too long: " + name);
        header.channels().insert(name, Imf::Channel(type_of(pixel)));
    }
    for (const auto& [key, value] : metadata) header.insert(key, Imf::StringAttribute(value));

    Encoded result;
    result.extension = "exr";
    result.quantisation_max.assign(table.planes.size(), 0.0);
    result.clamped.assign(table.planes.size(), 0);
    // A block that does not shrink is stored as it is, so that this is an upper bound but for the
    // header; pages never written to cost no memory.
    result.bytes.reserve(table.width * table.height * names.size() * (as_half ? 2 : 4) +
                         table.height * 16 + 65536);
    try {
        StringStream stream(result.bytes);
        const int threads = thread_count_for(table, asked_threads);
        Imf::OutputFile file(stream, header, threads);
        // A few ZIP blocks for every thread: enough to keep them busy.
        const std::size_t block_lines =
            4 * kZipLines * static_cast<std::size_t>(std::max(1, threads));
        if (pixel == PixelType::rgb9e5)
            write_rgb9e5(file, table, block_lines, result, between_lines);
        else if (as_half)
            write_half(file, table, names, block_lines, result, between_lines);
        else
            write_float(file, table, names, block_lines, between_lines);
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        throw Error("cannot_encode", std::string("OpenEXR: ") + e.what());
    }
    return result;
}

}  // namespace kiln::codec
