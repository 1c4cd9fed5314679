// SPDX-License-Identifier: Apache-2.0
#include "server/compute/opencl_threads.h"

#include <sched.h>
#include <unistd.h>

#include <cstdlib>

namespace kiln {

void pin_opencl_threads() {
    cpu_set_t usable;
    CPU_ZERO(&usable);
    if (sched_getaffinity(0, sizeof(usable), &usable) != 0) return;
    // PoCL's thread i goes to core i, whatever the mask says: only a whole, gapless mask is kept.
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    if (online < 1 || CPU_COUNT(&usable) != online) return;
    for (int core = 0; core < online; ++core)
        if (!CPU_ISSET(core, &usable)) return;
    ::setenv("POCL_AFFINITY", "1", 0);
}

}  // namespace kiln
