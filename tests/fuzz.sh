#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fuzzes readers of untrusted files by libFuzzer under sanitizers of addresses and undefined behaviour.
# Installs what is missing when run as root on Debian 12.
#   tests/fuzz.sh [SECONDS [NAME…]]   60 seconds of each NAME: scene (with the planner; where none is
#                                     given), a format of measured files, or measured: all of these
#   tests/fuzz.sh 1000000x [NAME…]    so many runs each in place of seconds
# What is found lies in build/fuzz/, inputs that are kept in build/fuzz/corpus/NAME/.
set -euo pipefail
cd "$(dirname "$0")/.."
. deploy/install-packages.sh

readers="rgl rgl_spectra merl lbnl_xml bird_json fred zemax lighttools astm csv"
effort=${1:-60}
if [[ ! "$effort" =~ ^[0-9]+x?$ ]]; then
  echo "usage: tests/fuzz.sh [SECONDS | RUNSx] [scene | measured | FORMAT]…" >&2
  exit 2
fi
bound=-max_total_time=$effort
[[ "$effort" = *x ]] && bound=-runs=${effort%x}
[ $# -gt 0 ] && shift
[ $# -gt 0 ] || set -- scene
[ "$*" = measured ] && set -- $readers
for name in "$@"; do
  [[ " scene $readers " = *" $name "* ]] && continue
  echo "tests/fuzz.sh: \"$name\" is none of: scene measured $readers" >&2
  exit 2
done
install_packages deploy/apt-packages.txt deploy/apt-packages-test.txt deploy/apt-packages-fuzz.txt
cmake --preset fuzz
cmake --build --preset fuzz
cd build/fuzz
for name in "$@"; do
  mkdir -p "corpus/$name"
  if [ "$name" = scene ]; then
    bin/fuzz_scene "$bound" -max_len=65536 corpus/scene/
  else
    bin/fuzz_measurement "--reader=$name" "$bound" -max_len=8192 -artifact_prefix="$name-" \
      "corpus/$name/"
  fi
done
