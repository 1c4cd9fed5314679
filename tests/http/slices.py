# SPDX-License-Identifier: Apache-2.0
"""What a shader does with an image of slices and its side-car: a PNG's bytes, the bits of RGB9_E5
and the lookup, each written from its own definition and from nothing of the program."""
import math
import struct
import zlib


def png_bytes(data):
    """(width, height, rows of RGBA bytes) of a PNG of four 8-bit channels; ISO 15948."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, size = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        chunk = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", chunk)
            assert (depth, colour, interlace) == (8, 6, 0)
            size = (width, height)
        elif kind == b"IDAT":
            packed += chunk
        at += 12 + length
    raw, stride, rows = zlib.decompress(packed), 4 * size[0], []
    above = bytes(stride)
    for y in range(size[1]):
        line = raw[y * (stride + 1):(y + 1) * (stride + 1)]
        above = unfiltered(line[0], line[1:], above)
        rows.append(above)
    return size[0], size[1], rows


def unfiltered(kind, line, above):
    """One row of a PNG, four bytes a texel."""
    out = bytearray(line)
    for i in range(len(out)):
        a, b, c = (out[i - 4] if i >= 4 else 0), above[i], (above[i - 4] if i >= 4 else 0)
        if kind == 1:
            out[i] = (out[i] + a) & 255
        elif kind == 2:
            out[i] = (out[i] + b) & 255
        elif kind == 3:
            out[i] = (out[i] + (a + b) // 2) & 255
        elif kind == 4:
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            out[i] = (out[i] + nearest) & 255
    return bytes(out)


def rgb9e5(four_bytes):
    """Three colours of a texel: the bytes are those of a 32-bit little-endian word."""
    word = struct.unpack("<I", four_bytes)[0]
    scale = 2.0 ** ((word >> 27) - 24)
    return [((word >> shift) & 511) * scale for shift in (0, 9, 18)]


class Slices:
    """An rgb9e5 PNG with its side-car."""

    def __init__(self, image, sidecar):
        self.width, self.height, self.rows = png_bytes(image)
        self.sidecar = sidecar
        assert (self.width, self.height) == (sidecar["image"]["width"], sidecar["image"]["height"])

    def texel(self, x, y):
        return rgb9e5(self.rows[y][4 * x:4 * x + 4])

    def bilinear(self, u, v):
        """As a texture unit does it: texel i has its centre at i + 0.5."""
        x, y = math.floor(u - 0.5), math.floor(v - 0.5)
        fx, fy = u - 0.5 - x, v - 0.5 - y
        total = [0.0] * 3
        for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
            weight = (fx if dx else 1 - fx) * (fy if dy else 1 - fy)
            if weight:
                texel = self.texel(x + dx, y + dy)
                total = [t + weight * c for t, c in zip(total, texel)]
        return total

    def look_up(self, material, slice_index, theta_out, phi):
        """f_r for the light of a slice; the light has azimuth 0."""
        entry = self.sidecar["materials"][material]["slices"][slice_index]
        angle = math.radians(entry["theta_in_deg"])
        c, s = math.cos(angle), math.sin(angle)
        to, po = math.radians(theta_out), math.radians(phi)
        v = (math.sin(to) * math.cos(po), math.sin(to) * math.sin(po), math.cos(to))
        d = (-c * v[0] - s * v[2], -v[1], -s * v[0] + c * v[2])
        theta_d = math.acos(max(-1.0, min(1.0, d[2])))
        phi_d = math.atan2(d[1], d[0]) % (2 * math.pi)
        size = self.sidecar["slice"]
        return self.bilinear(
            entry["x"] + phi_d / (2 * math.pi) * (size["width"] - 1) + 0.5,
            entry["y"] + theta_d / math.pi * (size["height"] - 1) + 0.5)

    def error(self, material, slice_index, truth, theta_out_max):
        """Integral of |lookup - truth| cos over that of truth cos, green, within theta_out_max."""
        theta_in = self.sidecar["materials"][material]["slices"][slice_index]["theta_in_deg"]
        off = whole = 0.0
        for i in range(20):
            theta = (i + 0.5) * theta_out_max / 20
            weight = math.sin(math.radians(theta)) * math.cos(math.radians(theta))
            for j in range(24):
                phi = (j + 0.35) * 15
                f = truth(theta_in, theta, phi)[1]
                off += weight * abs(self.look_up(material, slice_index, theta, phi)[1] - f)
                whole += weight * f
        return off / whole
