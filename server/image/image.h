// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/compute/table.h"
#include "server/spec/job_spec.h"

namespace kiln {

/// Ordered key/value text that travels inside the file. Keys are of the form "kiln.job".
using Metadata = std::vector<std::pair<std::string, std::string>>;

struct Encoded {
    std::string bytes;
    std::string extension;  ///< "exr" or "png"
    /// Per channel: largest |stored − given| among the values that fit the pixel type.
    std::vector<double> quantisation_max;
    std::vector<std::uint64_t> clamped;  ///< per channel: values that did not fit
};

/// Raised whenever an encoder writes other bytes for the same table; part of the image key.
inline constexpr int kEncoderRevision = 3;

/// Throws Error("cannot_encode") for a table that the format cannot hold (more than four channels
/// in a PNG, …). Error("non_finite") for a value that is no finite number. Metadata keys begin with
/// "kiln.", values are ASCII. Equal input gives equal bytes. Memory beside the table and the result
/// stays below a few scan lines a thread. thread_count: threads that may compress a large EXR, 0 =
/// every core this process may use; same bytes. `between_lines` is called every few thousand
/// texels; what it throws ends the encoding.
Encoded encode(
    const Table& table, ImageFormat format, PixelType pixel, const Metadata& metadata,
    unsigned thread_count = 0, const std::function<void()>& between_lines = [] {});

/// All that reproduces a table from its job: never a host name, date, device or thread count.
struct Provenance {
    std::string kernel_digest;
    std::string numerics;
    std::string key;  ///< image key
    std::optional<double> standard_error_max;
};
Metadata describe(const JobSpec& job, const Provenance& provenance);

/// The table's convention in words, one line a fact: axes, orientation, grid, alpha, channels.
std::vector<std::string> convention(const JobSpec& job);

/// A file as read back; for the command line's `info` and `diff` and for tests, never on a server.
struct Decoded {
    Table table;  ///< channels carry the file's own channel names
    Metadata metadata;
    std::string format;  ///< "exr" or "png"
    std::string pixel;   ///< "half", "float", "uint8", "uint16"
};
/// Throws Error("cannot_decode") naming what is wrong.
Decoded decode(std::string_view bytes);

}  // namespace kiln
