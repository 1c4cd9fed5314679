// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <stdexcept>
#include <string>

namespace kiln {

/// A failure that ends a job or a request. `code` is the stable word that clients branch on
/// ("device_failed", "non_finite", "cancelled", "io_error", …); what() is the sentence for people.
class Error : public std::runtime_error {
  public:
    Error(std::string code, const std::string& detail)
        : std::runtime_error(detail), code_(std::move(code)) {}
    const std::string& code() const { return code_; }

  private:
    std::string code_;
};

/// Thrown where work stops because its client asked for that.
class Cancelled : public Error {
  public:
    Cancelled() : Error("cancelled", "the job was cancelled") {}
};

}  // namespace kiln
