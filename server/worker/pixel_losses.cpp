// SPDX-License-Identifier: Apache-2.0
#include "server/worker/pixel_losses.h"

#include "server/spec/words.h"

namespace kiln {

namespace {

/// A quantity without an entry of its own is the encoder's channel that nobody measured: it gets
/// one, so that the quantisation of every stored channel is told.
ChannelError& entry_of(Report& report, const std::string& quantity) {
    for (ChannelError& channel : report.error)
        if (channel.quantity == quantity) return channel;
    ChannelError& channel = report.error.emplace_back();
    channel.quantity = quantity;
    return channel;
}

}  // namespace

void tell_pixel_losses(Report& report, const std::vector<std::string>& channels, PixelType pixel,
                       const Encoded& encoded) {
    for (std::size_t c = 0; c < channels.size(); ++c) {
        if (c < encoded.quantisation_max.size())
            entry_of(report, channels[c]).quantisation_max = encoded.quantisation_max[c];
        if (c < encoded.clamped.size() && encoded.clamped[c] != 0)
            report.warnings.push_back(channels[c] + ": " + std::to_string(encoded.clamped[c]) +
                                      (encoded.clamped[c] == 1 ? " texel" : " texels") +
                                      " outside what " + std::string(to_word(pixel)) +
                                      " pixels hold, clamped to it");
    }
    if (pixel == PixelType::uint8)
        report.warnings.push_back(
            "8-bit pixels hold 256 levels: expect visible banding; 16-bit PNG or half EXR avoids "
            "it");
}

}  // namespace kiln
