# SPDX-License-Identifier: Apache-2.0
"""Derives the rows of server/spec/metals.cpp from measured optical constants.

usage: metals.py DATA [--check METALS_CPP]

DATA holds nk/ELEMENT/nk/AUTHOR.yml (refractiveindex.info, CC0: wavelength in micrometres, n, k) and
cie/cie1931_2deg_5nm_d65.csv. With --check, compares with the rows of that file instead of printing
them. Where DATA is absent it says so and exits 0.

One channel of a baked table is one curve F(VoH). What the eye sees of the metal at one angle is the
colour C(u) of its spectrum of reflectances F(lambda, u) under D65, in linear sRGB; so the three
curves to bake are C_r(u), C_g(u) and C_b(u). A pair (eta, k) has two degrees of freedom: they are
spent on C(1), the colour at normal incidence, and on 2 int C(u) u du, the hemispherical average,
from which albedos of rough metals and their multiple scattering follow. An average of n and of k
over wavelength (the usual shortcut) matches neither.

A colour outside of sRGB can ask for more than any pair gives: gold's red is 1.037. A channel that
asks for more than the metal reflects at any wavelength from 400 to 700 nm gets the measured pair of
the wavelength that it reflects best; the other channels stay exact. Moving the whole colour towards
grey instead would keep its luminance, but raise gold's blue by a quarter.
"""
import cmath
import math
import os
import re
import sys

METALS = [  # name, file, source
    ("aluminium", "Al/nk/Rakic.yml", "Rakic 1995"),
    ("chromium", "Cr/nk/Johnson.yml", "Johnson and Christy 1974"),
    ("copper", "Cu/nk/Johnson.yml", "Johnson and Christy 1972"),
    ("gold", "Au/nk/Johnson.yml", "Johnson and Christy 1972"),
    ("iron", "Fe/nk/Johnson.yml", "Johnson and Christy 1974"),
    ("nickel", "Ni/nk/Johnson.yml", "Johnson and Christy 1974"),
    ("platinum", "Pt/nk/Rakic-LD.yml", "Rakic et al. 1998"),
    ("silver", "Ag/nk/Johnson.yml", "Johnson and Christy 1972"),
    ("titanium", "Ti/nk/Johnson.yml", "Johnson and Christy 1974"),
    ("tungsten", "W/nk/Weaver.yml", "Weaver et al. 1975"),
]
XYZ_TO_SRGB = [  # IEC 61966-2-1
    [3.2406, -1.5372, -0.4986],
    [-0.9689, 1.8758, 0.0415],
    [0.0557, -0.2040, 1.0570],
]


def fresnel(eps, u):
    """Unpolarised reflectance from the amplitudes of Born and Wolf."""
    root = cmath.sqrt(eps - (1 - u) * (1 + u))
    s = (u - root) / (u + root)
    p = (eps * u - root) / (eps * u + root)
    return (abs(s) ** 2 + abs(p) ** 2) / 2


def gauss_legendre(count):
    """Nodes and weights on [0, 1]."""
    rule = []
    for i in range(count):
        x = math.cos(math.pi * (i + 0.75) / (count + 0.5))
        for _ in range(100):
            before, p = 1.0, x
            for degree in range(2, count + 1):
                before, p = p, ((2 * degree - 1) * x * p - (degree - 1) * before) / degree
            slope = count * (x * p - before) / (x * x - 1)
            x -= p / slope
            if abs(p / slope) < 1e-16:
                break
        rule.append(((1 + x) / 2, 1 / ((1 - x * x) * slope * slope)))
    return rule


RULE = gauss_legendre(48)  # F of a metal is smooth: 48 and 96 nodes agree to 1e-12 here


def average(curve):
    return 2 * sum(weight * u * curve(u) for u, weight in RULE)


def read_cie(path):
    with open(path, encoding="utf-8") as lines:
        rows = [[float(cell) for cell in line.split(",")] for line in list(lines)[1:]]
    white_y = sum(row[2] * row[4] for row in rows)
    grey = [sum(row[1 + i] * row[4] for row in rows) / white_y for i in range(3)]
    white = [sum(row[i] * grey[i] for i in range(3)) for row in XYZ_TO_SRGB]
    # The weight of a wavelength in each linear sRGB channel; a flat reflectance of 1 is (1, 1, 1).
    weights = []
    for nm, *xyz, light in rows:
        scaled = [value * light / white_y for value in xyz]
        weights.append((nm, [sum(row[i] * scaled[i] for i in range(3)) / one
                             for row, one in zip(XYZ_TO_SRGB, white)]))
    return weights


def read_nk(path):
    with open(path, encoding="utf-8") as lines:
        cells = [line.split() for line in lines if re.match(r"\s+[\d.]+(E[-+]?\d+)?\s", line, re.I)]
    return [(1000 * float(um), complex(float(n), float(k))) for um, n, k in cells]


def at(table, nm):
    for (a, left), (b, right) in zip(table, table[1:]):
        if a <= nm <= b:
            return left + (right - left) * (nm - a) / (b - a)
    raise ValueError(f"no optical constants at {nm} nm")


class Spectrum:
    """The linear sRGB colour of a metal at any angle."""

    def __init__(self, table, cie):
        self.lines = [(at(table, nm) ** 2, rgb) for nm, rgb in cie]
        self.best = max((at(table, nm) for nm in range(400, 701, 5)),
                        key=lambda index: fresnel(index ** 2, 1))

    def colour(self, u):
        reflected = [fresnel(eps, u) for eps, _ in self.lines]
        return [sum(f * rgb[c] for f, (_, rgb) in zip(reflected, self.lines)) for c in range(3)]


def pair_of(eta, f0):
    """The k that makes F(1) = f0 at this eta."""
    return math.sqrt(max(0.0, ((eta + 1) ** 2 * f0 - (eta - 1) ** 2) / (1 - f0)))


def solve(f0, f_avg):
    """(eta, k) with F(1) = f0 and 2 int F u du = f_avg."""
    root = math.sqrt(f0)
    low, high = (1 - root) / (1 + root), (1 + root) / (1 - root)

    def off(eta):
        eps = complex(eta, pair_of(eta, f0)) ** 2
        return average(lambda u: fresnel(eps, u)) - f_avg

    grid = [low * (high / low) ** (i / 60) for i in range(61)]
    values = [off(eta) for eta in grid]
    for a, b, value, following in zip(grid, grid[1:], values, values[1:]):
        if value * following > 0:
            continue
        for _ in range(60):
            middle = (a + b) / 2
            a, b = (middle, b) if off(middle) * value > 0 else (a, middle)
        return a, pair_of(a, f0)
    raise ValueError(f"no pair has F(1) = {f0} and the average {f_avg}")


def derive(path, cie):
    """Three pairs, the colour at normal incidence, and how far the curves of the pairs are from the
    metal's own at the worst angle, channels above gamut left out."""
    spectrum = Spectrum(read_nk(path), cie)
    f0 = spectrum.colour(1)
    colours = [(weight * u, spectrum.colour(u)) for u, weight in RULE]
    angles = [(i / 40, spectrum.colour(i / 40)) for i in range(1, 41)]
    pairs, worst = [], 0.0
    for c in range(3):
        if f0[c] > fresnel(spectrum.best ** 2, 1):
            pairs.append((spectrum.best.real, spectrum.best.imag))
            continue
        pairs.append(solve(f0[c], 2 * sum(weight * rgb[c] for weight, rgb in colours)))
        eps = complex(*pairs[c]) ** 2
        worst = max(worst, *(abs(fresnel(eps, u) - rgb[c]) for u, rgb in angles))
    return pairs, f0, worst


def row(name, source, pairs, f0):
    def three(values, digits):
        return "{{" + ", ".join(f"{value:.{digits}f}" for value in values) + "}}"
    return (f"    {{Metal::{name}, {three([eta for eta, _ in pairs], 5)}, "
            f"{three([k for _, k in pairs], 5)}, {three(f0, 4)}, \"{source}\"}},")


def main(arguments):
    if len(arguments) not in (1, 3) or (len(arguments) == 3 and arguments[1] != "--check"):
        print(__doc__.split("\n\n")[1], file=sys.stderr)
        return 2
    data = arguments[0]
    if not os.path.isdir(os.path.join(data, "nk")):
        print(f"skipped: no optical constants in {data}", file=sys.stderr)
        return 0
    cie = read_cie(os.path.join(data, "cie", "cie1931_2deg_5nm_d65.csv"))
    rows = []
    for name, path, source in METALS:
        pairs, f0, worst = derive(os.path.join(data, "nk", path), cie)
        rows.append(row(name, source, pairs, f0))
        print(f"{name}: within {worst:.4f} at every angle", file=sys.stderr)
    if len(arguments) == 1:
        print("\n".join(rows))
        return 0
    with open(arguments[2], encoding="utf-8") as file:
        kept = re.sub(r"\s+", "", file.read())
    stale = [line for line in rows if re.sub(r"\s+", "", line) not in kept]
    for line in stale:
        print(f"not in {arguments[2]}:\n{line}")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
