# SPDX-License-Identifier: Apache-2.0
"""`kiln info`, `kiln diff`, `kiln devices`."""
import json
import struct
import unittest
import zlib

from kiln_cli import JOB, KilnTest


def png(width, height, rows):
    """A foreign 8-bit grey PNG, written from the PNG specification."""
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data +
                struct.pack(">I", zlib.crc32(kind + data)))
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    data = b"".join(b"\0" + bytes(row) for row in rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) +
            chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b""))


def exr(width, height, values):
    """A foreign one-channel float EXR without compression, written from the OpenEXR file layout."""
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(data)) + data
    box = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    channels = b"Y\0" + struct.pack("<iBBBBii", 2, 0, 0, 0, 0, 1, 1) + b"\0"
    header = b"".join((
        attribute(b"channels", b"chlist", channels), attribute(b"compression", b"compression", b"\0"),
        attribute(b"dataWindow", b"box2i", box), attribute(b"displayWindow", b"box2i", box),
        attribute(b"lineOrder", b"lineOrder", b"\0"),
        attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        attribute(b"screenWindowCenter", b"v2f", struct.pack("<ff", 0, 0)),
        attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)), b"\0"))
    start = b"\x76\x2f\x31\x01" + struct.pack("<I", 2) + header
    offsets, lines = b"", b""
    for y in range(height):
        offsets += struct.pack("<Q", len(start) + 8 * height + len(lines))
        row = struct.pack(f"<{width}f", *values[y * width:(y + 1) * width])
        lines += struct.pack("<iI", y, len(row)) + row
    return start + offsets + lines


class Info(KilnTest):
    def test_tells_everything_of_a_table(self):
        self.bake_local("out.exr", dict(JOB, output={"pixel": "float"}))
        text = self.kiln("info", "out.exr")[0].decode()
        info = json.loads(self.kiln("info", "out.exr", "--json")[0])
        self.assertEqual((info["format"], info["pixel"], info["resolution"]), ("exr", "float", [16, 8]))
        self.assertEqual([c["name"] for c in info["channels"]], ["R", "G"])
        for channel in info["channels"]:  # scale and bias are parts of an albedo
            self.assertTrue(0 <= channel["min"] < channel["mean"] < channel["max"] <= 1.001, channel)
        self.assertGreater(len(info["convention"]), 5)
        told = ("kiln.alpha_mapping", "kiln.axes", "kiln.channels")  # by the convention
        for key, value in info["metadata"].items():
            self.assertEqual(key in text, key not in told, key)
            self.assertEqual(all(line in info["convention"] for line in value.splitlines()),
                             key in told, key)
        for line in (*info["convention"], "16 x 8 float, exr"):
            self.assertEqual(text.count(line), 1, line)
        self.assertTrue(all(key.startswith("kiln.") for key in info["metadata"]))

    def test_figures_of_a_foreign_png(self):
        self.write("a.png", png(3, 2, [[0, 51, 102], [153, 204, 255]]))
        info = json.loads(self.kiln("info", "a.png", "--json")[0])
        self.assertEqual(info["resolution"], [3, 2])
        channel = info["channels"][0]
        self.assertEqual((channel["min"], channel["max"]), (0, 1))
        self.assertAlmostEqual(channel["mean"], 0.5, delta=1e-7)  # float rounding of multiples of 0.2
        self.assertEqual((info["convention"], info["metadata"]), ([], {}))
        self.assertIn("no Kiln metadata", self.kiln("info", "a.png")[0].decode())

    def test_counts_what_is_no_number(self):
        nan, inf = float("nan"), float("inf")
        self.write("a.exr", exr(3, 2, [1, nan, 3, inf, nan, -inf]))
        channel = json.loads(self.kiln("info", "a.exr", "--json")[0])["channels"][0]
        self.assertEqual(channel, {"name": "Y", "min": 1, "max": 3, "mean": 2, "nan_count": 2,
                                   "infinite_count": 2})
        self.write("b.exr", exr(1, 1, [nan]))
        channel = json.loads(self.kiln("info", "b.exr", "--json")[0])["channels"][0]
        self.assertEqual((channel["min"], channel["mean"]), (None, None))

    def test_reads_standard_input(self):
        text = self.kiln("info", "-", "--json", stdin=png(1, 1, [[255]]))[0]
        self.assertEqual(json.loads(text)["resolution"], [1, 1])

    def test_a_damaged_file_is_named(self):
        self.write("a.png", png(3, 2, [[0] * 3, [1] * 3])[:40])
        stdout, stderr = self.kiln("info", "a.png", "--json", exit_status=2)
        self.assertEqual(json.loads(stdout)["code"], "cannot_decode")
        self.assertIn("a.png", stderr)


class Diff(KilnTest):
    def difference(self, a, b, *arguments, exit_status):
        self.write("a.exr", exr(3, 2, a))
        self.write("b.exr", exr(3, 2, b))
        text = self.kiln("diff", "a.exr", "b.exr", *arguments, exit_status=exit_status)[0].decode()
        json_text = self.kiln("diff", "a.exr", "b.exr", "--json", *arguments, exit_status=exit_status)[0]
        return text, json.loads(json_text)["channels"]["Y"]

    def test_equal(self):
        inf = float("inf")
        _, channel = self.difference([0, 1, 2, 3, inf, -inf], [0, 1, 2, 3, inf, -inf], exit_status=0)
        self.assertEqual((channel["max"], channel["rms"], channel["incomparable_count"]), (0, 0, 0))

    def test_says_how_much_and_where(self):
        a, b = [0, 0, 0, 0, 0, 0], [0, -0.25, 0, 0, 0, 0.5]
        text, channel = self.difference(a, b, exit_status=6)
        self.assertEqual((channel["max"], channel["texel"], channel["values"]), (0.5, [2, 1], [0, 0.5]))
        # √((1/16 + 1/4) / 6), in double but for the last places
        self.assertAlmostEqual(channel["rms"], (0.3125 / 6)**0.5, delta=1e-15)
        self.assertIn("2, 1", text)
        self.assertIn("5.0e-01", text)

    def test_the_bound_is_the_largest_that_passes(self):
        a, b = [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0.5, 0]
        self.difference(a, b, "--max-error", "0.5", exit_status=0)
        self.difference(a, b, "--max-error", "0.4999999", exit_status=6)

    def test_nan_is_never_equal(self):
        nan, inf = float("nan"), float("inf")
        for a, b in ((nan, nan), (nan, 0), (0, nan), (inf, -inf), (inf, 0)):
            text, channel = self.difference([9, 0, 0, 0, a, 0], [8, 0, 0, 0, b, 0], "--max-error", "1e30",
                                            exit_status=6)
            self.assertEqual((channel["incomparable_count"], channel["texel"]), (1, [1, 1]))
            self.assertIn("NaN", text)

    def test_other_sizes_and_channels_are_different(self):
        self.write("a.exr", exr(3, 2, [0] * 6))
        self.write("b.exr", exr(2, 3, [0] * 6))
        self.assertIn(b"3 x 2", self.kiln("diff", "a.exr", "b.exr", exit_status=6)[0])
        self.bake_local("c.exr", dict(JOB, resolution=[3, 2]))
        stdout, _ = self.kiln("diff", "a.exr", "c.exr", "--json", "--max-error", "9", exit_status=6)
        self.assertIn("channels", json.loads(stdout)["mismatch"])

    def test_formats_may_differ(self):
        # Of two quantities too, beside which a PNG has a third channel that is none.
        for quantities in (JOB["quantities"], [*JOB["quantities"], "directional_albedo"]):
            job = dict(JOB, quantities=quantities)
            self.bake_local("a.exr", dict(job, output={"pixel": "float"}))
            self.bake_local("a.png", dict(job, output={"format": "png"}))
            # 16-bit levels are 1/65535 apart and rounded to the nearest; 1e-9 for floats on the way.
            bound = str(0.5 / 65535 + 1e-9)
            self.kiln("diff", "a.exr", "a.png", "--max-error", bound, exit_status=0)
            self.kiln("diff", "a.exr", "a.png", exit_status=6)


class Devices(KilnTest):
    def test_native_is_there_and_tells_its_numerics(self):
        found = json.loads(self.kiln("devices", "--json")[0])["devices"]
        native = [device for device in found if device["backend"] == "native" and device["usable"]]
        self.assertTrue(native)
        self.assertGreater(native[0]["compute_units"], 0)
        text = self.kiln("devices")[0].decode()
        for device in found:
            self.assertIn(device["name"], text)
        self.bake_local("out.exr")
        info = json.loads(self.kiln("info", "out.exr", "--json")[0])
        self.assertIn(info["metadata"]["kiln.numerics"], [device["numerics"] for device in native])


if __name__ == "__main__":
    unittest.main()
