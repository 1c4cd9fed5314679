# SPDX-License-Identifier: Apache-2.0
"""A real kilnd on a free loopback port, with a data directory of its own."""
import http.client
import json
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest

KILND = os.environ["KILND"]
SCRATCH = os.environ["KILN_SCRATCH"]

SMALL = {"quantities": ["split_sum_scale", "split_sum_bias"], "resolution": [16, 16],
         "sample_count": 64}
# Close to the work limit (2e10 samples): far longer than any test waits for it.
ENDLESS = {"quantities": ["split_sum_scale", "split_sum_bias"], "resolution": [4096, 4096],
           "sample_count": 1024, "device": "native"}


def wait_until(condition, seconds=60, what="the condition"):
    """Polls; the bound only keeps a broken program from hanging the test."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f"{what} did not come about in {seconds} s")


class Answer:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    @property
    def json(self):
        return json.loads(self.body)


class Server:
    def __init__(self, *flags, data_dir=None, environment=None):
        self.own_dir = data_dir is None
        self.data_dir = data_dir or tempfile.mkdtemp(prefix="service-", dir=SCRATCH)
        self.log = []
        self.process = subprocess.Popen(
            [KILND, "serve", "--listen", "127.0.0.1:0", "--data-dir", self.data_dir, *flags],
            stderr=subprocess.PIPE, text=True, errors="replace",
            env={**os.environ, **(environment or {})})
        self.ready = threading.Event()
        self.port = None
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        if not self.ready.wait(60) or self.port is None:
            self.process.kill()
            raise AssertionError("kilnd did not start: " + "".join(self.log))

    def _read(self):
        for line in self.process.stderr:
            self.log.append(line)
            if line.startswith("listening on http://"):
                self.port = int(line.rsplit(":", 1)[1])
                self.ready.set()
        self.ready.set()

    def request(self, method, path, body=None, headers=None, timeout=120):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        try:
            connection.request(method, path, body, headers or {})
            answer = connection.getresponse()
            return Answer(answer.status, answer.headers, answer.read())
        finally:
            connection.close()

    def get(self, path, **headers):
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        return self.request("GET", path, headers=headers)

    def post(self, job, query=""):
        body = job if isinstance(job, (bytes, str)) else json.dumps(job)
        return self.request("POST", "/v1/jobs" + query, body, {"Content-Type": "application/json"})

    def bake(self, job):
        """The finished job resource."""
        answer = self.post(job, "?wait=60")
        assert answer.status in (200, 202), answer.body
        status = answer.json
        while status["state"] in ("queued", "running"):
            status = self.get(f"/v1/jobs/{status['id']}?wait=60").json
        return status

    def state(self, job_id):
        return self.get("/v1/jobs/" + job_id).json["state"]

    def metric(self, name):
        for line in self.get("/metrics").body.decode().splitlines():
            if line.startswith(name + " "):
                return float(line.split()[1])
        raise AssertionError(name + " is not among the metrics")

    def raw(self, data, timeout=20, close_writing=False):
        """What comes back on a fresh connection until the server closes or the time is up."""
        with socket.create_connection(("127.0.0.1", self.port), timeout) as connection:
            received = b""
            try:
                connection.sendall(data)
                if close_writing:
                    connection.shutdown(socket.SHUT_WR)
                while piece := connection.recv(65536):
                    received += piece
            except (TimeoutError, ConnectionResetError, BrokenPipeError):
                pass
            return received

    def workers(self):
        """Process ids of the living workers."""
        found = []
        for name in os.listdir("/proc"):
            try:
                with open(f"/proc/{name}/stat") as stat:
                    fields = stat.read().rsplit(")", 1)[1].split()
                if name.isdigit() and int(fields[1]) == self.process.pid and fields[0] not in "ZX":
                    found.append(int(name))
            except OSError:
                continue
        return found

    def rss_mib(self):
        with open(f"/proc/{self.process.pid}/status") as status:
            for line in status:
                if line.startswith("VmRSS:"):
                    return int(line.split()[1]) / 1024

    def kill(self):
        self.process.kill()
        self.process.wait(30)

    def stop(self):
        """The exit status after SIGTERM."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        status = self.process.wait(60)
        self.reader.join(10)
        self.process.stderr.close()
        if self.own_dir:
            shutil.rmtree(self.data_dir, ignore_errors=True)
        return status


class ServiceTest(unittest.TestCase):
    """One server for the cases of a class, with FLAGS and ENVIRONMENT."""
    FLAGS = ["--device", "native"]
    ENVIRONMENT = {}

    @classmethod
    def setUpClass(cls):
        cls.server = Server(*cls.FLAGS, environment=cls.ENVIRONMENT)

    @classmethod
    def tearDownClass(cls):
        status = cls.server.stop()
        assert status == 0, f"kilnd ended with {status}: " + "".join(cls.server.log[-20:])
