# SPDX-License-Identifier: Apache-2.0
"""Runs the real `kiln` and `kilnd` in a folder of their own."""
import json
import os
import re
import shutil
import subprocess
import tempfile
import threading
import unittest

KILN = os.environ["KILN"]
KILND = os.environ["KILND"]
SOURCE = os.environ["KILN_SOURCE_DIR"]
# Long enough for a loaded machine; nothing here measures time.
PATIENCE_S = 120

# Small, and native: these tests are about the command line, not about devices.
JOB = {
    "quantities": ["split_sum_scale", "split_sum_bias"],
    "resolution": [16, 8],
    "sample_count": 64,
    "device": "native",
}


def long_job(seed=0):
    """A job of minutes, at most a few seconds of which any test waits for."""
    return dict(JOB, resolution=[512, 512], sample_count=65536, seed=seed)


class KilnTest(unittest.TestCase):
    """A fresh folder, an environment without KILN_*, and helpers to run kiln in it."""

    def setUp(self):
        self.dir = tempfile.mkdtemp(prefix="client-", dir=os.environ["KILN_BINARY_DIR"])
        self.addCleanup(shutil.rmtree, self.dir, ignore_errors=True)
        self.env = {k: v for k, v in os.environ.items() if not k.startswith("KILN_")}
        self.env["XDG_CACHE_HOME"] = os.path.join(self.dir, "cache")

    def path(self, name):
        return os.path.join(self.dir, name)

    def write(self, name, content):
        if isinstance(content, (dict, list)):
            content = json.dumps(content)
        if isinstance(content, str):
            content = content.encode()
        with open(self.path(name), "wb") as file:
            file.write(content)
        return name

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def files(self):
        return sorted(name for name in os.listdir(self.dir) if name != "cache")

    def start(self, *arguments, **options):
        options.setdefault("stdin", subprocess.DEVNULL)
        options.setdefault("stdout", subprocess.PIPE)
        options.setdefault("stderr", subprocess.PIPE)
        return subprocess.Popen([KILN, *arguments], cwd=self.dir, env=self.env, **options)

    def kiln(self, *arguments, stdin=b"", exit_status=0):
        """Runs kiln; returns (stdout bytes, stderr text)."""
        done = subprocess.run([KILN, *arguments], cwd=self.dir, env=self.env, input=stdin,
                              capture_output=True, timeout=PATIENCE_S, check=False)
        stderr = done.stderr.decode()
        self.assertEqual(done.returncode, exit_status,
                         f"kiln {' '.join(arguments)}\n{done.stdout[:2000]!r}\n{stderr}")
        return done.stdout, stderr

    def bake_local(self, output, job=None, *arguments):
        self.write("job.json", job or JOB)
        return self.kiln("bake", "job.json", "-o", output, "--local", *arguments)

    def hang_opencl(self):
        """Whoever asks for an OpenCL platform from now on never gets an answer."""
        self.env["OCL_ICD_VENDORS"] = self.path("vendors")
        os.mkdir(self.path("vendors"))
        os.mkfifo(self.path("vendors/hang.icd"))  # opening a pipe that nobody writes blocks

    def serve(self, *arguments):
        """Starts kilnd on a free port; returns its URL. It ends with the test."""
        env = dict(self.env)
        server = subprocess.Popen(
            [KILND, "serve", "--listen", "127.0.0.1:0", "--data-dir", self.path("data"),
             "--device", "native", *arguments],
            cwd=self.dir, env=env, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE, text=True)
        log = []
        for line in server.stderr:
            log.append(line)
            found = re.search(r"listening on (http://\S+)", line)
            if found:
                # A pipe that nobody reads would stop the server once it is full.
                reader = threading.Thread(target=server.stderr.read)
                reader.start()
                self.addCleanup(server.stderr.close)
                self.addCleanup(reader.join)
                self.addCleanup(self._stop, server)
                return found.group(1)
        self._stop(server)
        self.fail("kilnd did not start:\n" + "".join(log))
        return None

    @staticmethod
    def _stop(server):
        server.terminate()
        try:
            server.wait(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()
