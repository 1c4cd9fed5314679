#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds and runs every test. Installs what is missing when run as root on Debian 12.
#   tests/run.sh          preset dev
#   tests/run.sh --asan   the same under the address and undefined-behaviour sanitizers
#   tests/run.sh --long   both, one after the other
set -euo pipefail
cd "$(dirname "$0")/.."
. deploy/install-packages.sh

case "${1:-}" in
  "") presets=dev ;;
  --asan) presets=asan ;;
  --long) presets="dev asan" ;;
  *) echo "usage: tests/run.sh [--asan | --long]" >&2; exit 2 ;;
esac

install_packages deploy/apt-packages.txt deploy/apt-packages-test.txt
for preset in $presets; do
  start=$SECONDS
  cmake --preset "$preset"
  cmake --build --preset "$preset"
  built=$((SECONDS - start))
  ctest --preset "$preset" -j2 --output-log "build/$preset/tests.log"
  printf '\npreset %s: built in %d s, tested in %d s\n' "$preset" "$built" $((SECONDS - start - built))
  grep 'tests passed' "build/$preset/tests.log"
done
