// SPDX-License-Identifier: Apache-2.0
#include "server/worker/engines.h"

namespace kiln {

Engines::Engines(const Settings& settings)
    : settings_(settings),
      opencl_off_until_(Clock::now() + std::chrono::seconds(settings.opencl_off_s)),
      opencl_off_(settings.opencl_off_s > 0) {
    usual_ = make(opencl_off_ ? settings.opencl_off_reason : "");
    usual_->warm_up();
}

std::unique_ptr<Engine> Engines::make(const std::string& opencl_disabled_reason) const {
    EngineOptions options;
    options.device = settings_.device == "opencl"   ? DeviceChoice::opencl
                     : settings_.device == "native" ? DeviceChoice::native
                                                    : DeviceChoice::automatic;
    options.opencl_disabled_reason = opencl_disabled_reason;
    options.thread_count = static_cast<unsigned>(settings_.threads);
    return std::make_unique<Engine>(std::move(options));
}

void Engines::refresh() {
    if (!opencl_off_ || Clock::now() < opencl_off_until_) return;
    opencl_off_ = false;
    usual_ = make("");
    usual_->warm_up();
}

Engine& Engines::pick(const std::string& note) {
    refresh();
    careful_.reset();
    if (note.empty()) return *usual_;
    careful_ = make("an earlier attempt failed: " + note);
    return *careful_;
}

}  // namespace kiln
