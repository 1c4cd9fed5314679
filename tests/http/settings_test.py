# SPDX-License-Identifier: Apache-2.0
"""Settings: flags, environment, and what a wrong one is told."""
import os
import subprocess
import tempfile
import unittest

from service import KILND, SCRATCH, Server


def kilnd(*arguments, **environment):
    return subprocess.run([KILND, *arguments], capture_output=True, text=True, timeout=60,
                          env={**os.environ, **environment})


class Settings(unittest.TestCase):
    def test_a_wrong_setting_is_named(self):
        for arguments, words in ((["--queue-max", "0"], ["--queue-max", "1 to"]),
                                 (["--queue-max=many"], ["--queue-max", "integer"]),
                                 (["--queue-max", "9" * 30], ["--queue-max"]),
                                 (["--device", "gpu"], ["--device", "auto, opencl, native"]),
                                 (["--colour", "red"], ["--colour"]),
                                 (["--workers"], ["--workers", "value"]),
                                 (["--listen", "nowhere"], ["--listen", "HOST:PORT"]),
                                 (["--listen", "127.0.0.1:65536"], ["--listen"]),
                                 (["--doorbell-fd", "5"], ["--doorbell-fd"])):
            with tempfile.TemporaryDirectory(dir=SCRATCH) as folder:
                result = kilnd("serve", "--data-dir", folder, *arguments)
            self.assertEqual(result.returncode, 2, (arguments, result.stderr))
            for word in words:
                self.assertIn(word, result.stderr)
        result = kilnd("serve", KILN_LEASE_S="x")
        self.assertEqual(result.returncode, 2)
        self.assertIn("KILN_LEASE_S", result.stderr)

    def test_flags_go_over_the_environment(self):
        server = Server("--workers", "0", "--queue-max", "7",
                        environment={"KILN_QUEUE_MAX": "9", "KILN_LEASE_S": "33"})
        try:
            limits = server.get("/v1/capabilities").json["limits"]
            self.assertEqual((limits["queue_max"]["value"], limits["lease_s"]["value"]), (7, 33))
        finally:
            self.assertEqual(server.stop(), 0)

    def test_help_names_every_setting_and_its_variable(self):
        result = kilnd("serve", "--help")
        self.assertEqual(result.returncode, 0)
        for word in ("--listen", "KILN_DATA_DIR", "auto|opencl|native", "--workers"):
            self.assertIn(word, result.stdout)
        self.assertNotIn("doorbell", result.stdout)
        self.assertEqual(kilnd().returncode, 2)

    def test_one_server_a_data_directory(self):
        server = Server("--workers", "0")
        try:
            second = kilnd("serve", "--data-dir", server.data_dir, "--listen", "127.0.0.1:0")
            self.assertEqual(second.returncode, 2)
            self.assertIn(server.data_dir, second.stderr)
        finally:
            self.assertEqual(server.stop(), 0)

    def test_a_taken_port_is_told(self):
        server = Server("--workers", "0")
        try:
            with tempfile.TemporaryDirectory(dir=SCRATCH) as folder:
                address = f"127.0.0.1:{server.port}"
                second = kilnd("serve", "--data-dir", folder, "--listen", address)
            self.assertEqual(second.returncode, 1)
            self.assertIn(str(server.port), second.stderr)
        finally:
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    unittest.main()
