// SPDX-License-Identifier: Apache-2.0
#include <ImathVec.h>
#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfStringAttribute.h>
#include <ImfVersion.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <set>
#include <sstream>

#include "server/base/error.h"
#include "server/image/codec.h"

namespace kiln::codec {
namespace {

constexpr const char* kOriginChannel = "origin";

[[noreturn]] void refuse(const std::string& why) { throw Error("cannot_decode", "EXR: " + why); }

/// The header read by hand: OpenEXR 3.1 sees a file only after this has bounded what it will
/// allocate (deep and multi-part files are where its known memory errors are, CVE-2023-5841).
class HeaderScan {
  public:
    explicit HeaderScan(std::string_view bytes) : bytes_(bytes) {}

    void check() {
        read_version();
        while (true) {
            const std::string name = word();
            if (name.empty()) break;
            const std::string type = word();
            const std::uint32_t size = u32();
            if (size > bytes_.size() - at_) refuse("attribute " + quoted(name) + " is cut short");
            const std::size_t end = at_ + size;
            if (!seen_.insert(name).second) refuse("attribute " + quoted(name) + " is there twice");
            take(name, type, size);
            at_ = end;
        }
        if (width_ == 0 || value_bytes_ == 0 || !compression_)
            refuse("the header lacks dataWindow, channels or compression");
        check_decode_size(width_, height_, channels_, value_bytes_, bytes_.size());
    }

  private:
    // Names come from the file: no control bytes on somebody's terminal.
    static std::string quoted(const std::string& name) {
        std::string out = name;
        for (char& c : out)
            if (c < ' ' || c > '~') c = '?';
        return '"' + out + '"';
    }

    std::uint32_t u32() {
        if (bytes_.size() - at_ < 4) refuse("the header is cut short");
        std::uint32_t value = 0;
        for (unsigned i = 0; i < 4; ++i)
            value |= std::uint32_t{static_cast<unsigned char>(bytes_[at_ + i])} << (8 * i);
        at_ += 4;
        return value;
    }

    std::string word() {
        const std::size_t end = bytes_.find('\0', at_);
        if (end == std::string_view::npos) refuse("the header is cut short");
        if (end - at_ > 255) refuse("a name in the header is longer than 255 bytes");
        std::string text(bytes_.substr(at_, end - at_));
        at_ = end + 1;
        return text;
    }

    void read_version() {
        at_ = kExrMagic.size();
        const std::uint32_t version = u32();
        if ((version & 0xFF) != 2) refuse("file format version is not 2");
        const std::uint32_t flags = version & ~0xFFU;
        if ((flags & Imf::TILED_FLAG) != 0) refuse("tiled images are not read");
        if ((flags & Imf::NON_IMAGE_FLAG) != 0) refuse("deep data is not read");
        if ((flags & Imf::MULTI_PART_FILE_FLAG) != 0) refuse("multi-part files are not read");
        if ((flags & ~std::uint32_t{Imf::LONG_NAMES_FLAG}) != 0) refuse("unknown version flags");
    }

    void take(const std::string& name, const std::string& type, std::uint32_t size) {
        if (name == "dataWindow") {
            if (type != "box2i" || size != 16) refuse("dataWindow is malformed");
            std::int64_t corner[4];
            for (auto& c : corner) c = static_cast<std::int32_t>(u32());
            const std::int64_t width = corner[2] - corner[0] + 1;
            const std::int64_t height = corner[3] - corner[1] + 1;
            const auto limit = static_cast<std::int64_t>(kDecodeSideMax);
            // Far-off origins are legal, but nothing that Kiln reads has one.
            if (width < 1 || height < 1 || width > limit || height > limit ||
                std::any_of(corner, corner + 4, [&](auto c) { return c < -limit || c > limit; }))
                refuse("dataWindow is empty or larger than " + std::to_string(limit));
            width_ = static_cast<std::size_t>(width);
            height_ = static_cast<std::size_t>(height);
        } else if (name == "compression") {
            if (type != "compression" || size != 1) refuse("compression is malformed");
            if (static_cast<unsigned char>(bytes_[at_]) > Imf::ZIP_COMPRESSION)
                refuse("compression other than none, RLE, ZIPS and ZIP is not read");
            compression_ = true;
        } else if (name == "channels") {
            if (type != "chlist") refuse("channels is malformed");
            take_channels(at_ + size);
        } else if (name == "type") {
            refuse("only plain scan-line images are read");
        }
    }

    void take_channels(std::size_t end) {
        while (true) {
            const std::string name = word();
            if (at_ > end) refuse("the channel list is cut short");
            if (name.empty()) break;
            const std::uint32_t type = u32();
            u32();  // pLinear and three reserved bytes
            const std::uint32_t x_sampling = u32(), y_sampling = u32();
            if (at_ > end) refuse("the channel list is cut short");
            const bool packed = name == kRgb9e5Channel || name == kOriginChannel;
            if (type != Imf::HALF && type != Imf::FLOAT && !(type == Imf::UINT && packed))
                refuse("channel " + quoted(name) + " is neither half nor float");
            if (x_sampling != 1 || y_sampling != 1)
                refuse("channel " + quoted(name) + " is subsampled");
            if (value_bytes_ != 0 && type != type_)
                refuse("channels of different pixel types are not read");
            type_ = type;
            value_bytes_ = type == Imf::HALF ? 2 : 4;
            ++channels_;
        }
    }

    std::string_view bytes_;
    std::size_t at_ = 0;
    std::set<std::string> seen_;
    std::uint32_t type_ = 0;
    std::size_t width_ = 0, height_ = 0, channels_ = 0, value_bytes_ = 0;
    bool compression_ = false;
};

class ViewStream : public Imf::IStream {
  public:
    explicit ViewStream(std::string_view bytes) : Imf::IStream("memory"), bytes_(bytes) {}
    bool read(char data[], int byte_count) override {
        const auto n = static_cast<std::uint64_t>(std::max(byte_count, 0));
        if (byte_count < 0 || position_ > bytes_.size() || n > bytes_.size() - position_)
            throw Error("cannot_decode", "EXR: the file is cut short");
        std::memcpy(data, bytes_.data() + position_, n);
        position_ += n;
        return position_ < bytes_.size();
    }
    std::uint64_t tellg() override { return position_; }
    void seekg(std::uint64_t position) override { position_ = position; }

  private:
    std::string_view bytes_;
    std::uint64_t position_ = 0;
};

// EXR keeps channels in alphabetical order; a table's order is R, G, B, A or that of its
// quantities.
std::vector<std::string> ordered_names(const Imf::Header& header, const Metadata& metadata) {
    std::vector<std::string> names;
    for (auto i = header.channels().begin(); i != header.channels().end(); ++i)
        names.emplace_back(i.name());
    std::vector<std::string> wanted = {"R", "G", "B", "A"};
    for (const auto& [key, value] : metadata) {
        if (key != "kiln.quantities") continue;
        std::istringstream words(value);
        for (std::string word; words >> word;) wanted.push_back(word);
    }
    const auto rank = [&](const std::string& name) {
        return std::find(wanted.begin(), wanted.end(), name) - wanted.begin();
    };
    std::stable_sort(names.begin(), names.end(),
                     [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
    return names;
}

/// Packed colours, and the plane beside them.
void read_packed(Imf::InputFile& file, Table& table) {
    const Imath::Box2i window = file.header().dataWindow();
    std::vector<std::uint32_t> packed(table.width * table.height), origin(packed.size());
    if (file.header().channels().findChannel(kRgb9e5Channel) == nullptr)
        refuse(std::string("integers, and none of them ") + kRgb9e5Channel);
    const bool has_origin = file.header().channels().findChannel(kOriginChannel) != nullptr;
    Imf::FrameBuffer frame;
    frame.insert(kRgb9e5Channel, Imf::Slice::Make(Imf::UINT, packed.data(), window));
    if (has_origin)
        frame.insert(kOriginChannel, Imf::Slice::Make(Imf::UINT, origin.data(), window));
    file.setFrameBuffer(frame);
    file.readPixels(window.min.y, window.max.y);
    unpack_rgb9e5(packed, table);
    if (!has_origin) return;
    table.channels.emplace_back(kOriginChannel);
    table.planes.emplace_back(origin.begin(), origin.end());
}

Decoded read_image(std::string_view bytes) {
    ViewStream stream(bytes);
    Imf::InputFile file(stream, 0);
    if (!file.isComplete()) refuse("the file is cut short");
    const Imf::Header& header = file.header();
    Decoded result;
    result.format = "exr";
    for (auto i = header.begin(); i != header.end(); ++i)
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&i.attribute()))
            result.metadata.emplace_back(i.name(), text->value());

    const Imath::Box2i window = header.dataWindow();
    Table& table = result.table;
    table.width = static_cast<std::size_t>(window.max.x - window.min.x + 1);
    table.height = static_cast<std::size_t>(window.max.y - window.min.y + 1);
    table.channels = ordered_names(header, result.metadata);
    const Imf::PixelType type = header.channels().begin().channel().type;
    result.pixel = type == Imf::HALF ? "half" : type == Imf::UINT ? "rgb9e5" : "float";
    if (type == Imf::UINT) {
        read_packed(file, table);
        return result;
    }

    Imf::FrameBuffer frame;
    for (const auto& name : table.channels) {
        table.planes.emplace_back(table.width * table.height);
        frame.insert(name, Imf::Slice::Make(Imf::FLOAT, table.planes.back().data(), window));
    }
    file.setFrameBuffer(frame);
    file.readPixels(window.min.y, window.max.y);
    return result;
}

}  // namespace

Decoded decode_exr(std::string_view bytes) {
    HeaderScan(bytes).check();
    try {
        return read_image(bytes);
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        refuse(e.what());
    }
}

}  // namespace kiln::codec
