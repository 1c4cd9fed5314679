// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kiln {

/// The whole life of a process that reads one measurement: the file on standard input, what was
/// understood of it as JSON to `socket`. Returns the exit status.
int read_measurement_once(int socket);

}  // namespace kiln
