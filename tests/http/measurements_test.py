# SPDX-License-Identifier: Apache-2.0
"""POST /v1/measurements: what is kept, what is refused, and what hostile files cannot do."""
import array
import concurrent.futures
import hashlib
import os
import random
import re
import signal
import socket
import struct
import time
import unittest

import make  # examples/measured/make.py
from service import SCRATCH, ServiceTest, Server, wait_until

LACQUER = make.csv(make.MATERIALS["lacquer"]).encode()
BYTES = {"Content-Type": "application/octet-stream"}


def merl(seed=0):
    """A MERL table of a Lambertian material: 34 992 012 bytes."""
    cells = 90 * 90 * 180
    planes = [array.array("d", [0.2 / 3.14159265 * 1500 / scale]) * cells
              for scale in (1.00, 1.15, 1.66)]
    planes[0][seed] *= 1.5
    return struct.pack("<3i", 90, 90, 180) + b"".join(plane.tobytes() for plane in planes)


class Measurements(ServiceTest):
    FLAGS = ["--device", "native", "--workers", "0"]

    def upload(self, data, headers=None):
        return self.server.request("POST", "/v1/measurements", data,
                                   BYTES if headers is None else headers)

    def files(self):
        """What lies in the store beside its index: (name, size)."""
        root = os.path.join(self.server.data_dir, "measurements", "cas.v1")
        return sorted((name, os.path.getsize(os.path.join(folder, name)))
                      for folder, _, names in os.walk(root) for name in names)

    def test_a_file_is_kept_under_its_hash_with_what_it_says(self):
        data = LACQUER + b"\n"
        answer = self.upload(data)
        self.assertEqual(answer.status, 201, answer.body)
        account = answer.json
        self.assertEqual(account["id"], "sha256:" + hashlib.sha256(data).hexdigest())
        self.assertEqual(answer.headers["Location"], "/v1/measurements/" + account["id"])
        self.assertEqual((account["format"], account["bytes"]), ("csv", len(data)))
        self.assertIsNone(account["unfit"])
        part = account["components"][0]
        self.assertEqual(part["incidence_count"], 4)
        # Lambertian 0.06 and a lobe that was measured to 75 degrees.
        self.assertAlmostEqual(part["incidences"][0]["albedo"][1], 0.103, delta=0.003)
        for name in (account["id"], account["id"][7:], account["id"].replace(":", "%3A")):
            again = self.server.get("/v1/measurements/" + name)
            self.assertEqual((again.status, again.json), (200, account))

    def test_the_same_bytes_are_kept_once(self):
        first = self.upload(LACQUER)
        before = self.files()
        second = self.upload(LACQUER)
        self.assertEqual((second.status, second.json), (200, first.json))
        self.assertEqual(self.files(), before)
        with concurrent.futures.ThreadPoolExecutor(6) as pool:
            data = LACQUER + b"\n\n"
            answers = list(pool.map(lambda _: self.upload(data), range(6)))
        self.assertLessEqual({answer.status for answer in answers}, {200, 201})
        self.assertEqual(len({answer.json["id"] for answer in answers}), 1)
        self.assertEqual(len(self.files()), len(before) + 1)

    def test_pages(self):
        ids = [self.upload(LACQUER + b"\n" * count).json["id"] for count in range(3, 8)]
        seen, cursor = [], ""
        while True:
            page = self.server.get("/v1/measurements?limit=2" + cursor)
            self.assertLessEqual(len(page.json["measurements"]), 2)
            seen += [entry["id"] for entry in page.json["measurements"]]
            if page.json["next_cursor"] is None:
                break
            self.assertIn('rel="next"', page.headers["Link"])
            cursor = "&cursor=" + page.json["next_cursor"]
        self.assertEqual(len(seen), len(set(seen)))
        self.assertEqual([one for one in seen if one in ids], ids[::-1])  # newest first
        for query in ("?limit=0", "?limit=1001", "?cursor=x", "?cursor=-1", "?colour=red"):
            self.assertEqual(self.server.get("/v1/measurements" + query).status, 400, query)

    def test_unknown_ids(self):
        for name in ("sha256:" + "0" * 64, "0" * 64):
            answer = self.server.get("/v1/measurements/" + name)
            self.assertEqual((answer.status, answer.json["code"]), (404, "missing_measurement"))
        for name in ("sha256:0", "sha256:" + "G" * 64, "..%2f..%2fetc%2fpasswd"):
            self.assertEqual(self.server.get("/v1/measurements/" + name).status, 404, name)

    def test_what_no_reader_takes_is_refused_and_not_kept(self):
        before = self.files(), self.server.get("/v1/measurements").json
        cases = {
            b"hello": "unknown_measurement", b"\x00" * 1000: "unknown_measurement",
            b"SCATFUN\x01" + b"\x00" * 60: "unreadable_measurement",
            struct.pack("<3i", -90, -90, 180) + b"\x00" * 100: None,
            struct.pack("<3i", 90, 90, 180) + b"\x00" * 100: "malformed_measurement",
            LACQUER.replace(b"0.5", b"x", 1): "malformed_measurement",
            LACQUER.splitlines()[0] + b"\n0,0,10,0,nan,1,1\n": "malformed_measurement",
            b"tensor_file\x00\x01\x00" + b"\xff" * 64: "malformed_measurement",
        }
        for data, code in cases.items():
            answer = self.upload(data)
            self.assertEqual(answer.status, 422, (data[:40], answer.body))
            self.assertEqual(answer.headers["Content-Type"], "application/problem+json")
            if code:
                self.assertEqual(answer.json["code"], code, data[:40])
        place = self.upload(LACQUER.splitlines()[0] + b"\n0,0,10,0,1,1\n").json["detail"]
        self.assertIn("line 2", place)
        self.assertIn("MERL", self.upload(b"hello").json["detail"])  # what would be understood
        self.assertEqual((self.files(), self.server.get("/v1/measurements").json), before)

    def test_a_measurement_of_which_no_table_can_be_made_says_so(self):
        answer = self.upload(LACQUER.splitlines()[0] + b"\n0,0,10,0,1,1,1\n")
        self.assertEqual(answer.status, 201)
        self.assertTrue(answer.json["unfit"])

    def test_hostile_bytes_leave_the_server_as_it_was(self):
        dice = random.Random(5)
        before = self.server.rss_mib()
        heads = (b"tensor_file\x00\x01\x00", struct.pack("<3i", 90, 90, 180), LACQUER[:400],
                 b'{"data":{"theta_i":{"values":[', b"<WindowElement>", b"type bsdf_data\n",
                 b"VARS=a,b\n")
        for round_number in range(40):
            body = bytearray(heads[round_number % len(heads)] + dice.randbytes(3000))
            answer = self.upload(bytes(body))
            self.assertIn(answer.status, (201, 422), answer.body)
        deep = b'{"theta_i":0,"BRDF":' + b"[" * 500000
        self.assertEqual(self.upload(deep).status, 422)
        self.assertLess(self.server.rss_mib() - before, 30)
        self.assertEqual(self.server.get("/healthz").status, 200)

    def test_lengths(self):
        most = self.server.get("/v1/capabilities").json["limits"]["upload_mib"]["value"] << 20
        self.assertEqual(most, 64 << 20)
        head = b"POST /v1/measurements HTTP/1.1\r\nHost: x\r\nContent-Type: " \
               b"application/octet-stream\r\n"
        for line, status in ((b"Content-Length: %d\r\n" % (most + 1), b"413"), (b"", b"411"),
                             (b"Transfer-Encoding: chunked\r\n", b"411"),
                             (b"Content-Length: -1\r\n", b"400"),
                             (b"Content-Length: 5\r\nContent-Length: 6\r\n", b"400")):
            first = self.server.raw(head + line + b"\r\n").split(b"\r\n")[0]
            self.assertIn(status, first, line)
        self.assertEqual(self.upload(b"").status, 422)

    def test_a_body_that_ends_early_is_not_kept(self):
        before = self.files()
        request = (b"POST /v1/measurements HTTP/1.1\r\nHost: x\r\nContent-Type: "
                   b"application/octet-stream\r\nContent-Length: 100000\r\n\r\n" + LACQUER[:5000])
        self.assertIn(b" 408 ", self.server.raw(request, close_writing=True).split(b"\r\n")[0])
        with socket.create_connection(("127.0.0.1", self.server.port), 10) as connection:
            connection.sendall(request)  # and gone
        wait_until(lambda: self.files() == before, what="the part to be dropped")

    def test_one_connection_carries_many(self):
        head = b"POST /v1/measurements HTTP/1.1\r\nHost: x\r\nContent-Type: " \
               b"application/octet-stream\r\nContent-Length: %d\r\n%s\r\n"
        get = b"GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"
        data = head % (len(LACQUER), b"") + LACQUER + head % (3, b"") + b"abc" + get
        received = self.server.raw(data)
        self.assertEqual(re.findall(rb"HTTP/1.1 (\d+)", received)[1:], [b"422", b"200"])

    def test_content_types(self):
        for headers in ({"Content-Type": "application/json"}, {"Content-Type": "text/plain"},
                        {"Content-Type": "application/x-www-form-urlencoded", "Origin": "http://a"}):
            answer = self.upload(LACQUER, headers)
            self.assertEqual((answer.status, answer.json["code"]), (415, "wrong_type"), headers)
        curl = {"Content-Type": "application/x-www-form-urlencoded"}
        self.assertIn(self.upload(LACQUER, curl).status, (200, 201))

    def test_merl_goes_through(self):
        before = self.server.rss_mib()
        answer = self.upload(merl())
        self.assertEqual(answer.status, 201, answer.body)
        self.assertEqual((answer.json["format"], answer.json["bytes"]), ("merl", 34992012))
        self.assertLess(self.server.rss_mib() - before, 25)  # the front holds none of it

    def test_a_reader_that_dies_takes_nothing_with_it(self):
        before = self.files()
        for attempt in range(1, 9):  # the process lives some tenths of a second
            data = merl(attempt)
            with concurrent.futures.ThreadPoolExecutor(1) as pool:
                upload = pool.submit(self.upload, data)
                killed = self.kill_reader(upload)
                answer = upload.result()
            if killed and answer.status == 422:
                break
        self.assertEqual((answer.status, answer.json["code"]), (422, "unreadable_measurement"))
        self.assertIn("signal 11", answer.json["detail"])
        self.assertNotIn(hashlib.sha256(data).hexdigest(), [name for name, _ in self.files()])
        self.assertGreaterEqual(len(self.files()), len(before))
        self.assertIn(self.upload(LACQUER).status, (200, 201))

    def kill_reader(self, upload):
        while not upload.done():
            for pid in self.server.workers():
                try:
                    with open(f"/proc/{pid}/cmdline", "rb") as file:
                        if b"read-measurement" in file.read():
                            os.kill(pid, signal.SIGSEGV)
                            return True
                except OSError:
                    continue
            time.sleep(0.001)
        return False


class Keeping(unittest.TestCase):
    """What the budget takes, and what survives."""

    def post(self, server, data):
        return server.request("POST", "/v1/measurements", data, BYTES)

    def test_the_least_recently_used_go_unless_a_job_waits_for_them(self):
        server = Server("--workers", "0", "--measurements-mib", "80")
        self.addCleanup(server.stop)
        # Two files of 30 MiB fit, and not three; empty lines are read at once.
        pad = b"\n" * (30 << 20)
        ids = [self.post(server, LACQUER + b"%d,0,5,7,1,1,1\n" % n + pad).json["id"]
               for n in (0, 20)]
        job = {"kind": "slices", "measured": {"data": ids[0]}, "resolution": [9, 5]}
        self.assertEqual(server.post(job).status, 202)
        third = self.post(server, LACQUER + b"40,0,5,7,1,1,1\n" + pad)
        self.assertEqual(third.status, 201, third.body)
        here = {one["id"] for one in server.get("/v1/measurements").json["measurements"]}
        self.assertEqual(here, {ids[0], third.json["id"]})  # ids[0] is older, and named by a job
        self.assertEqual(server.post({**job, "measured": {"data": ids[1]}}).status, 422)
        self.assertEqual(server.post({**job, "measured": {"data": third.json["id"]}}).status, 202)
        full = self.post(server, LACQUER + b"60,0,5,7,1,1,1\n" + pad)
        self.assertEqual((full.status, full.json["code"]), (503, "measurements_full"))

    def test_measurements_outlive_the_server_and_damage_is_noticed(self):
        server = Server("--workers", "0")
        account = self.post(server, LACQUER).json
        folder, digest = server.data_dir, account["id"][7:]
        server.own_dir = False
        self.assertEqual(server.stop(), 0)
        root = os.path.join(folder, "measurements", "cas.v1")
        with open(os.path.join(root, "ab", "ab" + "0" * 62), "wb") as stray:
            stray.write(b"left by a crash")
        server = Server("--workers", "0", data_dir=folder)
        server.own_dir = True
        self.addCleanup(server.stop)
        self.assertEqual(server.get("/v1/measurements/" + account["id"]).json, account)
        self.assertFalse(os.path.exists(stray.name))
        path = os.path.join(root, digest[:2], digest)
        with open(path, "r+b") as file:
            file.write(b"X")
        self.assertEqual(self.post(server, LACQUER).status, 201)  # not 200: it was put afresh
        with open(path, "rb") as file:
            self.assertEqual(file.read(), LACQUER)


if __name__ == "__main__":
    unittest.main()
