#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a fresh Debian 12 to baked tables: installs packages (as root), builds, starts kilnd on a free
# loopback port, bakes examples/*.json over HTTP into out/, and stops the server.
#   deploy/quickstart.sh [DATA_DIR]   jobs and results of the server; without it, a temporary directory
set -euo pipefail
cd "$(dirname "$0")/.."
. deploy/install-packages.sh

if [ $# -gt 1 ] || [[ "${1:-}" == -* ]]; then
  echo "usage: deploy/quickstart.sh [DATA_DIR]" >&2
  exit 2
fi
bin=build/release/bin
log=build/quickstart.log
server=
scratch=

stop_server() {
  [ -z "$server" ] || { kill "$server" 2>/dev/null && wait "$server"; } || true
  server=
}
clean_up() {
  local status=$?
  trap - EXIT INT TERM
  stop_server
  [ -z "$scratch" ] || rm -rf "$scratch"
  exit "$status"
}
trap clean_up EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# step NAME COMMAND...: one line while all is well, the end of the log when it is not.
step() {
  local name=$1 start=$SECONDS
  shift
  printf '%-24s' "$name"
  "$@" >>"$log" 2>&1 || { printf 'failed; the end of %s:\n' "$log"; tail -n 40 "$log"; return 1; } >&2
  printf '%4d s\n' $((SECONDS - start))
}

build() { cmake --preset release && cmake --build --preset release; }

start_server() {
  "$bin/kilnd" serve --listen 127.0.0.1:0 --data-dir "$data" 2>"$scratch/kilnd.log" &
  server=$!
  for _ in $(seq 300); do
    url=$(sed -n 's/^listening on //p' "$scratch/kilnd.log")
    [ -z "$url" ] || return 0
    kill -0 "$server" 2>/dev/null || break
    sleep 0.1
  done
  cat "$scratch/kilnd.log"
  return 1
}

# The last line of the trace is the standard error at all samples, over all channels.
summary() {
  awk -v image="$1" '
    function last(name, text,  value) {
      while (match(text, "\"" name "\":[^,}]*")) {
        value = substr(text, RSTART + length(name) + 3, RLENGTH - length(name) - 3)
        text = substr(text, RSTART + RLENGTH)
      }
      gsub(/"/, "", value)
      return value
    }
    # Measured tables are not sampled, and have none.
    function error(value) { return value ~ /[0-9]/ ? sprintf("%.1e", value) : "-" }
    { report = report $0 }
    END {
      match(report, /"run_time_s":[{][^}]*[}]/)
      time = last("total", substr(report, RSTART, RLENGTH))
      printf "%-38s %12s %8s %7d ms  %s\n", image, error(last("standard_error_rms", report)),
             error(last("standard_error_max", report)), 1000 * time + 0.5, last("backend", report)
    }' "$2"
}

bake() {
  local name format
  name=$(basename "$1" .json)
  format=$(sed -n 's/.*"format": *"\([a-z]*\)".*/\1/p' "$1")
  "$bin/kiln" bake "$1" -o "out/$name.${format:-exr}" --report "out/$name.report.json" \
    --server "$url" --progress none 2>"$scratch/kiln.log" || { cat "$scratch/kiln.log" >&2; return 1; }
  summary "out/$name.${format:-exr}" "out/$name.report.json"
}

mkdir -p build out
: >"$log"
step "installing packages" install_packages deploy/apt-packages.txt
step "building" build
scratch=$(mktemp -d)
data=${1:-$scratch/data}
step "starting kilnd" start_server
printf '\n%-38s %12s %8s %10s  %s\n' "" "error rms" max "run time" on
for job in examples/*.json; do bake "$job"; done
stop_server
printf '\nBeside each image is its report. Bake your own: %s/kiln bake JOB.json -o OUT.exr\n' "$bin"
