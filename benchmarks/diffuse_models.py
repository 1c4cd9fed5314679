#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How far each diffuse model is from ggx_lambert, the simulated microfacets that most of them
approximate: the tables of docs/diffuse-models.md, in Markdown.

    benchmarks/diffuse_models.py [--kiln build/release/bin/kiln] > docs/diffuse-models.md
"""
import argparse
import json
import os
import subprocess
import tempfile

ROUGHNESS = [0.1, 0.25, 0.5, 0.75, 1.0]
ALBEDOS = [0.9, 0.5, 0.2]
CONTRACT = os.path.join(os.path.dirname(__file__), os.pardir, "api", "openapi.json")
# What a model takes for each roughness, where it is another: Unreal hands EON 0.4 of it (its
# comment says that this range matches).
SCALES = {"eon": [1, 0.4], "eon_unreal": [0.4]}
NARROW = 1e-4  # of a row's range: an axis must have a length

HEAD = """# Diffuse models beside what they approximate

`ggx_lambert` is no formula: light walks over GGX microfacets of the same roughness, each Lambertian,
with Smith's height-correlated masking, until it leaves. Most diffuse models imitate such a surface.
The tables say how far the directional albedo of each is from it: root mean square over 64 texels of
NoV from 0 to 1, and the largest difference. Each model takes the roughness r of its row but where it
says otherwise: `eon 0.4 r` is what Unreal 5.7 hands it. A model that keeps its colour, as Lambert
does, is not wrong: it has another meaning of `albedo`.

`benchmarks/diffuse_models.py > docs/diffuse-models.md` makes this page by `kiln bake --local` and
`kiln diff`, `ggx_lambert` by quadrature: two of its rules differ by {error:.0e} at most.
"""


def models():
    """Every lobe of the contract, with its scales."""
    with open(CONTRACT, encoding="utf-8") as file:
        diffuse = json.load(file)["components"]["schemas"]["Job"]["properties"]["diffuse"]
    return [(word, scale) for word in diffuse["properties"]["model"]["enum"]
            if word not in ("none", "ggx_lambert") for scale in SCALES.get(word, [1])]


def bake(kiln, model, albedo, roughness, settings, out):
    """The largest difference of two rules, where quadrature made the table."""
    low = max(0, roughness - NARROW)
    high = min(1, roughness + NARROW)
    job = {
        "quantities": ["diffuse_albedo"],
        "resolution": [64, 1],
        "layout": {"x": {"parameter": "NoV"},
                   "y": {"parameter": "roughness", "range": [low, high]}},
        **settings,
        "diffuse": {"model": model, "albedo": albedo},
        "device": "native",
        "output": {"format": "exr", "pixel": "float"},
    }
    report = out + ".json"
    subprocess.run([kiln, "bake", "-", "--local", "-o", out, "--report", report], check=True,
                   input=json.dumps(job).encode(), stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    with open(report, encoding="utf-8") as file:
        errors = json.load(file)["error"].values()
    return max(error["reference_max"] or 0 for error in errors)


def difference(kiln, a, b):
    """[(rms, max)] of the three channels."""
    found = subprocess.run([kiln, "diff", "--json", a, b], stdout=subprocess.PIPE, check=False)
    channels = json.loads(found.stdout)["channels"].values()
    return [(channel["rms"], channel["max"]) for channel in channels]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kiln", default="build/release/bin/kiln")
    kiln = parser.parse_args().kiln
    worst, cells = 0, {}
    with tempfile.TemporaryDirectory() as folder:
        truth = os.path.join(folder, "truth.exr")
        other = os.path.join(folder, "other.exr")
        for roughness in ROUGHNESS:
            worst = max(worst, bake(kiln, "ggx_lambert", ALBEDOS, roughness,
                                     {"integrator": "quadrature"}, truth))
            for row in models():
                bake(kiln, row[0], ALBEDOS, row[1] * roughness, {"sample_count": 16384}, other)
                cells[row, roughness] = difference(kiln, truth, other)
    print(HEAD.format(error=worst))
    for channel, albedo in enumerate(ALBEDOS):
        print(f"## Albedo {albedo}: rms / max\n")
        print("| model | " + " | ".join(f"r = {r}" for r in ROUGHNESS) + " |")
        print("|---|" + "---|" * len(ROUGHNESS))
        for row in models():
            name = row[0] + ("" if row[1] == 1 else f" {row[1]} r")
            texts = ["%.4f / %.4f" % cells[row, r][channel] for r in ROUGHNESS]
            print(f"| `{name}` | " + " | ".join(texts) + " |")
        print()


main()
