# SPDX-License-Identifier: Apache-2.0
"""Derives the lobes of server/measured/observer.cpp from the CIE's tables.

usage: observer.py DATA [--check OBSERVER_CPP]

DATA holds cie/cie1931_2deg_5nm_d65.csv (wavelength in nm, x, y, z of the 2 degree observer, D65).
What a reflectance is weighed with in each channel of linear sRGB under D65 is fitted by sums of
Gaussians with a width to each side of their middle (the form of Wyman, Sloan and Shirley 2013), by
Levenberg's and Marquardt's least squares from a fixed start. With --check the rows of that file are
compared with the tables instead: the linear sRGB of reflectances that are known. Where DATA is
absent it says so and exits 0.
"""
import math
import os
import re
import sys

from metals import XYZ_TO_SRGB

START = [  # amplitude (1/nm, times 100), middle, width below, width above (nm)
    [(1.9, 605, 30, 32), (0.2, 445, 18, 25), (-0.9, 515, 25, 25), (-0.2, 490, 15, 20),
     (0.3, 575, 20, 25)],
    [(1.2, 545, 30, 35), (-0.3, 445, 18, 22), (-0.3, 620, 20, 25), (0.2, 510, 20, 20),
     (0.2, 570, 20, 20)],
    [(1.6, 448, 15, 25), (0.5, 470, 20, 20), (-0.15, 545, 25, 25), (0.05, 600, 20, 25),
     (0.3, 435, 10, 15)],
]


def read(path):
    with open(path, encoding="ascii") as file:
        rows = [[float(cell) for cell in line.split(",")] for line in file.readlines()[1:]]
    channels = [[sum(m * x for m, x in zip(line, row[1:4])) * row[4] for row in rows]
                for line in XYZ_TO_SRGB]
    nm = [row[0] for row in rows]
    return nm, [[100 * v / sum(one) / (nm[1] - nm[0]) for v in one] for one in channels]


def lobe(p, nm):
    t = (nm - p[1]) / (p[2] if nm < p[1] else p[3])
    return p[0] * math.exp(-t * t / 2)


def total(lobes, nm):
    return sum(lobe(p, nm) for p in lobes)


def solve(a, b):
    """Gauss with pivots."""
    n = len(b)
    rows = [row[:] + [y] for row, y in zip(a, b)]
    for i in range(n):
        k = max(range(i, n), key=lambda j: abs(rows[j][i]))
        rows[i], rows[k] = rows[k], rows[i]
        for j in range(i + 1, n):
            f = rows[j][i] / rows[i][i]
            for c in range(i, n + 1):
                rows[j][c] -= f * rows[i][c]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (rows[i][n] - sum(rows[i][c] * x[c] for c in range(i + 1, n))) / rows[i][i]
    return x


def fit(start, wavelengths, wanted):
    at = [v for p in start for v in p]
    group = lambda flat: [flat[i:i + 4] for i in range(0, len(flat), 4)]
    residual = lambda flat: [total(group(flat), nm) - w for nm, w in zip(wavelengths, wanted)]
    square = lambda flat: sum(r * r for r in residual(flat))
    damping, best = 1e-2, square(at)
    for _ in range(400):
        r = residual(at)
        columns = []
        for i, v in enumerate(at):
            step = 1e-5 * max(1.0, abs(v))
            moved = at[:i] + [v + step] + at[i + 1:]
            columns.append([(a - b) / step for a, b in zip(residual(moved), r)])
        normal = [[sum(x * y for x, y in zip(a, b)) for b in columns] for a in columns]
        gradient = [-sum(x * y for x, y in zip(a, r)) for a in columns]
        for i in range(len(at)):
            normal[i][i] *= 1 + damping
            normal[i][i] += 1e-12
        new = [a + d for a, d in zip(at, solve(normal, gradient))]
        fine = all(5 < new[i] < 200 for j in range(0, len(new), 4) for i in (j + 2, j + 3))
        found = square(new) if fine else math.inf
        if found < best:
            at, best, damping = new, found, damping / 3
        else:
            damping = min(1e6, damping * 4)
    return group(at)


def srgb(weights, wavelengths, reflectance):
    """Linear sRGB of a reflectance; 1 is (1, 1, 1)."""
    return [sum(w * reflectance(nm) for nm, w in zip(wavelengths, row)) / sum(row)
            for row in weights]


def edge(nm, wide=20):
    return lambda at: 1 / (1 + math.exp(-(at - nm) / wide))


PROBES = {"red": edge(590), "orange": edge(560), "yellow": edge(510),
          "blue": lambda nm: 1 - edge(490)(nm),
          "green": lambda nm: edge(490)(nm) * (1 - edge(570)(nm)),
          "magenta": lambda nm: 1 - edge(490)(nm) * (1 - edge(590)(nm)),
          "ripples": lambda nm: 0.5 + 0.4 * math.sin(nm / 15)}


def compare(lobes, wavelengths, tables):
    smooth = [[total(one, nm) for nm in wavelengths] for one in lobes]
    worst = 0
    for name, f in PROBES.items():
        truth, ours = srgb(tables, wavelengths, f), srgb(smooth, wavelengths, f)
        worst = max(worst, max(abs(a - b) for a, b in zip(truth, ours)))
        print(f"{name:8}", *(f"{v:8.4f}" for v in truth), " by lobes", *(f"{v:8.4f}" for v in ours))
    print(f"worst {worst:.4f}")
    return worst


def main():
    path = os.path.join(sys.argv[1], "cie", "cie1931_2deg_5nm_d65.csv")
    if not os.path.exists(path):
        print("no tables of the CIE in " + sys.argv[1])
        return 0
    wavelengths, tables = read(path)
    if len(sys.argv) > 3 and sys.argv[2] == "--check":
        with open(sys.argv[3], encoding="ascii") as file:
            rows = re.findall(r"\{(-?[\d.]+), ([\d.]+), ([\d.]+), ([\d.]+)\}", file.read())
        assert len(rows) == 15, rows
        flat = [[float(v) for v in row] for row in rows]
        return compare([flat[0:5], flat[5:10], flat[10:15]], wavelengths, tables) > 0.005
    lobes = [[[round(v, 4) if i == 0 else round(v, 2) for i, v in enumerate(p)] for p in
              fit(start, wavelengths, wanted)] for start, wanted in zip(START, tables)]
    for one in lobes:
        for p in one:
            print("      {" + ", ".join(f"{v:g}" for v in p) + "},")
    compare(lobes, wavelengths, tables)
    return 0


if __name__ == "__main__":
    sys.exit(main())
