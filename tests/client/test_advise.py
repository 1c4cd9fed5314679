# SPDX-License-Identifier: Apache-2.0
"""`kiln advise`: its table, its job, its refusals; test_exactness measures what it advises."""
import json
import signal
import unittest

from kiln_cli import PATIENCE_S, KilnTest

JOB = {"quantities": ["directional_albedo"], "resolution": [64, 64]}
# Minutes of search: its albedo has no bound at NoV = 0.
LONG_JOB = dict(JOB, microfacet={"distribution": "charlie", "masking": "charlie"})


class Advise(KilnTest):
    def advise(self, job, bound, *arguments, status=0):
        self.write("job.json", job)
        return self.kiln("advise", "job.json", "--max-error", str(bound), *arguments,
                         exit_status=status)

    def test_the_job_it_names_can_be_baked_and_is_within_the_bound(self):
        stdout, stderr = self.advise(JOB, 0.02, "--progress", "none")
        self.assertEqual(stderr, "")
        lines = stdout.decode().splitlines()
        heads = lines[0].split()
        self.assertEqual(len(heads), len(set(heads)), heads)
        for word in ("size", "axes", "grid", "bilinear", "total"):
            self.assertIn(word, heads)
        named = json.loads(lines[-1])
        self.assertEqual(named["integrator"], "quadrature")
        self.write("named.json", named)
        stdout = self.kiln("bake", "named.json", "-o", "out.exr", "--local", "--json")[0]
        report = json.loads(stdout)
        error = report["error"]["directional_albedo"]
        self.assertLessEqual(error["reconstruction_max"] + error["quantisation_max"], 0.02)
        self.assertEqual(report["status"], "converged")

    def test_what_samples_ask_for_is_left_out(self):
        # As samples, 2048 x 2048 x 2^20 would be refused.
        plain = self.advise(JOB, 2e-3)[0]
        job = dict(JOB, sample_count=1048576, target_error=1e-4, time_budget_s=5)
        self.assertEqual(self.advise(job, 2e-3)[0], plain)

    def test_json_is_the_same_candidates(self):
        advice = json.loads(self.advise(JOB, 0.02, "--json")[0])
        self.assertEqual(advice["max_error"], 0.02)
        first = advice["candidates"][0]
        self.assertEqual(json.dumps(first["job"]).replace(" ", ""),
                         self.advise(JOB, 0.02)[0].decode().splitlines()[-1])
        sizes = [candidate["bytes"] for candidate in advice["candidates"]]
        self.assertEqual(sizes, sorted(sizes))
        for candidate in advice["candidates"]:
            self.assertLessEqual(candidate["total_max"], 0.02)

    def test_no_such_table_is_an_exit_status_of_its_own(self):
        # A program's layout keeps its axes: linear in NoV, where E falls to 0 like a square root.
        job = dict(JOB, layout="gltf")
        stdout, stderr = self.advise(job, 2e-4, status=6)
        self.assertEqual(stdout, b"")
        self.assertIn("no table up to 4096", stderr)
        self.assertRegex(stderr, r"closest is \d+ x \d+ .*float.*: off by [\d.e-]+ in "
                                 r"directional_albedo at NoV [\d.e-]+, roughness [\d.e-]+")

    def test_what_no_size_helps_against_is_told(self):
        # 16 bits are off by 7.6e-6 alone; floats by 3.0e-8, after an integration that is by 1.0e-6.
        job = dict(JOB, output={"format": "png", "pixel": "uint16"})
        for bound, made, words in (
                (5e-6, job, "rounding to uint16 alone is off by 7.6e-06; "
                            "pixel types: png has uint8, uint16, exr has half, float"),
                (1e-6, JOB, "rounding to float (3.0e-08) and integration in float32 (1.0e-06) "
                            "alone are above it")):
            stdout, stderr = self.advise(made, bound, status=6)
            self.assertEqual(stdout, b"")
            self.assertIn("no table up to 4096", stderr)
            self.assertIn("nor would a larger one: " + words, stderr)
            self.assertNotIn("closest", stderr)

    def test_axes_that_do_not_matter_are_told_once(self):
        job = {"quantities": ["fresnel_average"], "resolution": [16],
               "fresnel": {"model": "dielectric"}}
        rows = json.loads(self.advise(job, 1e-3, "--json")[0])["candidates"]
        self.assertEqual([row["job"]["output"]["pixel"] for row in rows], ["half", "float"])

    def test_a_pole_in_every_grid_is_a_failure_that_names_its_cause(self):
        # Unity's table has its texels at nodes, the first at NoV = 0, where Charlie has no bound.
        job = dict(JOB, layout="unity", microfacet={"distribution": "charlie"})
        stdout, stderr = self.advise(job, 1, status=1)
        self.assertEqual(stdout, b"")
        self.assertIn("Charlie's albedo has no bound at NoV = 0", stderr)
        self.assertIn("let the NoV axis start above 0", stderr)
        failure = json.loads(self.advise(job, 1, "--json", status=1)[0])
        self.assertEqual(failure["code"], "non_finite")

    def test_a_setting_changes_the_job(self):
        stdout = self.advise(JOB, 0.02, "--set", "output.format=png")[0]
        self.assertEqual(json.loads(stdout.decode().splitlines()[-1])["output"]["format"], "png")
        self.assertIn("--set", self.advise(JOB, 0.02, "--set", "seed", status=2)[1])

    def test_a_long_search_says_how_far_it_is(self):
        self.write("job.json", LONG_JOB)
        search = self.start("advise", "job.json", "--max-error", "0.01", "--progress", "json",
                            "--timeout", str(PATIENCE_S))
        told = [0]
        while told[-1] == 0:
            event = json.loads(search.stderr.readline())
            self.assertEqual((event["event"], event["state"]), ("progress", "running"))
            told.append(event["progress"])
        search.send_signal(signal.SIGINT)
        search.communicate(timeout=PATIENCE_S)
        self.assertEqual(search.returncode, 130)
        self.assertTrue(0 < told[-1] < 1, told)

    def test_a_search_ends_at_its_time_limit(self):
        stdout, stderr = self.advise(LONG_JOB, 0.01, "--timeout", "0.5", status=5)
        self.assertEqual(stdout, b"")
        self.assertIn("not done within 0.5 s", stderr)

    def test_what_quadrature_lacks_is_refused_by_name(self):
        job = dict(JOB, quantities=["directional_albedo", "diffuse_albedo"],
                   diffuse={"model": "chan2018"})
        stderr = self.advise(job, 0.1, status=3)[1]
        self.assertIn("/quantities/1", stderr)
        self.assertIn("diffuse", stderr)


if __name__ == "__main__":
    unittest.main()
