#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Time to an error: a 256 x 256 split sum, integration against cmgen's whole process, medians.

    benchmarks/equal_error.py [--bin build/release/bin] [--runs 15]

Errors are those of the tables that came back, float pixels and cmgen's half, against quadrature in
double. cmgen's is held against the layout "filament", whose rows lie where cmgen's do.
"""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import tempfile

from headline import SPLIT_SUM, Server, time_cmgen

CMGEN_MAX = 1.3e-2  # what cmgen 1.9.25 is off by; below, the one that is installed is measured

RECIPES = {
    "quadrature, to cmgen's error": {"integrator": "quadrature", "target_error": CMGEN_MAX},
    "quadrature, to 1e-4": {"integrator": "quadrature", "target_error": 1e-4},
    "quadrature, as it comes (1e-6)": {"integrator": "quadrature"},
    "1024 samples": {"sample_count": 1024},
    "4096 samples": {"sample_count": 4096},
}
# Coarser pixels would hide the smaller errors.
FLOAT = {"output": {"format": "exr", "pixel": "float"}}
EXACT = {"integrator": "quadrature", "precision": "float64"}


def job(recipe, device, run):
    body = {name: SPLIT_SUM[name] for name in ("quantities", "resolution")}
    return {**body, **FLOAT, **recipe, "device": device, "seed": run}


def save(server, folder, name, body):
    """Bakes and stores; the report."""
    links = json.loads(server.request("POST", "/v1/jobs?wait=60", body)[1])["links"]
    with open(os.path.join(folder, name), "wb") as file:
        file.write(server.request("GET", links["image"])[1])
    return json.loads(server.request("GET", links["report"])[1])


def errors(binaries, folder, name, exact="exact.exr"):
    """Root mean square and largest difference from the exact table, of the worse of R and G."""
    command = [os.path.join(binaries, "kiln"), "diff", "--json", f"{folder}/{name}",
               f"{folder}/{exact}"]
    out = subprocess.run(command, capture_output=True, text=True, check=False).stdout
    channels = [json.loads(out)["channels"][name] for name in "RG"]
    return max(c["rms"] for c in channels), max(c["max"] for c in channels)


def cmgen_errors(server, binaries, folder):
    """Of the cmgen that is installed; the third channel of its file, zeros, is not looked at."""
    body = job({**EXACT, "layout": "filament"}, "native", 0)
    body["quantities"] = [*body["quantities"], "directional_albedo"]
    save(server, folder, "exact_cmgen.exr", body)
    subprocess.run(["cmgen", "--quiet", "--compression=ZIP", f"--ibl-dfg={folder}/cmgen.exr", "-s",
                    "256"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return errors(binaries, folder, "cmgen.exr", "exact_cmgen.exr")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", default="build/release/bin")
    parser.add_argument("--runs", type=int, default=15)
    arguments = parser.parse_args()
    if shutil.which("cmgen") is None:
        print("skipped: cmgen is not installed (package libfilament-tools)")
        return
    server = Server(arguments.bin)
    with tempfile.TemporaryDirectory() as folder:
        save(server, folder, "exact.exr", job(EXACT, "native", 0))
        for recipe in RECIPES.values():  # programs and caches warm
            save(server, folder, "warm.exr", job(recipe, "opencl", 1))
        times = {}
        for run in range(2, 2 + arguments.runs):
            times.setdefault("cmgen, whole process", []).append(time_cmgen(folder))
            for name, recipe in RECIPES.items():
                for device in ("native", "opencl"):
                    report = save(server, folder, f"{name} {device}.exr", job(recipe, device, run))
                    seconds = report["run_time_s"]["integrate"]
                    times.setdefault(f"{name}, {device}", []).append(seconds)
        cmgen = statistics.median(times["cmgen, whole process"])
        print(f"{'256 x 256 split sum':44}      time   of cmgen  rms     max")
        for name, values in times.items():
            middle = statistics.median(values)
            file = name.replace(", native", " native").replace(", opencl", " opencl") + ".exr"
            rms, most = (cmgen_errors(server, arguments.bin, folder) if name.startswith("cmgen")
                         else errors(arguments.bin, folder, file))
            print(f"{name:44} {middle * 1e3:8.2f} ms  1/{cmgen / middle:5.0f}  "
                  f"{rms:.1e} {most:.1e}")
    server.stop()


if __name__ == "__main__":
    main()
