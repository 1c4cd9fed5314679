# SPDX-License-Identifier: Apache-2.0
"""Deaths of workers and of the front: no job is lost, and the report says what happened."""
import os
import shutil
import signal
import subprocess
import tempfile
import unittest

from service import ENDLESS, KILND, SCRATCH, SMALL, Server, wait_until

# Makes OpenCL calls fail or hang, see tests/compute/clfault.cpp.
CLFAULT_LIBRARY = os.environ["CLFAULT_LIBRARY"]

# Long enough on every CPU to be caught while it runs: 2^30 samples, some seconds.
LONG = {"quantities": ["split_sum_scale", "split_sum_bias"], "resolution": [1024, 1024],
        "sample_count": 1024}


class Survival(unittest.TestCase):
    def serve(self, *flags, **arguments):
        server = Server("--drain-s", "0", *flags, **arguments)
        self.addCleanup(server.stop)
        return server

    def running(self, server, job):
        job_id = server.post(job).json["id"]
        wait_until(lambda: server.state(job_id) == "running", what="the start of the job")
        return job_id

    def result(self, server, job_id):
        def ended():
            status = server.get(f"/v1/jobs/{job_id}?wait=10").json
            return status["state"] not in ("queued", "running") and status
        status = wait_until(ended, 200, "the end of the job")
        return status, server.get(f"/v1/jobs/{job_id}/report").json

    def test_a_killed_worker_is_replaced_and_its_job_done(self):
        server = self.serve()
        job_id = self.running(server, LONG)
        os.kill(server.workers()[0], signal.SIGKILL)
        status, report = self.result(server, job_id)
        self.assertEqual((status["state"], status["attempts"]), ("done", 2))
        self.assertEqual(report["device"]["backend"], "native")
        self.assertIn("signal 9", report["device"]["fallback"])
        self.assertEqual(server.metric("kiln_worker_restarts_total"), 1)
        # The next job is not held back by what happened to this one.
        other = server.bake({**SMALL, "device": "native"})
        self.assertIsNone(server.get(other["links"]["report"]).json["device"]["fallback"])

    def test_a_worker_whose_device_hangs_ends_itself(self):
        # The first read ends the trial of the program, the second a launch of the first job
        # that comes after it; a worker that follows has a first and a second of its own.
        server = self.serve("--stall-s", "3", environment={
            "LD_PRELOAD": CLFAULT_LIBRARY, "CLFAULT": "clEnqueueReadBuffer:2:hang"})
        first = wait_until(server.workers)[0]
        for seed in range(500):  # until the program is built, native does the jobs
            job_id = server.post({**SMALL, "seed": seed}).json["id"]
            def ended():
                self.assertEqual(server.get("/healthz").status, 200)
                return server.state(job_id) not in ("queued", "running")
            wait_until(ended, what="the end of a job on a device that hangs")
            status = server.get("/v1/jobs/" + job_id).json
            self.assertEqual(status["state"], "done")
            if status["attempts"] > 1:
                break
        self.assertEqual(status["attempts"], 2)
        device = server.get(status["links"]["report"]).json["device"]
        self.assertEqual(device["backend"], "native")
        self.assertIn("its device made no progress", device["fallback"])
        self.assertGreaterEqual(server.metric("kiln_worker_restarts_total"), 1)
        self.assertNotEqual(wait_until(server.workers), [first])
        self.assertTrue(any('"event":"hung"' in line for line in server.log))

    def test_a_driver_that_hangs_when_asked_for_its_devices_ends_the_worker(self):
        # With nothing to do a worker asks for the devices: it must not stay there.
        server = self.serve("--stall-s", "1", "--breaker-deaths", "1", environment={
            "LD_PRELOAD": CLFAULT_LIBRARY, "CLFAULT": "clGetPlatformIDs:0:hang"})
        wait_until(lambda: server.metric("kiln_worker_restarts_total") >= 1)
        report = server.get(server.bake(SMALL)["links"]["report"]).json
        self.assertEqual(report["device"]["backend"], "native")
        self.assertIn("worker deaths", report["device"]["fallback"])

    def test_a_stopped_worker_counts_as_hung(self):
        server = self.serve("--silence-s", "2")
        job_id = self.running(server, LONG)
        os.kill(server.workers()[0], signal.SIGSTOP)
        status, report = self.result(server, job_id)
        self.assertEqual((status["state"], status["attempts"]), ("done", 2))
        self.assertIn("no sign of life", report["device"]["fallback"])

    def test_a_job_that_kills_every_worker_fails_in_the_end(self):
        server = self.serve("--device", "native", "--attempts-max", "2")
        job_id = self.running(server, ENDLESS)
        def status():
            return server.get("/v1/jobs/" + job_id).json
        for attempt in (1, 2):
            wait_until(lambda: (status()["state"], status()["attempts"]) == ("running", attempt))
            os.kill(server.workers()[0], signal.SIGSEGV)
        wait_until(lambda: status()["state"] == "failed")
        self.assertIn("signal 11", status()["error"]["detail"])
        self.assertEqual(server.bake(SMALL)["state"], "done")

    def test_many_deaths_switch_opencl_off(self):
        server = self.serve("--breaker-deaths", "2")
        for count in (1, 2):
            pid = wait_until(server.workers)[0]
            os.kill(pid, signal.SIGABRT)
            wait_until(lambda: server.metric("kiln_worker_restarts_total") == count)
        report = server.get(server.bake(SMALL)["links"]["report"]).json
        self.assertEqual(report["device"]["backend"], "native")
        self.assertIn("2 worker deaths", report["device"]["fallback"])

    def test_nothing_is_lost_when_the_front_is_killed(self):
        folder = tempfile.mkdtemp(prefix="service-", dir=SCRATCH)
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        server = self.serve("--device", "native", data_dir=folder)
        finished = server.bake(SMALL)
        image = server.get(finished["links"]["image"]).body
        started = self.running(server, LONG)
        waiting = server.post({**SMALL, "seed": 5}).json["id"]
        orphans = server.workers()
        server.kill()
        wait_until(lambda: not any(os.path.exists(f"/proc/{pid}/exe") for pid in orphans),
                   what="the end of the orphaned worker")
        again = self.serve("--device", "native", data_dir=folder)
        self.assertEqual(again.get(finished["links"]["image"]).body, image)
        self.assertTrue(again.post(SMALL).json["cached"])
        for job_id in (started, waiting):
            self.assertEqual(self.result(again, job_id)[0]["state"], "done")

    def test_a_stop_gives_the_running_job_back(self):
        folder = tempfile.mkdtemp(prefix="service-", dir=SCRATCH)
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        server = self.serve("--device", "native", data_dir=folder)
        job_id = self.running(server, ENDLESS)
        self.assertEqual(server.stop(), 0)
        later = self.serve("--workers", "0", data_dir=folder)
        self.assertEqual(later.state(job_id), "queued")

    def test_without_opencl_native_does_the_job_and_says_why(self):
        server = self.serve(environment={"OCL_ICD_VENDORS": "/nonexistent"})
        device = None
        for seed in range(50):  # at first the reason may be that the program is being built
            report = server.get(server.bake({**SMALL, "seed": seed})["links"]["report"]).json
            device = report["device"]
            self.assertEqual(device["backend"], "native")
            self.assertTrue(device["fallback"])
            if "clGetPlatformIDs" in device["fallback"]:
                return
        self.fail("the reason never named the platform: " + device["fallback"])

    def test_opencl_takes_over_once_it_is_built(self):
        server = self.serve()
        for seed in range(500):
            done = server.bake({**SMALL, "seed": 1000 + seed})
            device = server.get(done["links"]["report"]).json["device"]
            if device["backend"] == "opencl":
                self.assertIsNone(device["fallback"])
                return
        self.fail("no job of 500 ran on OpenCL: " + str(device["fallback"]))

    def test_a_worker_of_its_own(self):
        server = self.serve("--workers", "0")
        job_id = server.post(SMALL).json["id"]
        worker = subprocess.Popen(
            [KILND, "worker", "--data-dir", server.data_dir, "--device", "native"])
        try:
            self.assertEqual(self.result(server, job_id)[0]["state"], "done")
        finally:
            worker.terminate()
            self.assertEqual(worker.wait(60), 0)

    def test_a_worker_ends_with_its_front(self):
        server = self.serve("--device", "native")
        worker = wait_until(server.workers)[0]
        server.kill()
        wait_until(lambda: not os.path.exists(f"/proc/{worker}/exe"))


if __name__ == "__main__":
    unittest.main()
