#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""atlas_picture.py ATLAS.png SIDECAR.json OUT.png: an rgb9e5 atlas for people.

pi f, the albedo where a material is diffuse, through x / (1 + x / 4) and sRGB; texels below the
horizon, which no shader reads, are dark. Cells are as in the atlas, with lines between slices."""
import json
import math
import os
import struct
import sys
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "tests", "http"))
from slices import Slices  # noqa: E402

DARK, LINE = (24, 26, 30), (255, 255, 255)


def shown(value):
    """A value of pi f as an sRGB code."""
    x = value / (1 + value / 4)
    x = min(1.0, max(0.0, x))
    return round(255 * (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055))


def above_horizon(sidecar, theta_in, column, row):
    size = sidecar["slice"]
    phi = 2 * math.pi * column / (size["width"] - 1)
    theta = math.pi * min(max(row, 0), size["height"] - 1) / (size["height"] - 1)
    angle = math.radians(theta_in)
    across = -math.sin(angle) * math.sin(theta) * math.cos(phi)
    return across + math.cos(angle) * math.cos(theta) > 0


def draw(slices):
    width, height = slices.width, slices.height
    rows = [[DARK] * width for _ in range(height)]
    size = slices.sidecar["slice"]
    for material in slices.sidecar["materials"]:
        for entry in material["slices"]:
            for r in range(size["height"]):
                for c in range(size["width"]):
                    if above_horizon(slices.sidecar, entry["theta_in_deg"], c, r):
                        x, y = entry["x"] + c, entry["y"] + r
                        rows[y][x] = tuple(shown(math.pi * v) for v in slices.texel(x, y))
    grid = slices.sidecar["grid"]
    across = grid["cell_columns"] * grid["cell_width"]
    down = grid["cell_rows"] * grid["cell_height"]
    for y in range(height):
        for x in range(width):
            if (x and x % across == 0) or (y and y % down == 0):
                rows[y][x] = LINE
    return rows


def write_png(path, rows):
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))
    raw = b"".join(b"\0" + bytes(code for texel in row for code in texel) for row in rows)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n"
                   + chunk(b"IHDR", struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0))
                   + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    with open(sys.argv[1], "rb") as image, open(sys.argv[2], encoding="utf-8") as sidecar:
        write_png(sys.argv[3], draw(Slices(image.read(), json.load(sidecar))))


if __name__ == "__main__":
    main()
