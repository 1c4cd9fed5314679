# SPDX-License-Identifier: Apache-2.0
"""`kiln furnace` and `kiln convergence`: verdicts, files and exit statuses, here and through a server."""
import csv
import io
import json
import os
import shutil
import unittest

from kiln_cli import JOB, KilnTest

PNG, SVG = b"\x89PNG\r\n\x1a\n", b"<?xml"
FILES = ["csv", "json", "png", "svg"]


class Furnace(KilnTest):
    def furnace(self, job, *arguments, exit_status=0):
        self.write("job.json", job)
        return self.kiln("furnace", "job.json", "--local", *arguments, exit_status=exit_status)

    def test_prints_verdicts_and_writes_pictures_and_numbers(self):
        stdout, stderr = self.furnace({**JOB, "coupling": "half_vector"}, "-o", "out/furnace")
        lines = [line.split(maxsplit=2) for line in stdout.decode().splitlines()[1:5]]
        self.assertEqual([line[0] for line in lines], ["yes", "known", "yes", "known"])
        self.assertIn("energy conservation", stdout.decode())
        self.assertIn("wrote out/furnace/furnace.png", stderr)
        for extension in FILES:
            self.assertTrue(self.read(f"out/furnace/furnace.{extension}"))
        self.assertTrue(self.read("out/furnace/furnace.png").startswith(PNG))
        self.assertTrue(self.read("out/furnace/furnace.svg").startswith(SVG))
        report = json.loads(self.read("out/furnace/furnace.json"))
        rows = list(csv.DictReader(io.StringIO(self.read("out/furnace/furnace.csv").decode())))
        table = report["study"]["table"]
        self.assertEqual(len(rows), len(table["rows"]))
        for row, cells in zip(rows, table["rows"]):
            self.assertEqual([float(row[c]) for c in table["columns"]], cells)

    def test_json_is_the_report(self):
        stdout, _ = self.furnace(JOB, "--json")
        report = json.loads(stdout)
        self.assertEqual({v["name"]: v["holds"] for v in report["study"]["verdicts"]}["reciprocity"],
                         True)
        self.assertEqual(report["device"]["backend"], "native")

    def test_a_material_is_changed_by_set(self):
        stdout, _ = self.furnace(JOB, "--set", "coupling=view", "--json")
        verdicts = {v["name"]: v for v in json.loads(stdout)["study"]["verdicts"]}
        self.assertFalse(verdicts["reciprocity"]["holds"])
        self.assertFalse(verdicts["reciprocity"]["expected"])

    def test_a_study_document_is_baked_as_its_picture(self):
        self.write("study.json", {"kind": "furnace", "device": "native"})
        self.kiln("bake", "study.json", "-o", "out.png", "--local")
        self.assertTrue(self.read("out.png").startswith(PNG))
        self.kiln("bake", "study.json", "-o", "out.exr", "--local", exit_status=3)

    def test_what_a_study_does_not_read_is_refused_by_name(self):
        self.write("study.json", {"kind": "furnace", "resolution": [8, 8]})
        _, stderr = self.kiln("furnace", "study.json", "--local", exit_status=3)
        self.assertIn("/resolution", stderr)
        self.assertIn('is not read by kind "furnace"', stderr)

    def test_a_folder_that_cannot_be_made_is_told_before_the_work(self):
        self.write("file", "x")
        _, stderr = self.furnace(JOB, "-o", "file/below", exit_status=2)
        self.assertIn("file/below", stderr)

    def test_a_server_gives_the_same_verdicts(self):
        url = self.serve()
        self.write("job.json", JOB)
        stdout, _ = self.kiln("furnace", "job.json", "--server", url, "-o", "served")
        here, _ = self.furnace(JOB)
        self.assertEqual(stdout, here)
        self.assertTrue(self.read("served/furnace.png").startswith(PNG))


class Convergence(KilnTest):
    def test_curves_come_with_pictures_and_numbers(self):
        self.write("job.json", {**JOB, "resolution": [8, 8]})
        stdout, _ = self.kiln("convergence", "job.json", "--local", "-o", "out")
        self.assertIn("reported errors are honest", stdout.decode())
        for extension in FILES:
            self.assertTrue(self.read(f"out/convergence.{extension}"))
        rows = list(csv.DictReader(io.StringIO(self.read("out/convergence.csv").decode())))
        self.assertEqual({row["sampler"] for row in rows if row["sample_count"] == "64"},
                         {"hammersley", "sobol_owen", "lattice", "random"})
        quadrature = [row for row in rows if row["sampler"] == "quadrature"]
        self.assertLess(float(quadrature[-1]["error_max"]), 1e-5)

    def convergence(self, **fields):
        """Of a table that cmgen bakes, but for `fields`: the text, cmgen's rows, its lines."""
        self.write("job.json", {**JOB, "resolution": [8, 8], **fields})
        stdout, _ = self.kiln("convergence", "job.json", "--local", "-o", "out")
        study = json.loads(self.read("out/convergence.json"))["study"]
        table = io.StringIO(self.read("out/convergence.csv").decode())
        rows = [row for row in csv.DictReader(table) if "cmgen" in row.values()]
        lines = [[series["name"] for series in chart.get("series", [])
                  if series["name"].startswith("cmgen")] for chart in study["charts"]]
        return stdout.decode(), rows, lines

    def fake_cmgen(self, text):
        """A PATH with that one program or, without a text, none."""
        os.mkdir(self.path("bin"))
        self.env["PATH"] = self.path("bin")
        if text:
            os.chmod(self.path(self.write("bin/cmgen", "#!/bin/sh\n" + text)), 0o755)

    @unittest.skipUnless(shutil.which("cmgen"),
                         "cmgen is not installed (package libfilament-tools)")
    def test_cmgen_has_a_point_in_both_diagrams_over_time_and_a_row(self):
        stdout, rows, lines = self.convergence()
        self.assertIn("cmgen: its own file", stdout)
        self.assertEqual(len(rows), 1)
        # Its 1024 points of D, the same for all texels: 1.3e-2 at 256 x 256.
        self.assertTrue(1e-3 < float(rows[0]["error_max"]) < 3e-2, rows)
        self.assertEqual(sum(map(len, lines)), 2, lines)
        self.assertEqual([len(line) for line in lines[:2]], [1, 1], lines)

    def assert_left_out(self, words):
        stdout, rows, lines = self.convergence()
        self.assertEqual([line.strip() for line in stdout.splitlines() if "cmgen" in line], [words])
        self.assertEqual(rows, [])
        self.assertEqual(sum(map(len, lines)), 0)

    def test_a_cmgen_that_is_not_installed_is_said(self):
        self.fake_cmgen("")
        self.assert_left_out("Filament's cmgen was not found, so its line is left out: Debian's "
                             "package is libfilament-tools.")

    def test_a_cmgen_that_fails_is_said(self):
        self.fake_cmgen("exit 1\n")
        self.assert_left_out("cmgen failed, so its line is left out.")

    def test_a_cmgen_that_writes_nothing_is_said(self):
        self.fake_cmgen("exit 0\n")
        self.assert_left_out("cmgen failed, so its line is left out.")

    def test_a_cmgen_that_writes_another_table_is_said(self):
        self.fake_cmgen('for a; do case $a in --ibl-dfg=*) echo 0x3c00, >"${a#*=}";; esac; done\n')
        self.assert_left_out("cmgen wrote a table of another size, so its line is left out.")

    def test_nothing_is_said_of_cmgen_where_it_has_no_such_table(self):
        self.fake_cmgen("")
        stdout, rows, _ = self.convergence(resolution=[8, 16])
        self.assertNotIn("cmgen", stdout)
        self.assertEqual(rows, [])

    def test_what_has_no_exact_values_is_refused(self):
        self.write("job.json", {**JOB, "quantities": ["diffuse_albedo"],
                                "diffuse": {"model": "chan2018"}})
        _, stderr = self.kiln("convergence", "job.json", "--local", "-o", "out", exit_status=3)
        self.assertIn("quadrature", stderr)


if __name__ == "__main__":
    unittest.main()
