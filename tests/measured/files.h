// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "server/measured/material.h"
#include "server/measured/survey.h"

namespace kiln::measured_files {

/// Real measurements, which are other people's and not part of the project: the folder that
/// KILN_MEASURED_FILES names, or the one beside the project. Empty where there is none.
inline std::filesystem::path folder() {
    const char* given = std::getenv("KILN_MEASURED_FILES");
    const std::filesystem::path path = given ? given : KILN_SOURCE_DIR "/../shared/data/measured";
    return std::filesystem::exists(path / "rgl") ? path : std::filesystem::path();
}

inline constexpr const char* kNoFolder =
    "no folder of measured files; KILN_MEASURED_FILES may name one";

/// Of the real files.
class Files : public testing::Test {
  protected:
    void SetUp() override {
        if (folder().empty()) GTEST_SKIP() << kNoFolder;
    }
};

inline std::string bytes_of(const std::string& name) {
    std::ifstream in(folder() / name, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

inline measured::Reading reading_of(const std::string& name) {
    return measured::read_measurement(bytes_of(name));
}

/// The first component of a file's bytes.
inline measured::Material material_of(const std::string& bytes, Extrapolation how = {},
                                      measured::PhiIn phi_in = {}) {
    measured::Reading reading = measured::read_measurement(bytes);
    return measured::Material(reading.components[0], how, reading.understood, phi_in);
}

inline std::string finding(const measured::Understood& account, const std::string& what) {
    for (const measured::Finding& one : account.findings)
        if (one.what == what) return one.value;
    return {};
}

}  // namespace kiln::measured_files
