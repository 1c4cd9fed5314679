// SPDX-License-Identifier: Apache-2.0
// table_digest JOB-TEXT: integrates the job and prints "DIGEST BACKEND FALLBACK-OR-DASH". Waits for
// OpenCL.
#include <cstdio>
#include <cstring>

#include "server/base/sha256.h"
#include "server/compute/engine.h"
#include "server/spec/spec.h"

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    try {
        kiln::EngineOptions options;
        options.opencl_wait = std::chrono::minutes(2);
        kiln::Engine engine(options);
        const kiln::Outcome outcome = engine.run(kiln::parse_job(argv[1]), kiln::Control{});
        kiln::Sha256 hash;
        for (const auto& plane : outcome.table.planes)
            hash.update(plane.data(), plane.size() * sizeof(float));
        const auto& device = outcome.report.device;
        std::printf("%s %s %s\n", hash.hex().c_str(), device.backend.c_str(),
                    device.fallback.value_or("-").c_str());
    } catch (const kiln::Error& error) {
        std::printf("error %s %s\n", error.code().c_str(), error.what());
        return 1;
    }
    return 0;
}
