// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "server/base/error.h"
#include "server/compute/engine.h"
#include "server/compute/report.h"
#include "server/spec/job_spec.h"
#include "server/study/study.h"

namespace kiln {

/// What a job becomes: the file's bytes and the finished account of them.
struct Baked {
    std::string image;
    std::string extension;     ///< "exr" or "png"
    Report report;             ///< complete but for run_time_s.queued, which only a queue knows
    std::string image_digest;  ///< SHA-256 of `image`, 64 hex digits: the blob's name and its ETag
    std::optional<Study> study;  ///< of a job that is one; its diagrams are the image
    std::string sidecar;         ///< JSON: what a shader has to know of slices and atlases; else ""
};

/// Gives a measured file's bytes by their SHA-256; throws Error where it has none.
using MeasurementSource = std::function<std::string(const std::string& digest)>;

/// The contract's JSON text: the report, with the study or the side-car where there is one.
std::string report_json(const Baked& baked);

/// Integrates, describes and encodes: the one way from a job to a file, on a server and in `kiln
/// bake --local` alike, so that both give the same bytes. Throws what Engine::run and encode throw.
/// `measurements` is asked by jobs of measured kinds alone.
Baked bake(
    Engine& engine, const JobSpec& job, const Control& control,
    const MeasurementSource& measurements = [](const std::string&) -> std::string {
        throw Error("measurement_missing", "there are no measurements here");
    });

/// Names the bytes of an image before they exist: 64 hex digits over the physics, the numerics
/// class, the encoder and the job.
std::string image_key(const JobSpec& job, const std::string& numerics);

}  // namespace kiln
