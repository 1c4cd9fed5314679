// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "server/store/measurement_store.h"

namespace kiln {

/// Has a measured file read in a process of its own, which may crash, hang or ask for memory
/// without end and harms nobody: the file is untrusted, and so is the answer. Fills in format,
/// title, unfit, account and `readers`. Throws Error with a code whose status is 422, which blames
/// the file, or Error("cannot_start").
Measurement read_in_a_process(int file, std::int64_t readers);

}  // namespace kiln
