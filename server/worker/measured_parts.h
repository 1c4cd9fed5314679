// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/measured/job_sidecar.h"
#include "server/measured/material.h"
#include "server/worker/bake.h"

/// What jobs of all measured kinds share; nobody but bake_measured.cpp includes this.
namespace kiln {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start);

/// Progress of one material among many, and the look for a cancel. Reading a file and integrating
/// its albedos say nothing for a while: a thread beside them gives signs of life, but of no step
/// for longer than kQuietStepMax.
class Teller {
  public:
    Teller(const Control& control, std::size_t count);
    ~Teller();
    Teller(const Teller&) = delete;
    Teller& operator=(const Teller&) = delete;

    /// `fraction` of that material is done. Throws Cancelled.
    void at(std::size_t material, double fraction);

  private:
    void tell();
    void keep_in_touch();

    const Control& control_;
    const std::size_t count_;
    std::mutex mutex_;
    std::condition_variable changed_;
    Clock::time_point told_{}, sign_ = Clock::now();
    double fraction_ = 0;
    bool quit_ = false;
    std::thread thread_;
};

/// Throws what the readers throw and Error("unfit_measurement"), with the material's name in front.
measured::Material read_material(const MeasuredMaterial& wanted,
                                 const MeasurementSource& measurements,
                                 measured::MaterialNote& note);

/// Job, device and times of making; nothing of encoding yet.
Report measured_report(const JobSpec& job, const Engine::Place& place, Clock::time_point start);

/// Encodes a table as `job` asks, described as one of `kept` (what the image holds of the job), and
/// completes image and report. A PNG gets colours alone: it has no channel for where they come
/// from.
void encode_measured(const JobSpec& job, const JobSpec& kept, const Table& table,
                     const Control& control, Clock::time_point start, Baked& baked);

}  // namespace kiln
