#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Memory of a 4096 x 4096 job of four float channels: all processes of a server together, at its
peak, and after a cancel.

    benchmarks/memory.py [--bin build/release/bin]
"""

import argparse
import json
import subprocess
import threading
import time

from headline import Server

BIG = {"quantities": ["split_sum_scale", "split_sum_bias", "directional_albedo",
                      "multiscatter_albedo"],
       "resolution": [4096, 4096], "sample_count": 16,
       "output": {"format": "exr", "pixel": "float"}}
LIVE = ("queued", "running")


def family(process):
    """Process ids of a process and all below it."""
    children = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process)], capture_output=True,
                              text=True, check=False).stdout.split()
    return [process] + [pid for child in children for pid in family(int(child))]


def mebibytes(process):
    """Proportional set size: shared pages count once."""
    total = 0
    for pid in family(process):
        try:
            with open(f"/proc/{pid}/smaps_rollup", encoding="ascii") as file:
                total += next(int(line.split()[1]) for line in file if line.startswith("Pss:"))
        except (OSError, StopIteration):  # it ended
            pass
    return total / 1024


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", default="build/release/bin")
    server = Server(parser.parse_args().bin)
    pid = server.process.pid
    server.bake({**BIG, "resolution": [16, 16]})
    print(f"idle                      {mebibytes(pid):7.0f} MiB")
    peak, done = [0], threading.Event()

    def watch():
        while not done.wait(0.05):
            peak[0] = max(peak[0], mebibytes(pid))

    watcher = threading.Thread(target=watch)
    watcher.start()
    identity = json.loads(server.request("POST", "/v1/jobs", BIG)[1])["id"]
    path = f"/v1/jobs/{identity}?wait=30"
    while json.loads(server.request("GET", path)[1])["state"] in LIVE:
        pass
    done.set()
    watcher.join()
    print(f"4096 x 4096 x 4 float     {peak[0]:7.0f} MiB at most (2048 asked)")
    longer = {**BIG, "sample_count": 1024}
    identity = json.loads(server.request("POST", "/v1/jobs", longer)[1])["id"]
    time.sleep(5)
    busy = mebibytes(pid)
    server.request("DELETE", f"/v1/jobs/{identity}")
    time.sleep(2)
    print(f"while another runs        {busy:7.0f} MiB, 2 s after its cancel {mebibytes(pid):.0f} MiB")
    server.stop()


if __name__ == "__main__":
    main()
