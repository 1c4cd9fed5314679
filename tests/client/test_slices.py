# SPDX-License-Identifier: Apache-2.0
"""`kiln bake` of slices and atlases: files by name or by hash, here and on a server, and
`kiln measure upload`."""
import hashlib
import json
import os
import sys
import unittest

from kiln_cli import SOURCE, KilnTest

sys.path.insert(0, os.path.join(SOURCE, "examples", "measured"))
import make  # noqa: E402

SMALL = {"kind": "slices", "resolution": [37, 19]}


class Slices(KilnTest):
    def setUp(self):
        super().setUp()
        os.mkdir(self.path("files"))
        self.felt = make.csv(make.MATERIALS["felt"]).encode()
        self.id = "sha256:" + hashlib.sha256(self.felt).hexdigest()
        self.write("files/felt.csv", self.felt)
        # Beside the job, wherever kiln is run.
        self.write("files/job.json", {**SMALL, "measured": {"data": "felt.csv"}})
        self.write("by_id.json", {**SMALL, "measured": {"data": self.id}})

    def test_a_file_by_name_by_hash_and_on_a_server_is_the_same_image(self):
        self.kiln("bake", "files/job.json", "--local", "-o", "a.exr")
        self.kiln("bake", "by_id.json", "--local", "--measurement", "files/felt.csv", "-o", "b.exr")
        url = self.serve()
        first = self.kiln("bake", "files/job.json", "--server", url, "-o", "c.exr")[1]
        second = self.kiln("bake", "by_id.json", "--server", url, "-o", "d.exr")[1]
        images = [self.read(name + ".exr") for name in "abcd"]
        self.assertEqual(images, images[:1] * 4)
        sidecars = [json.loads(self.read(name + ".sidecar.json")) for name in "abcd"]
        self.assertEqual(sidecars, sidecars[:1] * 4)
        self.assertEqual(sidecars[0]["materials"][0]["data"], self.id)
        self.assertNotIn("cached", first)
        self.assertIn("cached", second)

    def test_report_and_sidecar_go_where_they_are_told(self):
        self.kiln("bake", "files/job.json", "--local", "-o", "a.png", "--report", "r.json",
                  "--sidecar", "s.json")
        self.assertEqual(self.files(), ["a.png", "by_id.json", "files", "r.json", "s.json"])
        report = json.loads(self.read("r.json"))
        self.assertEqual(report["measured"], json.loads(self.read("s.json")))
        image, _ = self.kiln("bake", "files/job.json", "--local", "-o", "-")
        self.assertEqual(image[:4], b"\x76\x2f\x31\x01")

    def test_what_is_not_at_hand_is_named(self):
        _, stderr = self.kiln("bake", "by_id.json", "--local", "-o", "a.exr", exit_status=2)
        self.assertIn("--measurement", stderr)
        self.assertIn(self.id, stderr)
        self.write("other.csv", self.felt + b"\n")
        _, stderr = self.kiln("bake", "by_id.json", "--local", "-o", "a.exr",
                              "--measurement", "other.csv", exit_status=2)
        self.assertIn("other.csv: the job names no sha256:", stderr)
        self.write("job.json", {**SMALL, "measured": {"data": "nowhere.csv"}})
        _, stderr = self.kiln("bake", "job.json", "--local", "-o", "a.exr", exit_status=2)
        self.assertIn("nowhere.csv", stderr)
        _, stderr = self.kiln("bake", "by_id.json", "--server", self.serve(), "-o", "a.exr",
                              exit_status=3)
        self.assertIn("/measured/data", stderr)

    def test_uploads_print_ids(self):
        url = self.serve()
        stdout, stderr = self.kiln("measure", "upload", "files/felt.csv", "--server", url)
        self.assertEqual(stdout.decode(), self.id + "\n")
        self.assertIn("csv", stderr)
        again, _ = self.kiln("measure", "upload", "files/felt.csv", "--server", url, "--json")
        self.assertEqual(json.loads(again)["measurements"][0]["id"], self.id)
        self.kiln("bake", "by_id.json", "--server", url, "-o", "a.exr")
        self.write("noise.bin", b"\x00\x01\x02" * 50)
        _, stderr = self.kiln("measure", "upload", "noise.bin", "--server", url, exit_status=2)
        self.assertIn("noise.bin", stderr)

    def test_info_reads_packed_colours(self):
        for name in ("a.png", "a.exr"):
            self.kiln("bake", "files/job.json", "--local", "-o", name,
                      "--set", "output.pixel=rgb9e5")
            info = json.loads(self.kiln("info", name, "--json")[0])
            self.assertEqual(info["pixel"], "rgb9e5")
            self.assertIn("red in bits 0-8", info["metadata"]["kiln.pixel"])
            green = next(channel for channel in info["channels"] if channel["name"] == "G")
            # At grazing angles fuzz adds 0.12 (1 - NoH^2) / (NoL + NoV - NoL NoV).
            self.assertTrue(0.16 / 3.1416 < green["max"] < 0.4, green)
            self.assertTrue(any("theta_d" in line for line in info["convention"]))
        self.kiln("bake", "files/job.json", "--local", "-o", "h.exr")
        self.kiln("diff", "h.exr", "h.exr")

    def test_examples_are_what_their_script_writes_and_bake(self):
        folder = os.path.join(SOURCE, "examples")
        for name, f in make.MATERIALS.items():
            with open(os.path.join(folder, "measured", name + ".csv"), encoding="ascii") as file:
                self.assertEqual(file.read(), make.csv(f), "run examples/measured/make.py")
        for job, output in (("slices_lacquer", "a.exr"), ("atlas", "b.png")):
            self.kiln("bake", os.path.join(folder, job + ".json"), "--local", "-o", output,
                      "--set", "resolution=[37,19]")
        for name, size in (("lobe_view", "[64,64]"), ("sphere_view", "[64,64]"),
                           ("companion", "[4]"), ("sampling", "[4,4]")):
            output = name + (".png" if "view" in name else ".exr")
            self.kiln("bake", os.path.join(folder, "measured", name + ".json"), "--local",
                      "-o", output, "--set", "resolution=" + size, "--set", "device=native")
        names = [m["name"] for m in json.loads(self.read("b.sidecar.json"))["materials"]]
        self.assertEqual(names, ["lacquer", "felt"])

    def test_other_commands_refuse_them(self):
        _, stderr = self.kiln("advise", "by_id.json", "--max-error", "0.1", exit_status=3)
        self.assertIn("kind lut alone", stderr)
        _, stderr = self.kiln("furnace", "by_id.json", exit_status=3)
        self.assertIn("/measured", stderr)


if __name__ == "__main__":
    unittest.main()
