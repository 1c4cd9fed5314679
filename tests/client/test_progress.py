# SPDX-License-Identifier: Apache-2.0
"""What standard error shows while a job bakes, on a terminal and elsewhere."""
import json
import os
import pty
import select
import signal
import struct
import subprocess
import fcntl
import termios
import time
import unittest

from kiln_cli import KILN, PATIENCE_S, KilnTest, long_job


class Progress(KilnTest):
    def setUp(self):
        super().setUp()
        self.write("job.json", long_job())
        self.env.pop("NO_COLOR", None)
        self.env.update(TERM="xterm-256color", LC_ALL="C.UTF-8")

    def on_a_terminal(self, until, *arguments, columns=100):
        """Bakes with a terminal as standard error until `until` shows up there; returns what did."""
        master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        bake = subprocess.Popen([KILN, "bake", "job.json", "-o", "out.exr", "--local", *arguments],
                                cwd=self.dir, env=self.env, stdin=subprocess.DEVNULL,
                                stdout=subprocess.DEVNULL, stderr=slave)
        os.close(slave)
        text, interrupted, give_up = b"", False, time.monotonic() + PATIENCE_S
        while time.monotonic() < give_up:
            if not select.select([master], [], [], 1)[0]:
                continue
            try:
                text += os.read(master, 65536)
            except OSError:  # the other end is closed
                break
            if until.encode() in text and not interrupted:
                bake.send_signal(signal.SIGINT)
                interrupted = True
        os.close(master)
        self.assertEqual(bake.wait(timeout=PATIENCE_S), 130, text)
        return text.decode()

    def test_a_bar_on_a_terminal(self):
        text = self.on_a_terminal("left")
        bars = text.split("\r\x1b[2K")
        self.assertIn("baking", text)
        self.assertRegex(text, r"━.* \d+ %")
        self.assertIn("\x1b[33m", text)
        # The bar is wiped before the message, which stands alone.
        self.assertEqual(bars[-1], "kiln: interrupted; nothing was written\r\n")

    def test_no_color(self):
        self.env["NO_COLOR"] = "1"
        text = self.on_a_terminal("%")
        self.assertIn("\r\x1b[2Kbaking", text)
        self.assertNotRegex(text, r"\x1b\[\d*m")

    def test_ascii_where_the_terminal_has_no_utf8(self):
        self.env["LC_ALL"] = "C"
        self.on_a_terminal("left").encode("ascii")

    def test_a_narrow_terminal_keeps_to_one_line(self):
        text = self.on_a_terminal("left", columns=30)
        for bar in text.split("\r\x1b[2K")[1:-1]:
            plain = bar.replace("\x1b[33m", "").replace("\x1b[2m", "").replace("\x1b[0m", "")
            self.assertLess(len(plain), 30, plain)

    def test_a_dumb_terminal_gets_lines(self):
        self.env["TERM"] = "dumb"
        text = self.on_a_terminal("kiln: running")
        self.assertNotIn("\x1b", text)

    def piped(self, *arguments):
        """The first progress line where standard error is a pipe."""
        bake = self.start("bake", "job.json", "-o", "out.exr", "--local", *arguments)
        line = bake.stderr.readline().decode()
        bake.send_signal(signal.SIGINT)
        _, rest = bake.communicate(timeout=PATIENCE_S)
        self.assertEqual(bake.returncode, 130)
        self.assertNotIn("\x1b", line + rest.decode())
        return line

    def test_plain_lines_elsewhere(self):
        for arguments in ((), ("--progress", "plain"), ("--progress", "bar")):
            self.assertRegex(self.piped(*arguments), r"^kiln: running, \d+ %")

    def test_json_lines(self):
        event = json.loads(self.piped("--progress", "json"))
        self.assertEqual((event["event"], event["state"]), ("progress", "running"))
        self.assertTrue(0 <= event["progress"] < 1)

    def test_none(self):
        bake = self.start("bake", "job.json", "-o", "out.exr", "--local", "--progress", "none",
                          "--timeout", "2.5")
        _, stderr = bake.communicate(timeout=PATIENCE_S)
        self.assertEqual(stderr, b"kiln: not done within 2.5 s; nothing was written\n")


if __name__ == "__main__":
    unittest.main()
