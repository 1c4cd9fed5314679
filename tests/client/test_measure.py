# SPDX-License-Identifier: Apache-2.0
"""`kiln measure`: what a file says, and the image that is made of it."""
import json
import math
import struct
import unittest

from kiln_cli import KilnTest

RHO = 0.6


def lambertian():
    """A grid of constant values: f = RHO / pi under two incidences."""
    lines = ["theta_in,phi_in,theta_out,phi_out,r,g,b"]
    for theta_in in (0, 60):
        for theta_out in range(0, 90, 5):
            for phi_out in range(0, 360, 15):
                value = RHO / math.pi
                lines.append(f"{theta_in},0,{theta_out},{phi_out},{value},{value / 2},{value / 4}")
    return "\n".join(lines) + "\n"


class Measure(KilnTest):
    def test_info_says_what_the_file_says(self):
        self.write("paint.csv", lambertian())
        stdout, stderr = self.kiln("measure", "info", "paint.csv")
        self.assertEqual(stderr, "")
        for words in ("paint.csv  csv", "convention: f (", "reflection front: 864 points", "albedo R"):
            self.assertIn(words, stdout.decode())

    def test_info_as_json_holds_the_albedo(self):
        self.write("paint.csv", lambertian())
        account = json.loads(self.kiln("measure", "info", "paint.csv", "--json")[0])
        part = account["components"][0]
        self.assertEqual([one["theta_in_deg"] for one in part["incidences"]], [0, 60])
        for one in part["incidences"]:
            # A constant is integrated exactly over what was measured, in floats.
            self.assertAlmostEqual(one["albedo"][0], RHO * one["coverage"], delta=1e-6)
            self.assertAlmostEqual(one["albedo"][2], RHO / 4 * one["coverage"], delta=1e-6)
            # The 24-gon inside the circle of sin 85.
            polygon = 12 / math.pi * math.sin(math.pi / 12) * math.sin(math.radians(85)) ** 2
            self.assertAlmostEqual(one["coverage"], polygon, delta=1e-5)
        self.assertLess(part["reciprocity"]["p95"], 1e-6)

    def test_a_wrong_file_is_refused_with_its_line(self):
        self.write("paint.csv", lambertian() + "1,2,x\n")
        _, stderr = self.kiln("measure", "info", "paint.csv", exit_status=2)
        self.assertIn("line 866: field 3, \"x\", is no finite number", stderr)
        self.write("noise.bin", b"\x00\x01\x02" * 50)
        _, stderr = self.kiln("measure", "info", "noise.bin", exit_status=2)
        self.assertIn("no format that is read", stderr)

    def test_two_azimuths_of_one_measurement_are_an_atlas(self):
        """A surface twice as bright for light along x: phi_in 0, 90 and the mean of both."""
        rows = ["theta_in,phi_in,theta_out,phi_out,value"]
        for theta_in in (0, 60):
            for phi_in in range(0, 360, 90):
                for theta_out in range(0, 90, 5):
                    for phi_out in range(0, 360, 15):
                        value = 0.1 if theta_in and phi_in % 180 else 0.2
                        rows.append(f"{theta_in},{phi_in},{theta_out},{phi_out},{value}")
        self.write("brushed.csv", "\n".join(rows) + "\n")
        self.write("job.json", json.dumps({
            "kind": "atlas", "resolution": [19, 10], "device": "native",
            "measured": {"theta_in": [60], "data": [
                {"data": "brushed.csv", "phi_in": 0}, {"data": "brushed.csv", "phi_in": 90},
                "brushed.csv"]}}))
        self.kiln("bake", "job.json", "-o", "atlas.exr", "--local")
        materials = json.loads(self.read("atlas.sidecar.json"))["materials"]
        self.assertEqual([one["phi_in_deg"] for one in materials], [0, 90, None])
        self.assertEqual([one["azimuths"]["measured"] for one in materials], [4, 4, 4])
        albedos = [one["slices"][0]["directional_albedo"]["rgb"][0] for one in materials]
        for albedo, value in zip(albedos, (0.2, 0.1, 0.15)):
            self.assertAlmostEqual(albedo, math.pi * value, delta=0.002)
        # Off by 0.05 of 0.15 under 60 degrees, by nothing of 0.2 under 0.
        self.assertAlmostEqual(materials[2]["azimuths"]["spread"], 1 / 7, delta=0.001)
        self.assertTrue(any("the material turns" in one for one in materials[2]["warnings"]))
        # What was measured under one azimuth is not known under another.
        self.write("paint.csv", lambertian())
        _, stderr = self.kiln("measure", "view", "paint.csv", "-o", "lobe.png", "--phi-in", "30",
                              exit_status=2)
        self.assertIn("at theta_in = 60 no light was measured on both sides of phi_in = 30", stderr)

    def test_slices_of_two_materials_are_an_atlas(self):
        self.write("paint.csv", lambertian())
        stdout, _ = self.kiln("measure", "slices", "paint.csv", "paint.csv", "-o", "atlas.exr",
                              "--sidecar", "atlas.json", "--width", "37", "--height", "19",
                              "--gutter", "1", "--theta-in", "0,30,60")
        self.assertEqual(stdout, b"")
        sidecar = json.loads(self.read("atlas.json"))
        # Three slices in rows of two, two cells in each, and a gutter around every cell.
        self.assertEqual(sidecar["image"], {"width": 2 * 2 * 39, "height": 2 * 1 * 21})
        self.assertEqual([m["name"] for m in sidecar["materials"]], ["paint.csv", "paint.csv"])
        for material in sidecar["materials"]:
            texels = material["texels"]
            shares = [texels[k] for k in
                      ("measured_share", "interpolated_share", "extrapolated_share")]
            self.assertAlmostEqual(sum(shares), 1, delta=1e-9)
            for one in material["slices"]:
                # The quadrature's own error: the horizon cuts rings of a degree.
                self.assertAlmostEqual(one["directional_albedo"]["rgb"][0], RHO, delta=0.005)
        info = json.loads(self.kiln("info", "atlas.exr", "--json")[0])
        self.assertEqual([c["name"] for c in info["channels"]], ["R", "G", "B", "A"])

    def test_slices_say_of_themselves_what_a_job_does(self):
        """And are its bytes: both ways make one file."""
        self.write("paint.csv", lambertian())
        self.kiln("measure", "slices", "paint.csv", "-o", "a.exr", "--width", "19",
                  "--height", "10", "--theta-in", "0,40", "--sidecar", "a.json")
        self.write("job.json", {"kind": "slices", "resolution": [19, 10],
                                "measured": {"data": "paint.csv", "name": "paint.csv",
                                             "theta_in": [0, 40]}})
        _, stderr = self.kiln("bake", "job.json", "--local", "-o", "b.exr")
        self.assertEqual(self.read("a.exr"), self.read("b.exr"))
        self.assertEqual(self.read("a.json"), self.read("b.sidecar.json"))
        # The line under a bake has the image's size, not a slice's.
        self.assertIn("38 x 10 half", stderr)
        metadata = json.loads(self.kiln("info", "a.exr", "--json")[0])["metadata"]
        self.assertIn("theta_in 0 40 degrees", metadata["kiln.slices"])

    def test_views(self):
        self.write("paint.csv", lambertian())
        _, stderr = self.kiln("measure", "view", "paint.csv", "--size", "128", "-o", "lobe.png")
        self.assertEqual(stderr, "")
        self.assertEqual(struct.unpack(">II", self.read("lobe.png")[16:24]), (128, 96))
        _, stderr = self.kiln("measure", "view", "paint.csv", "--size", "64", "-o", "lobe.png",
                              "--theta-in", "72.5")
        self.assertIn("theta_in 72.5 degrees lies outside the measured 0 to 60", stderr)
        self.kiln("measure", "view", "paint.csv", "--size", "64", "-o", "ball.png", "--sphere")
        self.assertEqual(struct.unpack(">II", self.read("ball.png")[16:24]), (64, 64))
        _, stderr = self.kiln("measure", "view", "paint.csv", "-o", "a.png", "--sphere",
                              "--theta-in", "30", exit_status=2)
        self.assertIn("--theta-in is of a lobe", stderr)

    def test_fits_tell_where_they_miss(self):
        self.write("paint.csv", lambertian())
        stdout, _ = self.kiln("measure", "fit", "paint.csv", "--error-map", "e.exr", "--json")
        fit = json.loads(stdout)["fits"][0]
        self.assertAlmostEqual(fit["diffuse"][0], RHO, delta=0.01 * RHO)
        info = json.loads(self.kiln("info", "e.exr", "--json")[0])
        # Two incidences, one over the other; GGX fits what is Lambertian.
        self.assertEqual(info["resolution"], [361, 362])
        for channel in info["channels"]:
            self.assertLess(max(abs(channel["min"]), abs(channel["max"])), 0.02)
        self.kiln("measure", "fit", "paint.csv", "--error-map", "e.png")
        self.assertEqual(struct.unpack(">II", self.read("e.png")[16:24]), (2 * 361 + 8, 362 + 40))
        _, stderr = self.kiln("measure", "fit", "paint.csv", "--error-map", "e.tif", exit_status=2)
        self.assertIn("--error-map: name a file", stderr)

    def test_fits_are_of_one_azimuth_or_of_the_mean(self):
        """A Lambertian surface twice as bright for light along x."""
        rows = ["theta_in,phi_in,theta_out,phi_out,value"]
        for phi_in in range(0, 360, 90):
            for theta_out in range(0, 90, 10):
                for phi_out in range(0, 360, 30):
                    value = 0.1 if phi_in % 180 else 0.2
                    rows.append(f"60,{phi_in},{theta_out},{phi_out},{value}")
        self.write("brushed.csv", "\n".join(rows) + "\n")
        for arguments, value in ((["--phi-in", "0"], 0.2), (["--phi-in", "90"], 0.1), ([], 0.15)):
            stdout, _ = self.kiln("measure", "fit", "brushed.csv", "--json", *arguments)
            fit = json.loads(stdout)["fits"][0]
            self.assertAlmostEqual(fit["diffuse"][0], math.pi * value, delta=0.01)
        _, stderr = self.kiln("measure", "fit", "brushed.csv", "--phi-in", "400", exit_status=2)
        self.assertIn("--phi-in", stderr)

    def test_companions_and_samplers_are_baked_from_files(self):
        self.write("paint.csv", lambertian())
        self.write("job.json", {"kind": "companion", "measured": {"data": "paint.csv"}})
        self.kiln("bake", "job.json", "--local", "-o", "c.exr")
        red = json.loads(self.kiln("info", "c.exr", "--json")[0])
        self.assertEqual(red["resolution"], [64, 1])
        self.assertAlmostEqual(red["channels"][0]["mean"], RHO, delta=1e-3)
        self.kiln("bake", "job.json", "--local", "-o", "s.exr", "--set", "kind=sampling")
        self.kiln("bake", "job.json", "--local", "-o", "v.png", "--set", "kind=sphere_view")
        self.assertEqual(self.read("v.png")[:4], b"\x89PNG")
        self.assertIn("c.sidecar.json", self.files())

    def test_wrong_arguments_are_told(self):
        self.write("paint.csv", lambertian())
        for arguments in (["--theta-in", "60,30"], ["--theta-in", "95"]):
            _, stderr = self.kiln("measure", "slices", "paint.csv", "-o", "a.exr", *arguments,
                                  exit_status=2)
            self.assertIn("rising angles from 0 to 90", stderr)
        _, stderr = self.kiln("measure", "slices", "paint.csv", "-o", "a.tif", exit_status=2)
        self.assertIn(".exr or .png", stderr)


if __name__ == "__main__":
    unittest.main()
