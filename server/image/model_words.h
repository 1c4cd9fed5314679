// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "server/spec/job_spec.h"

namespace kiln {

// The models of a job in words, for describe() and convention().

/// The Fresnel term that the quantities read, with its numbers; "none" where none reads one.
std::string fresnel_words(const JobSpec& job);
std::string diffuse_words(const JobSpec& job);
std::string distribution_words(Distribution distribution);
std::string masking_words(const JobSpec& job);
std::string multiscatter_words(Multiscatter multiscatter);

}  // namespace kiln
