// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "server/store/blob_store.h"

// store_put DIRECTORY TEXT: prints the digest once the blob is durable.
int main(int argc, char** argv) {
    if (argc != 3) return 2;
    kiln::DiskBlobStore store(argv[1], 1 << 20);
    std::puts(store.put(argv[2]).c_str());
    return 0;
}
