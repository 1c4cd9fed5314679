# SPDX-License-Identifier: Apache-2.0
"""`kiln` against the real kilnd."""
import json
import signal
import socket
import subprocess
import time
import unittest
import urllib.request

from kiln_cli import JOB, KILND, PATIENCE_S, KilnTest, long_job


def get(url):
    with urllib.request.urlopen(url, timeout=PATIENCE_S) as answer:
        return json.load(answer)


class Server(KilnTest):
    def setUp(self):
        super().setUp()
        self.url = self.serve()

    def wait_for_state(self, *states):
        """Of the newest job, which is polled until it has one of the states."""
        for _ in range(PATIENCE_S * 20):
            jobs = get(self.url + "/v1/jobs")["jobs"]
            if jobs and jobs[0]["state"] in states:
                return jobs[0]
            time.sleep(0.05)
        self.fail(f"no job became {states}")
        return None

    def test_the_same_bytes_as_local_and_cached_the_second_time(self):
        self.bake_local("local.exr")
        first = self.kiln("bake", "job.json", "-o", "a.exr", "--server", self.url)[1]
        second = self.kiln("bake", "job.json", "-o", "b.exr", "--server", self.url)[1]
        self.assertEqual(self.read("a.exr"), self.read("local.exr"))
        self.assertEqual(self.read("b.exr"), self.read("local.exr"))
        self.assertNotIn("cached", first)
        self.assertIn("cached", second)
        self.assertIn(self.url, first)

    def test_png_report_and_streams(self):
        self.bake_local("local.png")
        self.env["KILN_SERVER"] = self.url
        image, _ = self.kiln("bake", "-", "-o", "-", "--set", "output.format=png", "--report", "r.json",
                             stdin=json.dumps(JOB).encode())
        self.assertEqual(image, self.read("local.png"))
        report = json.loads(self.read("r.json"))
        self.assertEqual(report["job"], get(self.url + "/v1/jobs")["jobs"][0]["id"])

    def test_local_wins_over_the_environment(self):
        self.env["KILN_SERVER"] = "http://127.0.0.1:1"
        self.bake_local("local.exr")

    def test_interrupt_and_timeout_cancel_the_job(self):
        self.write("job.json", long_job())
        bake = self.start("bake", "job.json", "-o", "out.exr", "--server", self.url)
        self.wait_for_state("running")
        bake.send_signal(signal.SIGINT)
        bake.communicate(timeout=PATIENCE_S)
        self.assertEqual(bake.returncode, 130)
        self.wait_for_state("cancelled")
        self.write("job.json", long_job(seed=1))
        self.kiln("bake", "job.json", "-o", "out.exr", "--server", self.url, "--timeout", "1",
                  exit_status=5)
        self.wait_for_state("cancelled")
        self.assertEqual(self.files(), ["data", "job.json"])

    def test_ls_and_cancel(self):
        self.assertEqual(self.kiln("ls", "--server", self.url)[0], b"")
        self.write("job.json", JOB)
        self.kiln("bake", "job.json", "-o", "out.exr", "--server", self.url)
        self.write("long.json", long_job())
        bake = self.start("bake", "long.json", "-o", "long.exr", "--server", self.url)
        running = self.wait_for_state("running")["id"]

        self.env["KILN_SERVER"] = self.url
        lines = self.kiln("ls")[0].decode().splitlines()
        self.assertEqual(len(lines), 2)
        self.assertTrue(lines[0].startswith(running[:12] + "  running"), lines)
        self.assertRegex(lines[1],
                         r"done +100 % +\d+ (s|min) ago  split_sum_scale, split_sum_bias$")
        self.assertEqual(len(self.kiln("ls", "--state", "done")[0].splitlines()), 1)
        self.assertEqual(len(self.kiln("ls", "--limit", "1")[0].splitlines()), 1)
        listed = json.loads(self.kiln("ls", "--json")[0])["jobs"]
        self.assertEqual([job["state"] for job in listed], ["running", "done"])

        self.kiln("cancel", "0123456789abcdef", exit_status=1)
        self.kiln("cancel", listed[1]["id"], exit_status=1)  # has finished
        self.kiln("cancel", running[:10])
        _, stderr = bake.communicate(timeout=PATIENCE_S)
        self.assertEqual(bake.returncode, 1)
        self.assertIn("cancelled", stderr.decode())

    def test_progress_comes_from_the_server(self):
        self.write("job.json", long_job())
        bake = self.start("bake", "job.json", "-o", "out.exr", "--server", self.url, "--progress", "json")
        events = []
        for line in bake.stderr:
            events.append(json.loads(line))
            if events[-1]["progress"] > 0:
                break
        bake.send_signal(signal.SIGINT)
        bake.communicate(timeout=PATIENCE_S)
        self.assertEqual({event["event"] for event in events}, {"progress"})
        self.assertTrue(0 < events[-1]["progress"] < 1)


class NoServer(KilnTest):
    def free_url(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            return f"http://127.0.0.1:{probe.getsockname()[1]}"

    def test_a_named_server_that_is_not_there_exits_4(self):
        self.write("job.json", JOB)
        url = self.free_url()
        for arguments in (("bake", "job.json", "-o", "out.exr", "--server", url), ("ls", "--server", url),
                          ("cancel", "a" * 64, "--server", url)):
            _, stderr = self.kiln(*arguments, exit_status=4)
            self.assertIn(url, stderr)
        self.env["KILN_SERVER"] = url
        stdout, _ = self.kiln("bake", "job.json", "-o", "out.exr", "--json", exit_status=4)
        self.assertEqual(json.loads(stdout)["code"], "unreachable")
        self.assertEqual(self.files(), ["job.json"])

    def test_a_wrong_job_is_refused_before_the_server_is_asked(self):
        self.write("job.json", {"quantities": []})
        self.kiln("bake", "job.json", "-o", "out.exr", "--server", self.free_url(), exit_status=3)

    def test_the_usual_place_is_where_kilnd_listens(self):
        usage = subprocess.run([KILND, "serve", "--help"], capture_output=True, text=True,
                               check=True).stdout
        self.assertRegex(usage, r"default 127\.0\.0\.1:\d+")
        listen = usage.split("--listen")[1].split("default ")[1].split()[0]
        self.assertIn("http://" + listen, self.kiln("ls", "--help")[0].decode())

    def test_with_none_named_and_none_there_it_bakes_itself_and_says_so(self):
        # Whoever runs kilnd at the usual place on this machine gets the job answered from there.
        self.bake_local("local.exr")
        _, stderr = self.kiln("bake", "job.json", "-o", "out.exr")
        self.assertTrue("baking in this process" in stderr or ", from http://" in stderr, stderr)
        self.assertEqual(self.read("out.exr"), self.read("local.exr"))


if __name__ == "__main__":
    unittest.main()
