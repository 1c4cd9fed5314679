# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# To be sourced. install_packages LIST...: installs what is missing of the Debian packages in the lists
# (one a line, # starts a comment). Without root it names the command to run and returns 1.

missing_packages() {
  local name
  sed 's/#.*//' "$@" | while read -r name; do
    [ -n "$name" ] || continue
    dpkg-query -W -f '${db:Status-Status}\n' "$name" 2>/dev/null | grep -qx installed || echo "$name"
  done
}

install_packages() {
  local missing
  command -v dpkg-query >/dev/null || {
    echo "This is not Debian: install what corresponds to the packages in $*" >&2
    return 1
  }
  missing=$(missing_packages "$@" | tr '\n' ' ')
  [ -n "$missing" ] || return 0
  if [ "$(id -u)" != 0 ]; then
    printf 'Packages are missing. As root, run:\n  apt-get install --no-install-recommends %s\n' "$missing" >&2
    return 1
  fi
  export DEBIAN_FRONTEND=noninteractive
  apt-get update -q || return 1
  # shellcheck disable=SC2086 # one word a package
  apt-get install -q -y --no-install-recommends $missing
}
