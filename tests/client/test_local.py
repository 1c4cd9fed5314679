# SPDX-License-Identifier: Apache-2.0
"""`kiln bake --local`: the job on its way in, the files on their way out, and every exit status."""
import base64
import glob
import hashlib
import json
import os
import re
import signal
import time
import unittest

from kiln_cli import JOB, PATIENCE_S, SOURCE, KilnTest, long_job


class Bake(KilnTest):
    def test_writes_the_image_its_report_and_nothing_else(self):
        stdout, stderr = self.bake_local("out.exr", JOB, "--report", "report.json")
        self.assertEqual(self.files(), ["job.json", "out.exr", "report.json"])
        self.assertTrue(self.read("out.exr").startswith(b"\x76\x2f\x31\x01"))  # EXR's magic number
        self.assertEqual(stdout, b"")
        report = json.loads(self.read("report.json"))
        self.assertEqual(list(report["error"]), JOB["quantities"])
        self.assertEqual(report["device"]["backend"], "native")
        self.assertGreater(report["run_time_s"]["encode"], 0)
        self.assertGreaterEqual(report["run_time_s"]["total"], report["run_time_s"]["encode"])
        for channel in report["error"].values():
            # Values below 1 in half: 11 bits of mantissa, so at most half a step of 2^-11.
            self.assertLessEqual(channel["quantisation_max"], 2.0**-12)
            self.assertGreater(channel["quantisation_max"], 0)
        for word in (*JOB["quantities"], "standard error", "64 samples a texel", "native"):
            self.assertIn(word, stderr)

    def test_the_job_id_and_the_key_are_the_documented_hashes(self):
        stdout, _ = self.bake_local("out.exr", JOB, "--json")
        info = json.loads(self.kiln("info", "out.exr", "--json")[0])["metadata"]
        canonical = info["kiln.job"].encode()
        self.assertEqual(json.loads(stdout)["job"],
                         hashlib.sha256(b"kiln/job/1\n" + canonical).hexdigest())
        lines = ["kiln/image/1", info["kiln.kernel_digest"], info["kiln.numerics"],
                 info["kiln.encoder_revision"]]
        preimage = "\n".join(lines).encode() + b"\n" + canonical
        self.assertEqual(info["kiln.key"], hashlib.sha256(preimage).hexdigest())

    def test_the_same_job_twice_is_the_same_bytes(self):
        self.bake_local("a.exr")
        self.bake_local("b.exr")
        self.assertEqual(self.read("a.exr"), self.read("b.exr"))

    def test_samples_and_quadrature_are_told_apart(self):
        told = self.bake_local("out.exr")[1]
        self.assertIn("off exact rms", told)
        self.assertRegex(told, r"\d+ samples a texel on native")
        told = self.bake_local("out.exr", dict(JOB, integrator="quadrature"))[1]
        self.assertIn("within exact rms", told)
        self.assertRegex(told, r"\d+ nodes a texel on native")  # places, none of them drawn

    def test_standard_input_and_output(self):
        self.bake_local("file.exr")
        image, _ = self.kiln("bake", "-", "-o", "-", "--local", stdin=json.dumps(JOB).encode())
        self.assertEqual(image, self.read("file.exr"))

    def test_json_puts_the_report_and_nothing_else_on_standard_output(self):
        stdout, stderr = self.bake_local("out.exr", JOB, "--json")
        self.assertEqual(json.loads(stdout)["status"], "done")
        self.assertEqual(stderr, "")

    def test_set_changes_the_job(self):
        self.bake_local("out.exr", JOB, "--set", "resolution=[4,2]", "--set", "output.pixel=float",
                        "--set", "sampler=hammersley")
        info = json.loads(self.kiln("info", "out.exr", "--json")[0])
        self.assertEqual(info["resolution"], [4, 2])
        self.assertEqual(info["pixel"], "float")
        self.assertEqual(json.loads(info["metadata"]["kiln.job"])["sampler"], "hammersley")

    def test_the_name_chooses_the_format_unless_the_job_does(self):
        self.bake_local("out.png")
        self.assertTrue(self.read("out.png").startswith(b"\x89PNG"))
        self.bake_local("OUT.PNG")
        self.assertEqual(self.read("OUT.PNG"), self.read("out.png"))
        self.bake_local("no_extension", dict(JOB, output={"format": "png"}))
        self.assertEqual(self.read("no_extension"), self.read("out.png"))

    def test_eight_bits_come_with_a_warning(self):
        _, stderr = self.bake_local("out.png", dict(JOB, output={"pixel": "uint8"}), "--json")
        self.assertIn("banding", stderr)

    def test_every_example_is_a_job(self):
        examples = sorted(glob.glob(os.path.join(SOURCE, "examples", "*.json")))
        self.assertGreaterEqual(len(examples), 6)
        for example in examples:
            with open(example, encoding="utf-8") as file:
                job = json.load(file)
            measured = job.get("kind") in ("slices", "atlas")
            layout = job.get("layout")
            z = layout.get("z", {}) if isinstance(layout, dict) else {}
            sides = [4, 4, len(z.get("values", range(4)))][:len(job.get("resolution", []))]
            size = "[9,5]" if measured else str(sides)
            few = () if measured else ("--set", "device=native", "--set", "sample_count=16")
            self.kiln("bake", example, "-o", "-", "--local", "--set", "resolution=" + size, *few)

    def test_info_says_how_a_table_of_slices_is_cut(self):
        example = os.path.join(SOURCE, "examples", "three_axes.json")
        told = self.kiln("bake", example, "-o", "out.exr", "--local", "--set", "device=native",
                         "--set", "sample_count=16", "--set", "resolution=[4,5,3]")[1]
        words = self.kiln("info", "out.exr")[0].decode()
        for text in (told, words):
            self.assertIn("out.exr  4 x 15 (3 slices of 4 x 5) half, ", text)
        self.assertIn("look up at v = (slice + (t (5 - 1) + 0.5)/5)/3", words)

    def test_unitys_third_channel_lacks_what_its_shader_adds(self):
        theirs = {**JOB, "layout": "unity", "diffuse": {"model": "burley"}, "quantities": [
            "split_sum_bias", "directional_albedo", "diffuse_albedo"], "output": {"pixel": "float"}}
        node = {"grid": "node"}
        plain = {**theirs, "layout": {"x": {"parameter": "NoV", "mapping": "sqrt", **node},
                                      "y": {"parameter": "roughness", **node}}}
        self.bake_local("theirs.exr", theirs)
        self.bake_local("plain.exr", plain)
        stdout, _ = self.kiln("diff", "theirs.exr", "plain.exr", "--json", exit_status=6)
        channels = json.loads(stdout)["channels"]
        self.assertEqual([channels[c]["max"] for c in "RGB"], [0, 0, 0.5])
        self.assertEqual(channels["B"]["rms"], 0.5)
        self.assertIn("B: diffuse_albedo - 0.5", self.kiln("info", "theirs.exr")[0].decode())

    def test_a_symbolic_link_stays_one_and_modes_stay(self):
        self.write("real.exr", "old")
        os.chmod(self.path("real.exr"), 0o640)
        os.symlink("real.exr", self.path("out.exr"))
        self.bake_local("out.exr")
        self.assertTrue(os.path.islink(self.path("out.exr")))
        self.assertTrue(self.read("real.exr").startswith(b"\x76\x2f\x31\x01"))
        self.assertEqual(os.stat(self.path("real.exr")).st_mode & 0o777, 0o640)

    def test_native_does_not_touch_opencl(self):
        self.hang_opencl()
        self.bake_local("out.exr")


class Refuse(KilnTest):
    def test_wrong_jobs_exit_3_name_the_field_and_write_nothing(self):
        with open(os.path.join(SOURCE, "tests/spec/wrong_jobs.json"), encoding="utf-8") as file:
            corpus = json.load(file)
        self.assertGreaterEqual(len(corpus), 100)
        for wrong in corpus:
            if re.match(r"/measured/(data|\d)", wrong["pointer"]):
                continue  # here a file may stand there: that one is not found is for test_slices
            with self.subTest(wrong["name"]):
                if "text" in wrong:
                    text = wrong["text"].encode("utf-8", "surrogatepass")
                elif "base64" in wrong:
                    text = base64.b64decode(wrong["base64"])
                else:
                    text = "".join(part * count for part, count in wrong["parts"]).encode()
                self.write("job.json", text)
                stdout, stderr = self.kiln("bake", "job.json", "-o", "out", "--local", "--json",
                                           exit_status=3)
                problem = json.loads(stdout)
                self.assertIn(wrong["pointer"], [p["pointer"] for p in problem["problems"]])
                self.assertEqual(len(stderr.splitlines()), 1 + len(problem["problems"]), stderr)
                self.assertEqual(self.files(), ["job.json"])

    def test_a_name_that_disagrees_with_the_job(self):
        self.write("job.json", dict(JOB, output={"format": "exr"}))
        _, stderr = self.kiln("bake", "job.json", "-o", "out.png", "--local", exit_status=3)
        self.assertIn("/output/format", stderr)

    def test_a_wrong_output_is_not_mended_by_the_name(self):
        for output in (None, [], {"format": None}, {"format": 7}):
            self.write("job.json", dict(JOB, output=output))
            _, stderr = self.kiln("bake", "job.json", "-o", "out.png", "--local", exit_status=3)
            self.assertIn("/output", stderr)

    def test_usage(self):
        self.write("job.json", JOB)
        os.mkdir(self.path("folder"))
        for arguments in (
                (), ("nonsense",), ("bake",), ("bake", "job.json"), ("bake", "job.json", "-o"),
                ("bake", "missing.json", "-o", "x.exr"), ("bake", "folder", "-o", "x.exr"),
                ("bake", "job.json", "-o", "x.tif"), ("bake", "job.json", "-o", "folder"),
                ("bake", "job.json", "-o", "no/such/x.exr"), ("bake", "job.json", "-o", "folder/"),
                ("bake", "job.json", "-o", "-", "--report", "-"),
                ("bake", "job.json", "-o", "x.exr", "--set", "seed"),
                ("bake", "job.json", "-o", "x.exr", "--set", "seed.a=1", "--set", "seed.a.b=2"),
                ("bake", "job.json", "-o", "x.exr", "--progress", "fancy"),
                ("bake", "job.json", "-o", "x.exr", "--timeout", "-1"),
                ("bake", "job.json", "-o", "x.exr", "--local", "--server", "http://127.0.0.1:1"),
                ("info",), ("info", "missing.exr"), ("info", "job.json"), ("diff", "job.json"),
                ("diff", "job.json", "job.json"), ("ls", "--state", "odd"), ("ls", "--limit", "0"),
                ("cancel",), ("cancel", "0123"), ("cancel", "not-hexadecimal")):
            with self.subTest(arguments):
                stdout, stderr = self.kiln(*arguments, exit_status=2)
                self.assertEqual(stdout, b"")
                self.assertTrue(stderr.startswith("kiln: "), stderr)
        self.assertEqual(self.files(), ["folder", "job.json"])

    def test_a_number_is_finite_and_what_is_allowed_is_said(self):
        self.write("job.json", JOB)
        bake, study = ("bake", "job.json", "-o", "x.exr"), ("furnace", "job.json")
        scene = ("bake", "--scene", "job.json", "-o", "x")
        slices = ("measure", "slices", "job.json", "-o", "x.exr")
        view = ("measure", "view", "job.json", "-o", "x.png")
        real, whole = "a finite number", "a whole number"
        for command, option, allowed in (
                (("advise", "job.json"), "--max-error", f"{real} from 1e-06 to 1"),
                (scene, "--max-error", f"{real} from 0 to 1"),
                (bake, "--timeout", f"{real} from 0 to 1e+06"),
                (study, "--timeout", f"{real} from 0 to 1e+06"),
                (("diff", "job.json", "job.json"), "--max-error", f"{real} of at least 0"),
                (slices, "--theta-in", "rising angles from 0 to 90 degrees"),
                (slices, "--phi-in", f"{real} from 0 to 360"),
                (slices, "--extrapolation-p", f"{real} from 0 to 100"),
                (slices, "--extrapolation-l", f"{real} from 0 to 1"),
                (slices, "--width", f"{whole} from 2 to 4096"),
                (view, "--theta-in", f"{real} from 0 to 89"),
                (view, "--phi-in", f"{real} from 0 to 360"),
                (view, "--size", f"{whole} from 64 to 2048"),
                (("measure", "fit", "job.json"), "--phi-in", f"{real} from 0 to 360"),
                (("ls",), "--limit", f"{whole} from 1 to 10000")):
            for value in ("nan", "inf", "-inf"):
                with self.subTest(command=command, option=option, value=value):
                    _, stderr = self.kiln(*command, f"{option}={value}", exit_status=2)
                    self.assertIn(option, stderr)
                    self.assertIn(allowed, stderr)
        self.assertEqual(self.files(), ["job.json"])

    def test_an_unknown_command_is_named_with_the_nearest(self):
        for word, hint in (("bak", 'did you mean "bake"?'), ("inof", 'did you mean "info"?'),
                           ("nonsense", "is no command. There are bake, plan, convergence,"),
                           ("--versoin", 'did you mean "--version"?')):
            _, stderr = self.kiln(word, "job.json", exit_status=2)
            self.assertIn(f'"{word}" is no ', stderr)
            self.assertIn(hint, stderr)

    def test_help_and_version_go_to_standard_output(self):
        self.assertRegex(self.kiln("--version")[0].decode(), r"^kiln \d+\.\d+\.\d+\n$")
        for command in ("bake", "info", "diff", "ls", "cancel"):
            self.assertIn(b"Example", self.kiln(command, "--help")[0])

    def test_help_is_in_words_for_every_argument(self):
        commands = [("bake",), ("plan",), ("convergence",), ("furnace",), ("stability",),
                    ("advise",), ("info",), ("diff",), ("devices",), ("ls",), ("cancel",),
                    *(("measure", word) for word in ("info", "fit", "slices", "upload", "view"))]
        for command in commands:
            text = self.kiln(*command, "--help")[0].decode().split("\nExample")[0]
            arguments = re.findall(r"^  (\S.*)$", text, re.M)
            self.assertTrue(arguments, command)
            for argument in arguments:  # what it is called, two blanks or more, what it is
                self.assertRegex(argument, r"\S  +\S", command)
                self.assertNotRegex(argument, r" (FLOAT|UINT|INT|TEXT)\b", command)

    def test_control_characters_of_a_job_do_not_reach_the_terminal(self):
        self.write("job.json", '{"quantities": ["split_sum_scale"], "\\u001b[2J": 1}')
        _, stderr = self.kiln("bake", "job.json", "-o", "x.exr", "--local", exit_status=3)
        self.assertNotIn("\x1b", stderr)

    def test_a_full_disk_fails_and_says_where(self):
        self.write("job.json", JOB)
        _, stderr = self.kiln("bake", "job.json", "-o", "/dev/full", "--local", exit_status=1)
        self.assertIn("/dev/full", stderr)


class Stop(KilnTest):
    def test_timeout_exits_5_and_leaves_nothing(self):
        self.write("job.json", long_job())
        self.kiln("bake", "job.json", "-o", "out.exr", "--local", "--timeout", "0.5", exit_status=5)
        self.assertEqual(self.files(), ["job.json"])

    def interrupted(self, number):
        self.write("job.json", long_job())
        self.write("out.exr", "old")
        process = self.start("bake", "job.json", "-o", "out.exr", "--local", "--progress", "json")
        process.stderr.readline()  # the first progress: it bakes
        process.send_signal(number)
        process.communicate(timeout=PATIENCE_S)
        self.assertEqual(self.files(), ["job.json", "out.exr"])
        self.assertEqual(self.read("out.exr"), b"old")
        return process.returncode

    def test_interrupt_exits_130_and_keeps_the_old_file(self):
        self.assertEqual(self.interrupted(signal.SIGINT), 130)
        self.assertEqual(self.interrupted(signal.SIGTERM), 130)

    def test_a_driver_that_never_comes_back_is_left(self):
        self.hang_opencl()
        self.write("job.json", dict(JOB, device="opencl"))
        self.kiln("bake", "job.json", "-o", "out.exr", "--local", "--timeout", "0.1", exit_status=5)
        bake = self.start("bake", "job.json", "-o", "out.exr", "--local", "--timeout", "100",
                          "--progress", "plain")
        # Signals are this process's own business once it blocks them.
        while not self.blocks(bake.pid, signal.SIGINT):
            time.sleep(0.05)
        bake.send_signal(signal.SIGINT)
        bake.communicate(timeout=PATIENCE_S)
        self.assertEqual(bake.returncode, 130)
        self.assertEqual(self.files(), ["job.json", "vendors"])

    @staticmethod
    def blocks(pid, number):
        with open(f"/proc/{pid}/status", encoding="ascii") as file:
            mask = next(line for line in file if line.startswith("SigBlk:")).split()[1]
        return int(mask, 16) >> (number - 1) & 1

    def test_a_kill_leaves_nothing_behind(self):
        self.assertEqual(self.interrupted(signal.SIGKILL), -signal.SIGKILL)


if __name__ == "__main__":
    unittest.main()
