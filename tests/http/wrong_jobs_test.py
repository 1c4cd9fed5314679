# SPDX-License-Identifier: Apache-2.0
"""tests/spec/wrong_jobs.json over HTTP: each is refused by name, and the server is as it was."""
import base64
import json
import os
import unittest

from service import SMALL, ServiceTest

CORPUS = os.path.join(os.path.dirname(__file__), "..", "spec", "wrong_jobs.json")


def bytes_of(entry):
    if "base64" in entry:
        return base64.b64decode(entry["base64"])
    if "parts" in entry:
        return "".join(text * count for text, count in entry["parts"]).encode()
    return entry["text"].encode("utf-8", "surrogatepass")


class WrongJobs(ServiceTest):
    def test_each_is_refused_by_name(self):
        with open(CORPUS) as file:
            corpus = json.load(file)
        self.assertGreaterEqual(len(corpus), 100)
        before = self.server.get("/v1/jobs").json
        largest = self.server.get("/v1/capabilities").json["limits"]["job_bytes_max"]["value"]
        for entry in corpus:
            with self.subTest(entry["name"]):
                body = bytes_of(entry)
                answer = self.server.post(body)
                expected = 413 if len(body) > largest else entry["status"]
                self.assertEqual(answer.status, expected, answer.body)
                self.assertEqual(answer.headers["Content-Type"], "application/problem+json")
                document = answer.json
                self.assertEqual(document["status"], expected)
                self.assertTrue(document["code"] and document["detail"])
                if expected != 413:
                    self.assertIn(entry["pointer"], [x["pointer"] for x in document["problems"]])
        self.assertEqual(self.server.get("/v1/jobs").json, before)
        self.assertEqual(self.server.bake(SMALL)["state"], "done")


if __name__ == "__main__":
    unittest.main()
