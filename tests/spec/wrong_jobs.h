// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace kiln::test {

/// One entry of tests/spec/wrong_jobs.json; README.md there says what the fields mean.
struct WrongJob {
    std::string name;
    std::string text;
    int status = 0;
    std::string pointer;
    std::size_t problem_count = 1;
    bool schema_refuses = true;
};

std::vector<WrongJob> wrong_jobs();

}  // namespace kiln::test
