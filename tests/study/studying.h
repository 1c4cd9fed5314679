// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <string>

#include "server/spec/spec.h"
#include "server/study/studies.h"

// Studies of job documents, on native alone.
namespace kiln::studying {

inline Engine native_engine() {
    return Engine({.device = DeviceChoice::native,
                   .opencl_wait = std::chrono::milliseconds(0),
                   .opencl_disabled_reason = "",
                   .thread_count = 0});
}

inline Studied study_of(const std::string& document) {
    Engine engine = native_engine();
    return make_study(engine, parse_job(document), Control{});
}

inline const Verdict& verdict(const Study& study, const std::string& name) {
    for (const Verdict& one : study.verdicts)
        if (one.name == name) return one;
    throw Error("test", "no verdict " + name);
}

/// The number in a row of the table under a column.
inline double number(const StudyTable& table, std::size_t row, const std::string& column) {
    for (std::size_t c = 0; c < table.columns.size(); ++c)
        if (table.columns[c] == column) return table.rows.at(row)[c].number.value();
    throw Error("test", "no column " + column);
}

}  // namespace kiln::studying
