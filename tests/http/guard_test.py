# SPDX-License-Identifier: Apache-2.0
"""Raw bytes against the guard. Every case leaves the server answering and small."""
import json
import os
import select
import socket
import time
import unittest

from service import SMALL, ServiceTest, wait_until

JOB = json.dumps(SMALL).encode()
HOST = b"Host: x\r\n"


def post(headers, body=b"", path=b"/v1/jobs"):
    return b"POST " + path + b" HTTP/1.1\r\n" + HOST + headers + b"\r\n" + body


def get(path, headers=b""):
    return b"GET " + path + b" HTTP/1.1\r\n" + HOST + headers + b"\r\n"


def statuses(answer):
    """Of every answer in the bytes that came back; each has a Content-Length here."""
    found = []
    while answer:
        head, _, answer = answer.partition(b"\r\n\r\n")
        found.append(int(head.split(b" ", 2)[1]))
        lengths = [line for line in head.lower().split(b"\r\n")
                   if line.startswith(b"content-length:")]
        if found[-1] != 100:  # an interim answer has no body
            answer = answer[int(lengths[0].split(b":")[1]):] if lengths else b""
    return found


class Guard(ServiceTest):
    # Timeouts shortened so that slow clients are cut off within the test.
    FLAGS = ["--device", "native", "--header-timeout-s", "1", "--idle-timeout-s", "1",
             "--body-timeout-s", "1", "--connections-max", "64"]

    # Heads (16 KiB) and bodies (64 KiB) of 64 connections and their threads stay far below; the
    # floods here send as much and more, so a guard that keeps what it is sent fails.
    RSS_RISE_MIB = 64

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.idle_rss = cls.server.rss_mib()

    def tearDown(self):
        # Connections that a case abandoned may wait to be accepted and dropped.
        wait_until(lambda: self.server.get("/healthz").status == 200)
        self.assertLess(self.server.rss_mib(), self.idle_rss + self.RSS_RISE_MIB)
        self.assertIsNone(self.server.process.poll())

    def refused(self, data, status):
        """One answer with that status and a problem document, then the end of the connection."""
        answer = self.server.raw(data)
        self.assertEqual(statuses(answer), [status], data[:200])
        self.assertIn(b"application/problem+json", answer)
        self.assertIn(b"Connection: close", answer)
        self.assertEqual(json.loads(answer.partition(b"\r\n\r\n")[2])["status"], status)

    def flood(self, start, piece, pieces):
        """What comes back while `piece` is sent again and again; a reset is an answer too."""
        received = b""
        with socket.create_connection(("127.0.0.1", self.server.port), 20) as connection:
            try:
                connection.sendall(start)
                for _ in range(pieces):
                    connection.sendall(piece)
                while more := connection.recv(65536):
                    received += more
            except OSError:
                pass
        return received

    def healthy_again(self):
        request = get(b"/healthz", b"Connection: close\r\n")
        wait_until(lambda: statuses(self.server.raw(request)) == [200])

    def test_head_floods_end_early(self):
        mebibyte = b"a" * (1 << 20)
        line = b"GET / HTTP/1.1\r\n"
        for start, piece in ((b"", mebibyte), (b"GET /", mebibyte), (line + b"x: ", mebibyte),
                             (line, b"a: b\r\n" * 100000), (b"\r\n", b"\r\n" * 100000)):
            answer = self.flood(start, piece, 64)
            if answer:
                self.assertIn(statuses(answer)[0], (400, 431))

    def test_head_limits(self):
        self.refused(get(b"/healthz", b"x: " + b"a" * 17000 + b"\r\n"), 431)
        self.refused(get(b"/healthz", b"".join(b"x%d: y\r\n" % i for i in range(80))), 431)
        self.refused(get(b"/" + b"a" * 300), 414)
        self.refused(get(b"/" + b"a" * 8192), 414)
        self.refused(get(b"/healthz?" + b"a" * 4000), 414)
        within = get(b"/healthz", b"Connection: close\r\nx: " + b"a" * 8000 + b"\r\n")
        self.assertEqual(statuses(self.server.raw(within)), [200])

    def test_body_framing(self):
        chunked = b"Transfer-Encoding: chunked\r\n"
        for headers, body, status in (
                (chunked, b"5\r\nhello\r\n0\r\n\r\n", 411),
                (chunked, b"-2\r\n" + b"a" * 1000, 411),
                (chunked + b"Content-Length: 5\r\n", b"hello", 411), (b"", b"", 411),
                (b"Content-Length: 5\r\nContent-Encoding: gzip\r\n", b"hello", 415),
                (b"Content-Length: 5\r\nContent-Encoding: br\r\n", b"hello", 415),
                (b"Content-Length: 200000000\r\n", b"", 413),
                (b"Content-Length: 65537\r\n", b"", 413),
                (b"Content-Length: abc\r\n", b"", 400),
                (b"Content-Length: -1\r\n", b"", 400),
                (b"Content-Length: +5\r\n", b"hello", 400),
                (b"Content-Length: 0x5\r\n", b"hello", 400),
                (b"Content-Length: 5, 5\r\n", b"hello", 400), (b"Content-Length:\r\n", b"", 400),
                (b"Content-Length: 1" + b"0" * 23 + b"\r\n", b"", 400),
                (b"Content-Length: 5\r\nContent-Length: 5\r\n", b"hello", 400),
                (b"Content-Length: 5\r\nContent-Length: 6\r\n", b"hello", 400),
                (b"Expect: nothing\r\nContent-Length: 5\r\n", b"hello", 417)):
            with self.subTest(headers):
                self.refused(post(headers, body), status)

    def test_a_refused_body_is_not_taken(self):
        answer = self.flood(post(b"Content-Length: 200000000\r\n"), b"x" * (1 << 20), 200)
        if answer:
            self.assertEqual(statuses(answer), [413])

    def test_who_sends_too_much_is_told_why(self):
        # The client of many a library writes its whole body before it reads. The close that follows
        # the refusal must not break that off, or the reason is never read.
        with socket.create_connection(("127.0.0.1", self.server.port), 20) as connection:
            connection.sendall(post(b"Content-Length: %d\r\n" % (1 << 20)))
            self.assertTrue(select.select([connection], [], [], 20)[0])
            for _ in range(16):
                connection.sendall(b"x" * (1 << 16))
                time.sleep(0.01)  # for a reset to arrive
            self.assertEqual(statuses(connection.recv(65536)), [413])

    def test_bodies_cannot_carry_requests(self):
        inner = get(b"/metrics")
        length = b"Content-Length: %d\r\n" % len(inner)
        for method in (b"GET", b"HEAD", b"DELETE"):
            self.refused(method + b" /healthz HTTP/1.1\r\n" + HOST + length + b"\r\n" + inner, 400)
        for path, status in ((b"/nowhere", 404), (b"/healthz", 405)):
            answer = self.server.raw(post(length, inner, path))
            self.assertEqual(statuses(answer), [status])

    def test_lines_that_readers_see_differently(self):
        for data in (b"GET /healthz HTTP/1.1\nHost: x\n\n",
                     b"GET /healthz HTTP/1.1\r\nHost: x\n\r\n",
                     get(b"/healthz", b"a: b\r\n c\r\n"), get(b"/healthz", b"a : b\r\n"),
                     get(b"/healthz", b": b\r\n"), get(b"/healthz", b"nothing\r\n"),
                     get(b"/healthz", b"a: b\0c\r\n"), get(b"/healthz", b"a: b\rc\r\n"),
                     get(b"/healthz", b"Host: y\r\n"), b"GET /healthz HTTP/1.1\r\n\r\n",
                     b"GET /healthz\r\n\r\n", b"GET  /healthz HTTP/1.1\r\n" + HOST + b"\r\n",
                     b"GET http://x/healthz HTTP/1.1\r\n" + HOST + b"\r\n",
                     b"G(T /healthz HTTP/1.1\r\n" + HOST + b"\r\n",
                     b"\x16\x03\x01\x02\0\x01\0\r\n\r\n"):
            with self.subTest(data):
                self.refused(data, 400)
        self.refused(b"GET /healthz HTTP/2.0\r\n" + HOST + b"\r\n", 505)

    def test_paths_are_exact(self):
        jobs, zeros = b"/v1/jobs/", b"0" * 64
        for path in (b"/..%2f..%2fetc%2fpasswd", jobs + b"..%2f..%2f" + b"a" * 52,
                     jobs + b"../../etc/passwd", jobs + b"A" * 64, jobs + b"0" * 63 + b"%30",
                     b"//healthz", b"/healthz/", b"/%68ealthz", jobs + zeros + b"%00",
                     jobs + zeros + b"/image.exr/"):
            answer = self.server.raw(get(path, b"Connection: close\r\n"))
            self.assertEqual(statuses(answer), [404], path)
        for query in (b"a=%00", b"a=%0d%0aX:1", b"a=%", b"a=%g0", b"a=1&a=2"):
            self.assertEqual(statuses(self.server.raw(get(b"/v1/jobs?" + query))), [400], query)

    def test_headers_are_not_reflected(self):
        headers = b"REMOTE_ADDR: 1.2.3.4\r\nX: a%0d%0aSet-Cookie:%20b\r\nConnection: close\r\n"
        answer = self.server.raw(get(b"/v1/jobs/" + b"0" * 64, headers))
        head = answer.partition(b"\r\n\r\n")[0].lower()
        for leaked in (b"1.2.3.4", b"set-cookie", b"exception", b"remote_addr"):
            self.assertNotIn(leaked, head)

    def test_pipelined_requests_are_each_answered(self):
        count = 1000
        last = get(b"/healthz", b"Connection: close\r\n")
        answer = self.server.raw(get(b"/healthz") * (count - 1) + last)
        self.assertEqual(statuses(answer), [200] * count)

    def test_http_1_0_and_continue(self):
        answer = self.server.raw(b"GET /healthz HTTP/1.0\r\n\r\n")
        self.assertEqual(statuses(answer), [200])
        headers = b"Content-Length: %d\r\nExpect: 100-continue\r\nConnection: close\r\n" % len(JOB)
        answer = self.server.raw(post(headers, JOB))
        self.assertTrue(answer.startswith(b"HTTP/1.1 100 Continue\r\n\r\n"))
        self.assertIn(statuses(answer)[-1], (200, 202))

    def test_slow_clients_are_cut_off(self):
        self.assertEqual(statuses(self.server.raw(b"GET /healthz HTTP/1.1\r\nHost")), [408])
        self.assertEqual(statuses(self.server.raw(post(b"Content-Length: 100\r\n", b"{"))), [408])
        self.assertEqual(self.server.raw(b""), b"")

    def test_idle_connections_make_room(self):
        idle = []
        try:
            for _ in range(200):  # three times as many as are served at once
                idle.append(socket.create_connection(("127.0.0.1", self.server.port), 20))
            self.healthy_again()
        finally:
            for connection in idle:
                connection.close()

    def test_too_many_connections_are_told(self):
        # Clients in the middle of a head hold their places until the header timeout.
        held = []
        try:
            for _ in range(64):
                held.append(socket.create_connection(("127.0.0.1", self.server.port), 20))
                held[-1].sendall(b"GET /healthz HTTP/1.1\r\n")
            answer = self.server.raw(b"")
            if answer:  # unless a place came free in the meantime
                self.assertEqual(statuses(answer), [503])
                self.assertIn(b"Retry-After", answer)
        finally:
            for connection in held:
                connection.close()
        self.healthy_again()

    def test_descriptors_are_given_back(self):
        def open_sockets():
            folder = f"/proc/{self.server.process.pid}/fd"
            count = 0
            for name in os.listdir(folder):
                try:
                    count += os.readlink(f"{folder}/{name}").startswith("socket:")
                except FileNotFoundError:
                    continue  # closed since it was listed
            return count
        before = wait_until(lambda: open_sockets() <= 8 and open_sockets())
        for _ in range(100):
            with socket.create_connection(("127.0.0.1", self.server.port), 20) as connection:
                connection.sendall(get(b"/openapi.json"))
        wait_until(lambda: open_sockets() <= before, what="the end of abandoned connections")


if __name__ == "__main__":
    unittest.main()
