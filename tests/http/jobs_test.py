# SPDX-License-Identifier: Apache-2.0
"""Jobs over HTTP, from the document to the bytes."""
import concurrent.futures
import hashlib
import json
import socket
import unittest

from service import ENDLESS, SMALL, Server, ServiceTest, wait_until


class Jobs(ServiceTest):
    def test_a_job_becomes_an_image_with_a_report(self):
        done = self.server.bake(SMALL)
        self.assertEqual(done["state"], "done")
        self.assertEqual(done["progress"], 1)
        self.assertIsNone(done["error"])
        image = self.server.get(done["links"]["image"])
        self.assertEqual(image.status, 200)
        self.assertEqual(image.body[:4], b"\x76\x2f\x31\x01")  # OpenEXR magic number
        self.assertEqual(image.headers["Content-Type"], "image/x-exr")
        self.assertIn("immutable", image.headers["Cache-Control"])
        report = self.server.get(done["links"]["report"]).json
        self.assertEqual(report["job"], done["id"])
        self.assertEqual(report["device"]["backend"], "native")
        self.assertGreater(report["samples"]["total"], 0)
        for channel in SMALL["quantities"]:
            self.assertGreater(report["error"][channel]["standard_error_max"], 0)
            self.assertGreater(report["error"][channel]["quantisation_max"], 0)
        self.assertGreater(report["run_time_s"]["total"], 0)
        # The resource keeps the whole table's figure, not that of the last look at a part.
        largest = max(error["standard_error_max"] for error in report["error"].values())
        self.assertAlmostEqual(done["standard_error_max"], largest, delta=1e-12)

    def test_a_study_is_a_picture_whose_report_holds_the_numbers(self):
        done = self.server.bake({"kind": "furnace", "device": "native", "sample_count": 256})
        image = self.server.get(done["links"]["image"])
        self.assertEqual(image.headers["Content-Type"], "image/png")
        self.assertEqual(image.body[:4], b"\x89PNG")
        report = self.server.get(done["links"]["report"]).json
        self.assertEqual(report["job"], done["id"])
        names = [verdict["name"] for verdict in report["study"]["verdicts"]]
        self.assertIn("reciprocity", names)
        self.assertEqual(len(report["study"]["table"]["columns"]), 4)

    def test_the_second_answer_is_the_first(self):
        job = {**SMALL, "seed": 11}
        first = self.server.bake(job)
        hits = self.server.metric("kiln_cache_hits_total")
        second = self.server.post(json.dumps(dict(reversed(job.items())), indent=3))
        self.assertEqual(second.status, 200)
        self.assertTrue(second.json["cached"])
        self.assertEqual(second.json["id"], first["id"])
        self.assertEqual(self.server.metric("kiln_cache_hits_total"), hits + 1)
        one, two = (self.server.get(x["links"]["image"]).body for x in (first, second.json))
        self.assertEqual(one, two)

    def test_an_image_is_named_by_its_bytes(self):
        done = self.server.bake({**SMALL, "seed": 12})
        path = done["links"]["image"]
        whole = self.server.get(path)
        tag = whole.headers["ETag"]
        self.assertEqual(tag, '"' + hashlib.sha256(whole.body).hexdigest() + '"')
        for known in (tag, "*", '"x", W/' + tag):
            unchanged = self.server.get(path, If_None_Match=known)
            self.assertEqual((unchanged.status, unchanged.body), (304, b""))
        self.assertEqual(self.server.get(path, If_None_Match='"x"').status, 200)
        head = self.server.request("HEAD", path)
        self.assertEqual((head.status, head.body), (200, b""))
        self.assertEqual(int(head.headers["Content-Length"]), len(whole.body))
        self.assertEqual(self.server.get(path.rsplit(".", 1)[0]).body, whole.body)

    def test_a_single_range(self):
        path = self.server.bake({**SMALL, "seed": 13})["links"]["image"]
        whole = self.server.get(path).body
        size = len(whole)
        for text, expected in (("0-0", whole[:1]), ("10-19", whole[10:20]), ("-7", whole[-7:]),
                               ("5-", whole[5:]), (f"0-{10**15}", whole)):
            part = self.server.get(path, Range="bytes=" + text)
            self.assertEqual((part.status, part.body), (206, expected), text)
            self.assertTrue(part.headers["Content-Range"].endswith(f"/{size}"))
        for text in (f"{size}-", "2-1", "-0", "0-1,3-4", "x-", "-", "1", f"{2**70}-"):
            refused = self.server.get(path, Range="bytes=" + text)
            self.assertEqual(refused.status, 416, text)
            self.assertEqual(refused.headers["Content-Range"], f"bytes */{size}")
        changed = self.server.get(path, Range="bytes=0-0", If_Range='"other"')
        self.assertEqual((changed.status, changed.body), (200, whole))

    def test_the_wrong_extension_names_the_right_one(self):
        done = self.server.bake({**SMALL, "output": {"format": "png"}})
        self.assertTrue(done["links"]["image"].endswith("/image.png"))
        self.assertEqual(self.server.get(done["links"]["image"]).body[:4], b"\x89PNG")
        wrong = self.server.get(f"/v1/jobs/{done['id']}/image.exr")
        self.assertEqual(wrong.status, 404)
        self.assertIn("image.png", wrong.json["detail"])

    def test_a_hundred_equal_posts_are_one_computation(self):
        job = {**SMALL, "resolution": [128, 128], "sample_count": 1024, "seed": 14}
        misses = self.server.metric("kiln_cache_misses_total")
        with concurrent.futures.ThreadPoolExecutor(100) as pool:
            answers = list(pool.map(lambda _: self.server.bake(job), range(100)))
        self.assertEqual({x["id"] for x in answers}, {answers[0]["id"]})
        self.assertEqual({(x["state"], x["attempts"]) for x in answers}, {("done", 1)})
        self.assertEqual(self.server.metric("kiln_cache_misses_total"), misses + 1)

    def test_events_end_with_the_job(self):
        job = {**SMALL, "resolution": [256, 256], "sample_count": 4096, "seed": 15}
        posted = self.server.post(job).json
        stream = self.server.get(posted["links"]["events"])
        self.assertEqual(stream.headers["Content-Type"], "text/event-stream")
        events = [e for e in stream.body.decode().split("\n\n") if "data: " in e]
        states = [json.loads(e.split("data: ", 1)[1])["state"] for e in events]
        self.assertEqual(states[-1], "done")
        self.assertEqual(states, sorted(states, key=["queued", "running", "done"].index))

    def test_pages(self):
        for seed in range(3):
            self.server.bake({**SMALL, "seed": 100 + seed})
        seen, path = [], "/v1/jobs?state=done&limit=2"
        while path:
            page = self.server.get(path)
            self.assertEqual(page.status, 200)
            self.assertLessEqual(len(page.json["jobs"]), 2)
            seen += [x["id"] for x in page.json["jobs"]]
            cursor = page.json["next_cursor"]
            path = cursor and f"/v1/jobs?state=done&limit=2&cursor={cursor}"
        self.assertGreaterEqual(len(seen), 3)
        self.assertEqual(len(seen), len(set(seen)))
        for query in ("state=x", "limit=0", "limit=1001", "limit=1e2", "colour=red",
                      "limit=1&limit=2", "cursor=zz", "cursor=0"):
            self.assertEqual(self.server.get("/v1/jobs?" + query).status, 400, query)

    def test_a_batch_answers_each_job(self):
        good = {**SMALL, "seed": 21}
        batch = {"jobs": [good, {**SMALL, "sampel_count": 3}, good]}
        answer = self.server.request("POST", "/v1/batches", json.dumps(batch))
        self.assertEqual(answer.status, 200)
        first, wrong, again = answer.json["jobs"]
        self.assertEqual(wrong["status"], 422)
        self.assertEqual(wrong["problem"]["problems"][0]["pointer"], "/sampel_count")
        self.assertEqual(first["job"]["id"], again["job"]["id"])
        self.assertIn(first["status"], (200, 202))

    def test_what_the_server_says_of_itself(self):
        self.assertEqual(self.server.get("/healthz").status, 200)
        wait_until(lambda: self.server.get("/readyz").status == 200)
        capabilities = wait_until(
            lambda: (c := self.server.get("/v1/capabilities").json)["workers"][0]["devices"] and c)
        self.assertEqual(capabilities["limits"]["queue_max"]["value"], 64)
        self.assertEqual(capabilities["limits"]["job_bytes_max"]["value"], 65536)
        self.assertIn("sobol_owen", capabilities["values"]["sampler"])
        self.assertEqual(self.server.get("/openapi.json").json["openapi"], "3.1.0")

    def test_unknown_things(self):
        self.assertEqual(self.server.get("/v1/jobs/" + "0" * 64).status, 404)
        self.assertEqual(self.server.get("/v1/jobs/" + "0" * 63).status, 404)
        self.assertEqual(self.server.request("DELETE", "/v1/jobs/" + "0" * 64).status, 404)
        wrong = self.server.request("DELETE", "/healthz")
        self.assertEqual((wrong.status, wrong.headers["Allow"]), (405, "GET, HEAD"))
        put = self.server.request("PUT", "/v1/jobs", "{}")
        self.assertEqual((put.status, put.headers["Allow"]), (405, "POST, GET, HEAD"))
        text = self.server.request("POST", "/v1/jobs", "{}", {"Content-Type": "text/plain"})
        self.assertEqual((text.status, text.json["code"]), (415, "wrong_type"))
        # Invalid jobs, so that what is let in answers 422.
        form = {"Content-Type": "application/x-www-form-urlencoded"}
        self.assertEqual(self.server.request("POST", "/v1/jobs", "{}", form).status, 422)
        from_a_page = {**form, "Origin": "http://example.org"}
        self.assertEqual(self.server.request("POST", "/v1/jobs", "{}", from_a_page).status, 415)
        for wait in ("-1", "61", "x", "nan", "1e400"):
            self.assertEqual(self.server.post(SMALL, "?wait=" + wait).status, 400, wait)


class Downloads(unittest.TestCase):
    def test_what_is_sent_at_once_is_bounded(self):
        server = Server("--device", "native", "--hot-cache-mib", "1", "--downloads-mib", "12")
        # Noise of 4 channels, so that the file hardly shrinks: larger than half of the budget and
        # than what the sockets between a server and a client that does not read may hold (10 MiB).
        job = {"quantities": ["split_sum_scale", "split_sum_bias", "directional_albedo",
                              "multiscatter_albedo"],
               "resolution": [1024, 1024], "sample_count": 16, "sampler": "random",
               "importance": "ndf", "output": {"format": "exr", "pixel": "float"}}
        try:
            first, second = (server.bake({**job, "seed": seed})["links"]["image"]
                             for seed in (0, 1))
            with socket.create_connection(("127.0.0.1", server.port), 60) as idle:
                idle.sendall(f"GET {first} HTTP/1.1\r\nHost: x\r\n\r\n".encode())
                self.assertTrue(idle.recv(1))  # the answer is on its way, and stays there
                self.assertGreater(int(server.request("HEAD", first).headers["Content-Length"]),
                                   11 << 20)
                refused = server.get(second)
                self.assertEqual(refused.status, 503)
                self.assertEqual(refused.json["code"], "too_many_downloads")
                self.assertIn("12 MiB", refused.json["detail"])
                self.assertGreater(int(refused.headers["Retry-After"]), 0)
                self.assertEqual(server.get(first).status, 200)  # shares the bytes
                self.assertEqual(server.get("/healthz").status, 200)
            wait_until(lambda: server.get(second).status == 200, what="a place that came free")
        finally:
            self.assertEqual(server.stop(), 0)


class Queue(unittest.TestCase):
    def test_a_full_queue_refuses_and_recovers(self):
        server = Server("--device", "native", "--queue-max", "2", "--drain-s", "0")
        try:
            running = server.post(ENDLESS).json["id"]
            wait_until(lambda: server.state(running) == "running")
            queued = [server.post({**ENDLESS, "seed": seed}) for seed in (1, 2)]
            self.assertEqual([x.status for x in queued], [202, 202])
            refused = server.post({**ENDLESS, "seed": 3})
            self.assertEqual((refused.status, refused.json["code"]), (429, "queue_full"))
            self.assertGreater(int(refused.headers["Retry-After"]), 0)
            known = server.post({**ENDLESS, "seed": 1})
            self.assertEqual(known.status, 202)  # it takes no new place
            self.assertEqual(server.get("/healthz").status, 200)
            removed = server.request("DELETE", queued[0].json["links"]["self"])
            self.assertEqual((removed.status, removed.json["state"]), (200, "cancelled"))
            self.assertEqual(server.post({**ENDLESS, "seed": 3}).status, 202)
        finally:
            self.assertEqual(server.stop(), 0)

    def test_cancelling_stops_the_engine(self):
        server = Server("--device", "native", "--drain-s", "0")
        try:
            job = server.post(ENDLESS).json["id"]
            wait_until(lambda: server.state(job) == "running")
            early = server.get(f"/v1/jobs/{job}/image")
            self.assertEqual((early.status, early.json["code"]), (409, "not_done"))
            self.assertIn(server.request("DELETE", "/v1/jobs/" + job).status, (200, 202))
            wait_until(lambda: server.state(job) == "cancelled")
            # The one worker is free: a job behind the cancelled one is done, at the first attempt.
            self.assertEqual(server.bake(SMALL)["attempts"], 1)
            again = server.request("DELETE", "/v1/jobs/" + job)
            self.assertEqual((again.status, again.json["code"]), (409, "finished"))
            self.assertEqual(server.metric("kiln_worker_restarts_total"), 0)
            self.assertEqual(server.post(ENDLESS).status, 202)  # it may be asked for again
        finally:
            self.assertEqual(server.stop(), 0)

    def test_a_job_that_another_posted_too_outlives_a_release(self):
        server = Server("--device", "native", "--drain-s", "0")
        try:
            job = server.post(ENDLESS).json["id"]
            self.assertEqual(server.post(ENDLESS).json["id"], job)
            path = f"/v1/jobs/{job}?release="
            self.assertEqual(server.request("DELETE", path + "1").status, 400)
            first = server.request("DELETE", path + "true")
            self.assertEqual(first.status, 200)
            self.assertIn(first.json["state"], ("queued", "running"))
            self.assertIn(server.request("DELETE", path + "true").status, (200, 202))
            wait_until(lambda: server.state(job) == "cancelled")
        finally:
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    unittest.main()
