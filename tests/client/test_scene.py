# SPDX-License-Identifier: Apache-2.0
"""`kiln plan` and `kiln bake --scene`."""
import hashlib
import json
import math
import os
import re
import unittest
import urllib.request

from kiln_cli import SOURCE, KilnTest

# Small, native, and quick to prove: no sheen, whose full set takes a second.
SMALL = ("--set", "resolution=9", "--set", "sample_count=256", "--set", "device=native")
QUICK = ("--no-proof",)  # whose fine tables take this process most of a second
STEEL = {"name": "steel", "lobes": ["metal"], "roughness": 0.4, "metal_f0": [0.56, 0.57, 0.58]}
PAINT = {"name": "paint", "lobes": ["dielectric", "diffuse"], "roughness": [0.5, 0.75]}


class Plan(KilnTest):
    def test_for_people_and_for_programs(self):
        self.write("scene.json", {"materials": [STEEL, PAINT]})
        text = self.kiln("plan", "scene.json")[0].decode()
        for words in ("specular_2", "0.5 to 0.75", "sheen albedo",
                      "Lambert's albedo is the base colour", "without looking at the scene"):
            self.assertIn(words, text)
        plan = json.loads(self.kiln("plan", "scene.json", "--json", *SMALL)[0])
        self.assertEqual([t["name"] for t in plan["tables"]], ["specular", "average", "specular_2"])
        self.assertEqual(plan["options"]["resolution"], 9)
        self.assertEqual(plan["tables"][0]["job"]["resolution"], [9, 1])

    def test_materials_that_are_not_used_are_named(self):
        self.write("scene.json", {"materials": [STEEL, dict(PAINT, name="rust", used=False)]})
        text = self.kiln("plan", "scene.json")[0].decode()
        self.assertIn("1 more unused", text)
        self.assertIn("not used\n  rust\n      the list says that nothing uses it", text)

    def test_standard_input(self):
        plan = json.loads(self.kiln("plan", "-", "--json",
                                    stdin=json.dumps({"materials": [STEEL]}).encode())[0])
        self.assertEqual(len(plan["tables"]), 2)

    def test_what_is_wrong_is_named(self):
        self.write("scene.json", {"materials": [{"lobes": ["metal"], "roughness": 7}]})
        stdout, stderr = self.kiln("plan", "scene.json", "--json", exit_status=3)
        problem = json.loads(stdout)
        self.assertEqual(problem["code"], "invalid_scene")
        self.assertEqual(problem["problems"][0]["pointer"], "/materials/0/roughness")
        self.assertIn("the scene is not valid", stderr)
        self.write("scene.json", {"materials": [STEEL]})
        for setting in ("resolution=0", "colour=red", "resolution"):
            self.kiln("plan", "scene.json", "--set", setting, exit_status=2)
        self.kiln("plan", "missing.gltf", exit_status=2)

    def test_names_cannot_steer_the_terminal(self):
        self.write("scene.gltf", {"asset": {"version": "2.0"}, "extensionsRequired": ["\u001b[2J"],
                                  "meshes": [{"primitives": [{}]}]})
        self.assertNotIn(b"\x1b", self.kiln("plan", "scene.gltf")[0])

    def test_nothing_beside_the_file_is_read(self):
        self.write("rough.png", b"not looked at")
        self.write("scene.gltf", {
            "asset": {"version": "2.0"}, "meshes": [{"primitives": [{"material": 0}]}],
            "textures": [{"source": 0}], "images": [{"uri": "rough.png"}],
            "materials": [{"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}}]})
        text = self.kiln("plan", "scene.gltf")[0].decode()
        self.assertIn('"rough.png") is not in the document', text.replace("\\", ""))


class BakeScene(KilnTest):
    def bake(self, *materials, arguments=(), exit_status=0):
        self.write("scene.json", {"materials": list(materials)})
        self.kiln("bake", "--scene", "scene.json", "-o", "out", "--local", *SMALL, *arguments,
                  exit_status=exit_status)
        return json.loads(self.read("out/manifest.json")), json.loads(self.read("out/report.json"))

    def info(self, name):
        return json.loads(self.kiln("info", f"out/{name}", "--json")[0])

    def test_a_folder_of_tables_a_manifest_and_a_report(self):
        manifest, report = self.bake(STEEL, PAINT, arguments=QUICK)
        self.assertEqual(sorted(os.listdir(self.path("out"))),
                         ["average.exr", "manifest.json", "report.json", "specular.exr",
                          "specular_2.exr"])
        for table in manifest["tables"]:
            bytes_ = self.read("out/" + table["file"])
            self.assertEqual(hashlib.sha256(bytes_).hexdigest(), table["sha256"])
            info = self.info(table["file"])
            self.assertEqual(hashlib.sha256(b"kiln/job/1\n" + info["metadata"]["kiln.job"].encode())
                             .hexdigest(), table["id"])
        reads = manifest["materials"][0]["reads"][0]
        self.assertEqual((reads["table"], reads["average"]), ("specular", "average"))
        work = sum(t["report"]["work"]["brdf_evaluations"] for t in report["tables"])
        self.assertEqual(report["work"]["brdf_evaluations"], work)
        plan = json.loads(self.kiln("plan", "scene.json", "--json", *SMALL)[0])
        self.assertEqual(work, plan["estimate"]["evaluations"])

    def test_the_proof_covers_every_lobe_and_is_small(self):
        _, report = self.bake(STEEL, PAINT)
        lobes = [(p["material"], p["lobe"]) for p in report["proof"]["lobes"]]
        self.assertEqual(lobes, [(0, "metal"), (1, "dielectric")])
        for proof in report["proof"]["lobes"]:
            # Nine nodes and 256 samples: some 1e-3 to 1e-2, and not exactly nothing.
            self.assertLess(proof["max"], 0.05)
            self.assertGreater(proof["max"], 0)
            self.assertLessEqual(proof["rms"], proof["max"])
            self.assertTrue(math.isfinite(proof["rms"]))

    def test_a_bound_is_held_by_refining(self):
        _, coarse = self.bake(STEEL)
        bound = coarse["proof"]["max"] / 4
        manifest, fine = self.bake(STEEL, arguments=("--max-error", str(bound)))
        self.assertTrue(fine["proof"]["holds"])
        self.assertLessEqual(fine["proof"]["max"], bound)
        self.assertGreater(fine["proof"]["rounds"], 1)
        self.assertGreater(manifest["tables"][0]["resolution"][0], 9)

    def test_a_bound_that_cannot_hold_is_exit_6(self):
        _, report = self.bake(STEEL, arguments=("--max-error", "1e-9"), exit_status=6)
        self.assertFalse(report["proof"]["holds"])

    def test_baking_again_bakes_what_changed(self):
        before, _ = self.bake(STEEL, PAINT, arguments=QUICK)
        _, again = self.bake(STEEL, PAINT, arguments=QUICK)
        self.assertEqual([t["kept"] for t in again["tables"]], [True, True, True])
        self.assertEqual(again["work"]["brdf_evaluations"], 0)
        after, changed = self.bake(STEEL, dict(PAINT, roughness=[0.5, 1]), arguments=QUICK)
        self.assertEqual([t["kept"] for t in changed["tables"]], [True, True, False])
        self.assertNotEqual(before["tables"][2]["id"], after["tables"][2]["id"])
        plan = json.loads(self.kiln("plan", "scene.json", "--json", *SMALL)[0])
        self.assertEqual(changed["work"]["brdf_evaluations"],
                         plan["tables"][2]["estimate"]["evaluations"])
        # Colours that A and B serve are the manifest's matter alone.
        manifest, recoloured = self.bake(dict(STEEL, metal_f0=[1, 0.8, 0.3]),
                                         dict(PAINT, roughness=[0.5, 1]), arguments=QUICK)
        self.assertEqual([t["kept"] for t in recoloured["tables"]], [True, True, True])
        self.assertEqual(manifest["materials"][0]["metal_f0"]["lo"], [1, 0.8, 0.3])

    def test_a_damaged_file_is_baked_again_and_one_too_many_is_removed(self):
        self.bake(STEEL, PAINT, arguments=QUICK)
        good = self.read("out/specular.exr")
        self.write("out/specular.exr", good[:-1] + b"x")
        _, report = self.bake(STEEL, PAINT, arguments=QUICK)
        self.assertEqual([t["kept"] for t in report["tables"]], [False, True, True])
        self.assertEqual(self.read("out/specular.exr"), good)
        self.write("out/mine.txt", "stays")
        self.bake(STEEL, arguments=QUICK)
        self.assertEqual(sorted(os.listdir(self.path("out"))),
                         ["average.exr", "manifest.json", "mine.txt", "report.json",
                          "specular.exr"])

    def test_a_manifest_cannot_reach_out_of_its_folder(self):
        self.write("victim.exr", "precious")
        os.mkdir(self.path("out"))
        entry = {"name": "x", "file": "../victim.exr", "id": "0" * 64, "sha256": "0" * 64,
                 "engine": "e"}
        self.write("out/manifest.json", {"kiln_manifest": 1, "tables": [entry, 7, None]})
        self.bake(STEEL, arguments=QUICK)
        self.assertEqual(self.read("victim.exr"), b"precious")

    def test_a_scene_that_needs_nothing(self):
        manifest, report = self.bake({"name": "unlit"})
        self.assertEqual((manifest["tables"], report["proof"]["lobes"]), ([], []))

    def test_usage(self):
        self.write("scene.json", {"materials": [STEEL]})
        self.write("file", "x")
        for arguments in (("bake", "-o", "out"),
                          ("bake", "job.json", "--scene", "scene.json", "-o", "out"),
                          ("bake", "job.json", "--max-error", "1", "-o", "x.exr"),
                          ("bake", "--scene", "scene.json", "-o", "file", "--local"),
                          ("bake", "--scene", "scene.json", "-o", "out", "--no-proof",
                           "--max-error", "0.1"),
                          ("bake", "--scene", "scene.json", "-o", "out", "--set", "seed=1"),
                          ("plan",)):
            with self.subTest(arguments):
                self.kiln(*arguments, exit_status=2)
        self.assertEqual(self.files(), ["file", "scene.json"])


class Measured(KilnTest):
    """Materials that are measured: one atlas of those that are used."""

    def setUp(self):
        super().setUp()
        with open(os.path.join(SOURCE, "examples/measured/felt.csv"), "rb") as file:
            self.write("felt.csv", file.read())
        self.felt = self.id_of("felt.csv")

    def id_of(self, name):
        return "sha256:" + hashlib.sha256(self.read(name)).hexdigest()

    def scene(self, *names, **more):
        self.write("scene.json", {"materials": [{"name": name, "measured": self.felt, **more}
                                                for name in names] + [STEEL]})

    def bake(self, *arguments):
        self.kiln("bake", "--scene", "scene.json", "-o", "out", "--no-proof", *SMALL, *arguments)
        report = json.loads(self.read("out/report.json"))
        return {table["name"]: table["kept"] for table in report["tables"]}

    def missing(self, *arguments):
        stdout, _ = self.kiln("bake", "--scene", "scene.json", "-o", "none", "--json", *SMALL,
                              *arguments, exit_status=2)
        problem = json.loads(stdout)
        self.assertEqual(problem["code"], "measurement_missing")
        self.assertEqual(os.listdir(self.path("none")), [])
        return problem["problems"]

    def check_places(self):
        """The manifest's texture coordinates are the side-car's texels."""
        manifest = json.loads(self.read("out/manifest.json"))
        sidecar = json.loads(self.read("out/atlas.sidecar.json"))
        table = [table for table in manifest["tables"] if table["kind"] == "atlas"][0]
        self.assertEqual(hashlib.sha256(self.read("out/atlas.sidecar.json")).hexdigest(),
                         table["sidecar"]["sha256"])
        place = manifest["materials"][0]["measured"]
        self.assertEqual((place["data"], place["table"]), (self.felt, "atlas"))
        cell = sidecar["materials"][place["cell"]]
        self.assertEqual(cell["data"], self.felt)
        image, slice_ = sidecar["image"], sidecar["slice"]
        for ours, theirs in zip(place["slices"], cell["slices"], strict=True):
            self.assertEqual(ours["theta_in_deg"], theirs["theta_in_deg"])
            for axis, size, count, turn in (("x", image["width"], slice_["width"], 2 * math.pi),
                                            ("y", image["height"], slice_["height"], math.pi)):
                texel = ours[axis]["offset"] * size
                self.assertAlmostEqual(texel, theirs[axis] + 0.5, places=6)
                self.assertAlmostEqual(ours[axis]["scale"] * turn * size, count - 1, places=6)

    def test_in_this_process(self):
        self.scene("felt", "chair")
        places = [problem["pointer"] for problem in self.missing("--local")]
        self.assertEqual(places, ["/materials/0/measured", "/materials/1/measured"])
        given = ("--local", "--measurement", "felt.csv")
        self.assertEqual(self.bake(*given), {"specular": False, "average": False, "atlas": False})
        self.check_places()
        # A name is nothing to the atlas, whose file is not asked for.
        self.scene("loden")
        self.assertEqual(self.bake("--local"), {"specular": True, "average": True, "atlas": True})
        self.write("out/atlas.sidecar.json", "{}")
        self.kiln("bake", "--scene", "scene.json", "-o", "out", "--local", exit_status=2)
        self.scene("felt", used=False)
        self.assertEqual(self.bake(*given), {"specular": True, "average": True})
        self.assertNotIn("atlas.sidecar.json", os.listdir(self.path("out")))
        self.kiln("bake", "--scene", "scene.json", "-o", "out", "--local", "--measurement",
                  "scene.json", exit_status=2)
        self.kiln("bake", "--scene", "scene.json", "-o", "out", "--sidecar", "x", exit_status=2)

    def test_on_a_server(self):
        url = self.serve()
        self.write("scene.json", {
            "asset": {"version": "2.0"}, "meshes": [{"primitives": [{"material": 0}]}],
            "materials": [{"extras": {"kiln_measured": self.felt}}]})
        problem, = self.missing("--server", url)
        self.assertEqual(problem["pointer"], "/materials/0/extras/kiln_measured")
        self.assertIn(url, problem["message"])
        self.kiln("measure", "upload", "felt.csv", "--server", url)
        self.assertEqual(self.bake("--server", url), {"atlas": False})
        self.check_places()
        self.assertEqual(self.bake("--server", url), {"atlas": True})
        # What a server made is what this process makes.
        self.assertEqual(self.bake("--local"), {"atlas": True})


class OnAServer(KilnTest):
    def setUp(self):
        super().setUp()
        self.url = self.serve()

    def queued(self):
        """Jobs that the server had to bake since it started."""
        with urllib.request.urlopen(self.url + "/metrics", timeout=60) as answer:
            return int(re.search(r"^kiln_cache_misses_total (\d+)", answer.read().decode(),
                                 re.MULTILINE).group(1))

    def bake(self, folder, *materials):
        self.write("scene.json", {"materials": list(materials)})
        self.kiln("bake", "--scene", "scene.json", "-o", folder, "--server", self.url, *SMALL)
        return json.loads(self.read(folder + "/report.json"))

    def test_one_batch_the_same_bytes_and_cached(self):
        self.bake("server", STEEL, PAINT)
        self.kiln("bake", "--scene", "scene.json", "-o", "local", "--local", *QUICK,
                  *SMALL)
        for name in ("specular.exr", "average.exr", "specular_2.exr", "manifest.json"):
            self.assertEqual(self.read("local/" + name), self.read("server/" + name))
        report = self.bake("other", STEEL, PAINT)
        self.assertEqual([t["cached"] for t in report["tables"]], [True, True, True])

    def test_a_change_in_the_scene_bakes_only_what_changed(self):
        wide = dict(PAINT, roughness=[0.5, 1])
        first = self.bake("out", STEEL, PAINT)
        fine = first["proof"]["fine_tables"]
        self.assertGreater(fine, 0)
        self.assertEqual(self.queued(), 3 + fine)
        # (materials, tables kept, tables cached, jobs that are queued by it)
        steps = [((STEEL, PAINT), [True, True, True], [False, False, False], 0),
                 ((STEEL, wide), [True, True, False], [False, False, False], 1),
                 ((STEEL, PAINT), [True, True, False], [False, False, True], 0),
                 ((dict(STEEL, roughness=0.3), PAINT), [False, False, True],
                  [False, False, False], 2),
                 ((PAINT,), [True], [False], 0)]
        for materials, kept, cached, jobs in steps:
            before = self.queued()
            report = self.bake("out", *materials)
            self.assertEqual([t["kept"] for t in report["tables"]], kept)
            self.assertEqual([t["cached"] for t in report["tables"]], cached)
            self.assertEqual(self.queued() - before, jobs)
            self.assertEqual(report["proof"]["fine_tables_cached"], report["proof"]["fine_tables"])
            self.assertTrue(report["proof"]["lobes"])


if __name__ == "__main__":
    unittest.main()
