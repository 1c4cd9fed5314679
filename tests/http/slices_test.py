# SPDX-License-Identifier: Apache-2.0
"""Jobs of kind slices and atlas: from an uploaded file to what a shader makes of image and side-car,
against the formulas that the file was written from."""
import hashlib
import json
import os
import struct
import unittest

import make  # examples/measured/make.py
from service import ServiceTest
from slices import Slices, rgb9e5

# Broad enough that steps of 5 and 10 degrees hold them to some tenths of a percent.
SATIN = make.coated(0.6, 0.5, (0.2, 0.3, 0.1))
FELT = make.MATERIALS["felt"]
PACKED = {"format": "png", "pixel": "rgb9e5"}
BYTES = {"Content-Type": "application/octet-stream"}


class Measured(ServiceTest):
    FLAGS = ["--device", "native"]

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.satin = cls.upload(make.csv(SATIN, 5, 10).encode())
        cls.felt = cls.upload(make.csv(FELT, 5, 10).encode())

    @classmethod
    def upload(cls, data):
        answer = cls.server.request("POST", "/v1/measurements", data, BYTES)
        assert answer.status in (200, 201), answer.body
        return answer.json["id"]

    def bake(self, job):
        done = self.server.bake(job)
        self.assertEqual(done["state"], "done", done["error"])
        return done

    def fetched(self, done):
        return (self.server.get(done["links"]["image"]).body,
                self.server.get(done["links"]["sidecar"]).json,
                self.server.get(done["links"]["report"]).json)

    def test_a_shader_finds_the_material_again(self):
        """Lookup of the returned bytes within 2 % of the formula, where it was measured."""
        done = self.bake({"kind": "slices", "measured": {"data": self.satin, "name": "satin",
                                                         "theta_in": [0, 20, 40, 60]},
                          "resolution": [181, 91], "output": PACKED})
        image, sidecar, report = self.fetched(done)
        slices = Slices(image, sidecar)
        self.assertEqual((slices.width, slices.height), (2 * 181, 2 * 91))
        self.assertEqual(sidecar["theta_in_deg"], [0, 20, 40, 60])
        for index, entry in enumerate(sidecar["materials"][0]["slices"]):
            error = slices.error(0, index, SATIN, 73)
            self.assertLess(error, 0.02, entry["theta_in_deg"])
            self.assertLess(entry["lookup_error"], 0.01)
        self.assertEqual(report["measured"], sidecar)
        for channel in "RGB":
            # Nine bits of a value below 2, and half a step of rounding.
            worst = report["error"][channel]["quantisation_max"]
            self.assertTrue(0 < worst <= 2 / 512 / 2, worst)

    def test_an_atlas_holds_each_material_in_its_cell(self):
        done = self.bake({
            "kind": "atlas", "resolution": [91, 46], "output": PACKED,
            "measured": {"data": [self.satin, {"data": self.felt, "name": "felt",
                                               "extrapolation": {"p": 0.5}}],
                         "theta_in": [0, 40, 60], "gutter": 2}})
        image, sidecar, _ = self.fetched(done)
        slices = Slices(image, sidecar)
        self.assertEqual((slices.width, slices.height), (2 * 2 * 95, 2 * 1 * 50))
        names = [material["name"] for material in sidecar["materials"]]
        self.assertEqual(names, [self.satin[7:19], "felt"])
        self.assertEqual([m["extrapolation"]["p"] for m in sidecar["materials"]], [1, 0.5])
        for material, truth in enumerate((SATIN, FELT)):
            for index in range(3):
                self.assertLess(slices.error(material, index, truth, 73), 0.03)
        # A gutter continues phi_d: one texel left of column 0 is the last but one column.
        entry = sidecar["materials"][1]["slices"][2]
        for row in (0, 11, 45):
            left = slices.texel(entry["x"] - 1, entry["y"] + row)
            self.assertEqual(left, slices.texel(entry["x"] + 89, entry["y"] + row))

    def test_reports_tell_what_was_measured(self):
        done = self.bake({"kind": "slices", "measured": {"data": self.felt},
                          "resolution": [37, 19]})
        _, _, report = self.fetched(done)
        material = report["measured"]["materials"][0]
        texels = material["texels"]
        self.assertAlmostEqual(sum(texels[name] for name in ("measured_share", "interpolated_share",
                                                             "extrapolated_share")), 1)
        # theta_out to 75 of 90 degrees: cos 75 = 0.26 of the solid angle was not measured.
        self.assertTrue(0.1 < texels["extrapolated_share"] < 0.45, texels)
        normal = material["slices"][0]["directional_albedo"]["rgb"]
        # Of the formula at normal incidence: rho + 2 pi * integral of
        # 0.12 (1 - cos^2(t/2)) / (1) cos t sin t dt = rho + 0.12 * 2 pi / 12.
        for value, rho in zip(normal, (0.05, 0.16, 0.10)):
            self.assertAlmostEqual(value, rho + 0.12 * 3.14159265 / 6, delta=0.02 * value)
        self.assertTrue(all(0 < value < 1 for value in material["average_albedo"]["rgb"]))
        self.assertEqual(report["samples"]["total"], 0)
        self.assertEqual(report["error"]["R"]["standard_error_max"], None)

    def test_all_spellings_of_a_job_are_one(self):
        digest = self.satin
        spellings = [{"data": digest}, {"data": [digest]}, [digest], [{"data": digest}],
                     {"data": digest, "name": digest[7:19]},
                     {"data": digest, "extrapolation": {"p": 1},
                      "theta_in": [0.0, *range(5, 65, 5)]},
                     {"data": [{"data": digest, "extrapolation": {"l": 0.3}}]}]
        answers = [self.bake({"kind": "slices", "measured": measured, "resolution": [9, 5]})
                   for measured in spellings]
        self.assertEqual(len({answer["id"] for answer in answers}), 1)
        self.assertEqual([answer["cached"] for answer in answers[1:]], [True] * 6)
        other = self.bake({"kind": "slices", "measured": {"data": digest, "name": "other"},
                           "resolution": [9, 5]})
        self.assertNotEqual(other["id"], answers[0]["id"])

    def test_formats(self):
        for output, magic in (({"format": "exr"}, b"\x76\x2f\x31\x01"),
                              ({"format": "exr", "pixel": "float"}, b"\x76\x2f\x31\x01"),
                              ({"format": "exr", "pixel": "rgb9e5"}, b"\x76\x2f\x31\x01"),
                              ({"format": "png"}, b"\x89PNG"),
                              ({"format": "png", "pixel": "uint8"}, b"\x89PNG"),
                              (PACKED, b"\x89PNG")):
            done = self.bake({"kind": "slices", "measured": {"data": self.felt},
                              "resolution": [19, 10], "output": output})
            image, sidecar, report = self.fetched(done)
            self.assertEqual(image[:4], magic, output)
            self.assertEqual(sidecar["pixel"]["format"], output["format"])
            self.assertIsNotNone(report["error"]["G"]["quantisation_max"])

    def test_views_companions_and_samplers_are_jobs(self):
        both = {"data": [{"data": self.satin, "name": "satin"}, {"data": self.felt}]}
        size = lambda png: struct.unpack(">II", png[16:24])
        done = self.bake({"kind": "lobe_view", "resolution": [160, 120],
                          "measured": {**both, "theta_in": [80]}})
        image, sidecar, report = self.fetched(done)
        self.assertEqual(size(image), (320, 120))
        # Measured to 60 degrees.
        self.assertEqual(len([w for w in report["warnings"] if "extrapolated" in w]), 2)
        self.assertEqual(report["measured"], sidecar)
        image, sidecar, _ = self.fetched(self.bake({"kind": "sphere_view", "resolution": [64, 64],
                                                    "measured": both}))
        self.assertEqual(size(image), (128, 64))
        self.assertNotIn("shader", sidecar)
        image, sidecar, report = self.fetched(self.bake(
            {"kind": "companion", "measured": both, "resolution": [16]}))
        self.assertEqual(image[:4], b"\x76\x2f\x31\x01")
        self.assertEqual(sidecar["image"], {"width": 16, "height": 2})
        split = sidecar["materials"][0]["split_sum"]
        # Of make.coated(0.6, …), from steps of 5 and 10 degrees.
        self.assertAlmostEqual(split["alpha"], 0.6, delta=0.06)
        for channel in "RGB":
            self.assertIsNotNone(report["error"][channel]["quantisation_max"])
        image, sidecar, _ = self.fetched(self.bake(
            {"kind": "sampling", "measured": {"data": self.satin, "theta_in": [0, 45]},
             "resolution": [24, 16]}))
        self.assertEqual(image[:4], b"\x76\x2f\x31\x01")
        self.assertEqual([s["x"] for s in sidecar["materials"][0]["slices"]], [0, 24])
        self.assertIn("pdf", sidecar["shader"])
        again = self.server.post({"kind": "companion", "measured": both, "resolution": [16]})
        self.assertTrue(again.json["cached"])

    def test_bits_of_rgb9e5(self):
        # 1.0 is 2^8 of 2^(16 - 24); 0.5 and 0.25 share its exponent.
        self.assertEqual(rgb9e5((16 << 27 | 64 << 18 | 128 << 9 | 256).to_bytes(4, "little")),
                         [1.0, 0.5, 0.25])

    def test_unknown_and_unfit_measurements_are_named_by_pointer(self):
        nobody = "sha256:" + "0" * 64
        header = make.csv(SATIN).splitlines()[0].encode()
        unfit = self.upload(header + b"\n0,0,10,0,1,1,1\n")
        cases = [({"kind": "slices", "measured": {"data": nobody}}, ["/measured/data"]),
                 ({"kind": "slices", "measured": {"data": unfit}}, ["/measured/data"]),
                 ({"kind": "atlas", "measured": {"data": [self.satin, nobody,
                                                          {"data": unfit}]}},
                  ["/measured/data/1", "/measured/data/2/data"]),
                 ({"kind": "atlas", "measured": [{"data": nobody}]}, ["/measured/0/data"])]
        for job, pointers in cases:
            answer = self.server.post(job)
            self.assertEqual(answer.status, 422, answer.body)
            self.assertEqual([p["pointer"] for p in answer.json["problems"]], pointers)
        batch = self.server.request(
            "POST", "/v1/batches",
            json.dumps({"jobs": [cases[0][0], {"kind": "slices", "measured": {"data": self.satin},
                                               "resolution": [9, 5]}]}),
            {"Content-Type": "application/json"}).json["jobs"]
        self.assertEqual(batch[0]["status"], 422)
        self.assertIn(batch[1]["status"], (200, 202))

    def test_an_id_that_is_none_is_refused_in_words(self):
        for name in ("sha256:00", self.satin[:-1], "sha256:"):
            answer = self.server.post({"kind": "slices", "measured": {"data": name}})
            self.assertEqual(answer.status, 422, answer.body)
            (problem,) = answer.json["problems"]
            self.assertEqual(problem["pointer"], "/measured/data")
            self.assertIn(f'is "{name[:40]}', problem["message"])  # a long one is cut
            self.assertIn('; must be "sha256:" and 64 lower-case hex digits', problem["message"])

    def test_a_long_atlas_tells_its_progress_and_can_be_cancelled(self):
        """Some ten million texels: seconds at least, of which the test waits for a part."""
        job = {"kind": "atlas", "measured": {"data": [self.satin, self.felt] * 4,
                                             "theta_in": [0, 20, 40, 60]},
               "resolution": [1024, 512]}
        job_id = self.server.post(job).json["id"]
        seen = set()
        while not seen or max(seen) == 0:
            status = self.server.get(f"/v1/jobs/{job_id}").json
            self.assertIn(status["state"], ("queued", "running"))
            seen.add(status["progress"])
        self.assertLess(max(seen), 1)
        self.server.request("DELETE", f"/v1/jobs/{job_id}")
        self.assertEqual(self.server.get(f"/v1/jobs/{job_id}?wait=60").json["state"], "cancelled")

    def test_other_jobs_have_no_sidecar(self):
        done = self.server.bake({"quantities": ["average_albedo"], "resolution": [4],
                                 "sample_count": 16})
        self.assertNotIn("sidecar", done["links"])
        answer = self.server.get(f"/v1/jobs/{done['id']}/sidecar")
        self.assertEqual((answer.status, answer.json["code"]), (404, "no_sidecar"))


def shared_files():
    """Real measurements that tables can be made of, as tests/measured finds them."""
    folder = os.environ.get("KILN_MEASURED_FILES") or os.path.join(
        os.path.dirname(__file__), "..", "..", "..", "shared", "data", "measured")
    wanted = ("rgl", "zemax", "fred", "derived_minidiff_layout", "lbnl_xml")
    return [os.path.join(folder, kind, name)
            for kind in wanted if os.path.isdir(os.path.join(folder, kind))
            for name in sorted(os.listdir(os.path.join(folder, kind)))
            if not name.startswith("LICENSE")]


@unittest.skipUnless(shared_files(),
                     "no folder of measured files; KILN_MEASURED_FILES may name one")
class Shared(ServiceTest):
    FLAGS = ["--device", "native"]

    def test_all_of_them_become_one_atlas(self):
        materials = []
        for path in shared_files():
            with open(path, "rb") as file:
                data = file.read()
            answer = self.server.request("POST", "/v1/measurements", data, BYTES)
            self.assertEqual(answer.status, 201, (path, answer.body))
            self.assertEqual(answer.json["id"], "sha256:" + hashlib.sha256(data).hexdigest())
            if answer.json["unfit"] is None:
                materials.append({"data": answer.json["id"], "name": os.path.basename(path)})
        self.assertGreaterEqual(len(materials), 10)
        job = {"kind": "atlas", "measured": {"data": materials, "gutter": 1},
               "resolution": [91, 46], "output": PACKED}
        done = self.server.bake(job)
        self.assertEqual(done["state"], "done", done["error"])
        again = self.server.post(job)
        self.assertTrue(again.json["cached"])
        sidecar = self.server.get(done["links"]["sidecar"]).json
        slices = Slices(self.server.get(done["links"]["image"]).body, sidecar)
        by_name = {material["name"]: material for material in sidecar["materials"]}
        paper = by_name["paper_white_rgb.bsdf"]
        # shared/data/measured/README.md: green at normal incidence; resampled to 2 % and extended
        # with f, not f cos, to the horizon.
        self.assertAlmostEqual(paper["slices"][0]["directional_albedo"]["rgb"][1], .834,
                               delta=.02 * .834)
        at = slices.look_up(paper["index"], 0, 30, 180)
        self.assertAlmostEqual(at[1], .834 / 3.14159, delta=.1 * .834)


if __name__ == "__main__":
    unittest.main()
