# SPDX-License-Identifier: Apache-2.0
"""Servers that do what a sound kilnd never does: `kiln` must neither believe them nor wait for ever."""
import hashlib
import http.server
import json
import threading
import unittest

from kiln_cli import JOB, KilnTest

ID = "0" * 64
IMAGE = b"not really an image"
REPORT = {"job": ID, "status": "done", "device": {"backend": "native", "name": "x", "numerics": "y",
                                                  "fallback": None},
          "samples": {"per_texel": 1, "total": 1}, "error": {}, "warnings": ["\u001b[2Jboo"]}


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def answer(self):
        length = int(self.headers.get("Content-Length") or 0)
        self.rfile.read(length)
        path = self.path.split("?")[0]
        self.server.asked.append((self.command, path))
        status, body, headers = self.server.behave(self.command, path)
        self.send_response(status)
        for name, value in headers.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    do_GET = do_POST = do_DELETE = answer

    def log_message(self, *_):
        pass


def sound(command, path):
    """A done job, its image and its report."""
    if path.endswith("/image"):
        return 200, IMAGE, {"ETag": f'"{hashlib.sha256(IMAGE).hexdigest()}"'}
    if path.endswith("/report"):
        return 200, json.dumps(REPORT).encode(), {}
    status = {"id": ID, "state": "done", "progress": 1, "cached": False, "error": None, "links": {}}
    return 200, json.dumps(status).encode(), {}


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, *_):
        """A client that hangs up is what some of these tests want."""


class Misbehaving(KilnTest):
    def bake(self, behave, exit_status, *arguments):
        server = Server(("127.0.0.1", 0), Handler)
        server.behave, server.asked = behave, []
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        try:
            self.write("job.json", JOB)
            url = f"http://127.0.0.1:{server.server_address[1]}"
            _, stderr = self.kiln("bake", "job.json", "-o", "out.exr", "--server", url, *arguments,
                                  exit_status=exit_status)
        finally:
            server.shutdown()
            server.server_close()
        self.asked = server.asked
        if exit_status != 0:
            self.assertEqual(self.files(), ["job.json"])
        return stderr

    def only(self, suffix, answer):
        """Sound, but for requests whose path ends so."""
        return lambda command, path: answer if path.endswith(suffix) else sound(command, path)

    def test_the_sound_one_is_believed_but_its_control_characters_are_not_printed(self):
        stderr = self.bake(sound, 0)
        self.assertEqual(self.read("out.exr"), IMAGE)
        self.assertIn("\\x1B[2Jboo", stderr)

    def test_an_image_damaged_on_the_way(self):
        etag = {"ETag": f'"{hashlib.sha256(IMAGE).hexdigest()}"'}
        stderr = self.bake(self.only("/image", (200, IMAGE + b"!", etag)), 1)
        self.assertIn("SHA-256", stderr)

    def test_an_image_without_a_promise(self):
        for headers in ({}, {"ETag": '"v1"'}, {"ETag": 'W/"' + "0" * 64 + '"'}):
            self.assertIn("ETag", self.bake(self.only("/image", (200, IMAGE, headers)), 1))

    def test_answers_that_are_no_json(self):
        self.bake(lambda *_: (200, b"<html>hello</html>", {}), 1)
        self.bake(lambda *_: (200, b"[" * 100000, {}), 1)
        self.bake(self.only("/report", (200, b"{", {})), 1)

    def test_an_id_that_is_no_id_is_not_put_into_a_path(self):
        status = {"id": "../../etc", "state": "running", "progress": 0}
        self.bake(lambda *_: (200, json.dumps(status).encode(), {}), 1)
        self.assertEqual(self.asked, [("POST", "/v1/jobs")])

    def test_answers_without_end(self):
        self.assertIn("bytes", self.bake(lambda *_: (200, b" " * (2 << 20), {}), 1))

    def test_a_problem_document_of_the_server_is_shown(self):
        problem = {"code": "invalid_job", "detail": "no", "problems": [{"pointer": "/seed", "message": "odd"}]}
        stderr = self.bake(self.only("/v1/jobs", (422, json.dumps(problem).encode(), {})), 3)
        self.assertIn("/seed: odd", stderr)

    def test_a_failed_job_says_why(self):
        status = {"id": ID, "state": "failed", "progress": 0.5,
                  "error": {"code": "device_failed", "detail": "the card is gone"}}
        self.assertIn("the card is gone", self.bake(lambda *_: (200, json.dumps(status).encode(), {}), 1))

    def test_full_and_then_not(self):
        answers = iter([(429, b"", {"Retry-After": "1"}), (503, b"", {})])
        stderr = self.bake(lambda *request: next(answers, None) or sound(*request), 0)
        self.assertEqual(self.asked[:3], [("POST", "/v1/jobs")] * 3)
        self.assertIn("out.exr", stderr)

    def test_full_for_longer_than_anyone_waits(self):
        self.bake(lambda *_: (503, b"", {"Retry-After": "86400"}), 4)

    def test_a_full_server_does_not_outlast_the_timeout(self):
        self.bake(lambda *_: (503, b"", {"Retry-After": "50"}), 5, "--timeout", "0.5")
        self.assertEqual(self.asked[-1][0], "DELETE")

    def test_redirects_are_not_followed(self):
        self.bake(lambda *_: (302, b"", {"Location": "http://127.0.0.1:1/"}), 1)


if __name__ == "__main__":
    unittest.main()
