// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "server/compute/backend.h"
#include "server/compute/thread_pool.h"

namespace kiln {

/// The instruction sets that the native backend is compiled for, x86-64 psABI levels.
enum class InstructionSet { v2, v3, v4 };

/// Those that this CPU has, widest first.
std::vector<InstructionSet> usable_instruction_sets();
std::string to_string(InstructionSet set);

/// The kernels as C++ on the threads of `pool`.
std::unique_ptr<Backend> make_native_backend(ThreadPool& pool, InstructionSet set);

}  // namespace kiln
