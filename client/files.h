// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace kiln::client {

/// Everything in a file, or in standard input for "-". Throws Failure(usage) for a file that cannot
/// be read or holds more than `bytes_max` bytes.
std::string read_input(const std::string& path, std::size_t bytes_max);

/// A job document, "{}" where `path` is empty, with `settings` (field=value) made in it. Throws
/// Malformed for a document that cannot be read, Failure(usage) for a setting that cannot be made.
std::string read_job(const std::string& path, const std::vector<std::string>& settings);

/// Makes the folder, and those above it, unless it is there. Throws Failure(usage) with the reason.
void make_folder(const std::string& path);

/// Fails early, before minutes of work: throws Failure(usage) if `path` could not be written later.
/// "-" is standard output, which must not be a terminal.
void check_output(const std::string& path);

/// Readers see the old file or the whole new one, never a part: a temporary file beside it, then a
/// rename.
/// "-" writes to standard output. Throws Failure(failed) naming the file and the reason.
void write_output(const std::string& path, std::string_view bytes);

/// "EXR" → "exr"; "" where the last path component has no extension.
std::string extension_of(const std::string& path);

/// $XDG_CACHE_HOME/kiln/pocl (else ~/.cache/kiln/pocl), made with mode 0700; the first OpenCL call
/// reads POCL_CACHE_DIR, so this comes before it. Leaves a POCL_CACHE_DIR that is set alone. Where
/// no folder can be made, PoCL keeps its own default.
void keep_opencl_programs();

}  // namespace kiln::client
