#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kernels of the split sum beside their arithmetic limit (bench_kernels.cpp counts it), one core.

    benchmarks/arithmetic_limit.py [--bin build/bench/bin] [--rounds 40]

Limits and kernels take turns, one table each. A neighbour that keeps the core's caches or its
other thread busy slows kernels and not limits, hence the least of the rounds beside their median.
"""

import argparse
import json
import os
import statistics
import subprocess


def rounds_of(binaries, instruction_set, rounds):
    """Milliseconds of each round, by the benchmark's row."""
    rows = rf"^((limit|native)/{instruction_set}/one_thread|opencl/256)/(E|A_B)/"
    command = [os.path.join(binaries, "bench_kernels"), "--benchmark_filter=" + rows,
               f"--benchmark_repetitions={rounds}", "--benchmark_min_time=0.001",
               "--benchmark_enable_random_interleaving=true",
               "--benchmark_format=json"]
    environment = {**os.environ, "POCL_MAX_PTHREAD_COUNT": "1"}
    out = subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True).stdout
    times = {}
    for row in json.loads(out)["benchmarks"]:
        if row["run_type"] == "iteration":
            name = row["run_name"].replace("/real_time", "")
            times.setdefault(name, []).append(row["real_time"])
    return times


def widest(binaries):
    """The instruction set that native code takes here: the first that the benchmark lists."""
    command = [os.path.join(binaries, "bench_kernels"), "--benchmark_list_tests",
               "--benchmark_filter=^limit/"]
    out = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    return out.split("/")[1]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", default="build/bench/bin")
    parser.add_argument("--rounds", type=int, default=40)
    arguments = parser.parse_args()
    instruction_set = widest(arguments.bin)
    times = rounds_of(arguments.bin, instruction_set, arguments.rounds)
    print(f"{instruction_set + f', {arguments.rounds} rounds':28} {'least':>10} {'of limit':>9} "
          f"{'median':>10} {'of limit':>9}")
    for what in ("E", "A_B"):
        limit = times[f"limit/{instruction_set}/one_thread/{what}"]
        for name, values in times.items():
            if not name.endswith("/" + what):
                continue
            least, middle = min(values), statistics.median(values)
            print(f"{name:28} {least:7.1f} ms {least / min(limit):9.2f} {middle:7.1f} ms "
                  f"{middle / statistics.median(limit):9.2f}")


if __name__ == "__main__":
    main()
