// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

#include "server/store/measurement_store.h"

namespace kiln {

/// What a process that read a measurement says: a refusal by its code, or what was understood.
struct ReaderAnswer {
    std::string code, detail;
    Measurement measurement;  ///< format, title, unfit and account alone
};
/// Of text that is not trusted; what it cannot be is a refusal "unreadable_measurement".
ReaderAnswer read_reader_answer(std::string_view text);

/// The contract's Measurement.
std::string measurement_document(const Measurement& measurement);
/// The contract's MeasurementList.
std::string measurement_page_document(const MeasurementPage& page);

/// The side-car in the report of a job of measured kind. Throws Error("no_sidecar").
std::string sidecar_document(const std::string& report);

}  // namespace kiln
