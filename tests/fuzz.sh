#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fuzzes the reader of scenes and the planner by libFuzzer under the address and undefined-behaviour
# sanitizers. Installs what is missing when run as root on Debian 12.
#   tests/fuzz.sh [SECONDS]   60; what is found lies in build/fuzz/, inputs that are kept in build/fuzz/corpus/
set -euo pipefail
cd "$(dirname "$0")/.."
. deploy/install-packages.sh

if [ $# -gt 1 ] || [[ ! "${1:-60}" =~ ^[0-9]+$ ]]; then
  echo "usage: tests/fuzz.sh [SECONDS]" >&2
  exit 2
fi
install_packages deploy/apt-packages.txt deploy/apt-packages-test.txt deploy/apt-packages-fuzz.txt
cmake --preset fuzz
cmake --build --preset fuzz
mkdir -p build/fuzz/corpus
cd build/fuzz
exec bin/fuzz_scene -max_total_time="${1:-60}" -max_len=65536 corpus/
