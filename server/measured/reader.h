// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/measured/cloud.h"

namespace kiln::measured {

/// One thing that a reader concluded, with what speaks for it.
struct Finding {
    std::string what;      ///< "convention", "angles", "azimuth", "symmetry", "mask", …
    std::string value;     ///< "f", "f cos theta_o", "reflectance factor", …
    std::string evidence;  ///< a sentence without its full stop
};

struct LeftOut {
    std::string what, why;
};

/// The account of a file. All text is printable ASCII and bounded.
struct Understood {
    std::string format;  ///< the reader's name
    std::string title;   ///< what the file calls itself; may be empty
    std::vector<Finding> findings;
    std::vector<LeftOut> left_out;
    std::vector<std::string> warnings;

    void found(std::string what, std::string value, std::string evidence);
    void leave_out(std::string what, std::string why);
    void warn(std::string text);
};

/// Raised whenever a reader, or what is made of its points, gives other numbers: accounts are read
/// afresh and results computed afresh.
inline constexpr int kReaderRevision = 4;

struct Reading {
    Understood understood;
    std::vector<Component> components;  ///< the first is what tables are made of
};

/// What a person knows better than the file. Each entry replaces the reader's own conclusion.
struct ReadOptions {
    std::optional<double> theta_out_max_deg;  ///< points beyond were not measured
    std::optional<double> phi_in_deg;         ///< azimuth of the light in absolute angles
};

/// A file format. `recognises` looks at content alone and never throws; `read` throws
/// Error("malformed_measurement") naming the line or byte, and looks at no byte outside `bytes`.
struct Reader {
    std::string_view name;
    std::string_view description;
    bool (*recognises)(std::string_view bytes);
    Reading (*read)(std::string_view bytes, const ReadOptions& options);
};

/// Every format, in the order in which they are asked. A new one is a file and a row.
const std::vector<Reader>& readers();

/// Reads a file in the first format that recognises it, and checks the cloud that came of it:
/// finite values, at least one usable point. Throws Error("unknown_measurement") listing what
/// would be known, Error("measurement_too_large"), or what the reader throws.
Reading read_measurement(std::string_view bytes, const ReadOptions& options = {});

/// `text` as printable ASCII of at most 120 characters; other bytes become '?'.
std::string plain_text(std::string_view text);

/// A number for a message: six significant digits.
std::string in_words(double value);

}  // namespace kiln::measured
