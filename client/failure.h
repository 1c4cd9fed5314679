// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/spec/spec.h"

namespace kiln::client {

/// What `kiln` tells the program that called it.
enum class Exit : int {
    done = 0,
    failed = 1,       ///< the job, or something on the way, failed
    usage = 2,        ///< wrong arguments, or a file that cannot be read or written
    invalid_job = 3,  ///< the job document is no meaningful job
    unreachable = 4,  ///< the named server does not answer, or is full
    timed_out = 5,
    different = 6,  ///< `diff` found a difference, `advise` no table within the bound
    interrupted = 130,
};

/// Ends a command: a sentence for people, a code for programs, an exit status for both.
class Failure : public Error {
  public:
    Failure(Exit exit_status, std::string code, const std::string& detail,
            std::vector<Problem> found = {})
        : Error(std::move(code), detail), exit(exit_status), problems(std::move(found)) {}
    Exit exit;
    std::vector<Problem> problems;
};

}  // namespace kiln::client
