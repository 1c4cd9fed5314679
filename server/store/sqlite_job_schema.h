// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "server/store/sqlite.h"

namespace kiln {

/// Puts the connection into WAL mode with synchronous = FULL and creates the tables of a new file.
/// Refuses a schema newer than this program's and another program's file, both untouched.
/// Throws Error("store_failed").
void prepare_job_schema(Database& database, const std::string& path);

}  // namespace kiln
