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

mkdir -p build out
: >"$log"
step "installing packages" install_packages deploy/apt-packages.txt
step "building" build
scratch=$(mktemp -d)
data=${1:-$scratch/data}
step "starting kilnd" start_server
printf '\n'
for job in examples/*.json; do
  format=$(grep -o '"format": *"[a-z]*"' "$job" | grep -o '[a-z]*"$' | tr -d '"') || format=exr
  name=$(basename "$job" .json)
  "$bin/kiln" bake "$job" -o "out/$name.$format" --report "out/$name.report.json" --server "$url" --progress none
done
stop_server
printf '\nThe images and their reports are in out/. Bake your own: %s/kiln bake JOB.json -o OUT.exr\n' "$bin"
