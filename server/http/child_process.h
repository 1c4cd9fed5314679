// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace kiln {

/// A started worker and this end of the socket to it (non-blocking).
struct ChildProcess {
    pid_t pid = -1;
    int socket = -1;
};

/// The descriptor under which a worker finds its end of the socket.
inline constexpr int kWorkerSocket = 3;

/// Of a child that is not meant to last.
struct ChildLimits {
    std::uint64_t memory_bytes_max = 0;
    std::uint64_t cpu_s_max = 0;
};

/// Runs this program again with `arguments` (without the program's name) and `environment`. The
/// child has standard error, the socket and nothing else open, dies with the calling thread, writes
/// no core and can gain no privileges. `input`, where it is a descriptor, becomes its standard
/// input. With limits it writes no file either. Call it from a thread that outlives the child.
/// Throws Error("cannot_start").
ChildProcess start_child(const std::vector<std::string>& arguments,
                         const std::vector<std::string>& environment, int nice_level,
                         int input = -1, std::optional<ChildLimits> limits = {});

/// The environment of a worker: this process's own, less the PoCL settings that could change
/// results, with the kernel cache at `cache_dir`.
std::vector<std::string> worker_environment(const std::string& cache_dir);

/// "was killed by signal 11 (Segmentation fault)" or "ended with status 1", of a waitpid status.
std::string describe_end(int status);

}  // namespace kiln
