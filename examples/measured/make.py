#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""make.py FOLDER: writes lacquer.csv and felt.csv there, measurements of materials that are formulas.

The layout is the plainest that Kiln reads: one row a pair of directions, angles in degrees, f_r in
1/sr. A goniometer's angles: theta_in 0, 20, 40, 60, theta_out to 75, one half of the azimuths."""
import math
import os
import sys

THETA_IN = (0, 20, 40, 60)


def cosines(theta_in, theta_out, phi):
    """NoL, NoV, NoH, VoH of a light at azimuth 0; degrees."""
    ci, si = math.cos(math.radians(theta_in)), math.sin(math.radians(theta_in))
    co, so = math.cos(math.radians(theta_out)), math.sin(math.radians(theta_out))
    half = math.sqrt(max(0.0, (1 + ci * co + si * so * math.cos(math.radians(phi))) / 2))
    return ci, co, (ci + co) / (2 * half), half


def coated(alpha, f0, diffuse):
    """GGX with height-correlated Smith and Schlick's Fresnel term over a Lambertian base."""
    def f(theta_in, theta_out, phi):
        nol, nov, noh, voh = cosines(theta_in, theta_out, phi)
        a2 = alpha * alpha
        d = a2 / (math.pi * (noh * noh * (a2 - 1) + 1) ** 2)
        v = 0.5 / (nol * math.sqrt(a2 + (1 - a2) * nov * nov)
                   + nov * math.sqrt(a2 + (1 - a2) * nol * nol))
        fresnel = f0 + (1 - f0) * (1 - voh) ** 5
        return [rho / math.pi + d * v * fresnel for rho in diffuse]
    return f


def fibres(sheen, diffuse):
    """A Lambertian base under fuzz that is brightest against the light; reciprocal."""
    def f(theta_in, theta_out, phi):
        nol, nov, noh, _ = cosines(theta_in, theta_out, phi)
        fuzz = sheen * (1 - noh * noh) / (nol + nov - nol * nov)
        return [rho / math.pi + fuzz for rho in diffuse]
    return f


MATERIALS = {"lacquer": coated(0.35, 0.06, (0.30, 0.06, 0.04)),
             "felt": fibres(0.12, (0.05, 0.16, 0.10))}


def csv(f, theta_step=5, phi_step=15, phi_max=180):
    """The text of a file."""
    rows = ["theta_in,phi_in,theta_out,phi_out,r,g,b"]
    for theta_in in THETA_IN:
        for theta_out in range(0, 76, theta_step):
            for phi in range(0, phi_max + 1 if theta_out else 1, phi_step):
                values = ",".join(f"{value:.5g}" for value in f(theta_in, theta_out, phi))
                rows.append(f"{theta_in},0,{theta_out},{phi},{values}")
    return "\n".join(rows) + "\n"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for name, f in MATERIALS.items():
        with open(os.path.join(sys.argv[1], name + ".csv"), "w", encoding="ascii") as file:
            file.write(csv(f))


if __name__ == "__main__":
    main()
