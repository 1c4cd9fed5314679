# SPDX-License-Identifier: Apache-2.0
"""POST /v1/plans: scenes in, jobs out, and what hostile uploads get."""
import json
import os
import socket
import struct
import subprocess
import tempfile
import unittest

from service import SCRATCH, ServiceTest, wait_until

PAINT = {"materials": [{"name": "paint", "lobes": ["dielectric", "diffuse", "sheen"],
                        "roughness": [0.4, 0.7], "sheen_roughness": 0.5}]}
SCENE = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"name": "one", "nodes": [0]}, {}],
         "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"material": 0}]}],
         "materials": [{"name": "steel", "pbrMetallicRoughness": {"roughnessFactor": 0.4}}]}
OPTIONS = "?resolution=8&sample_count=64&device=native"


def glb(document):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunk = struct.pack("<I", len(text)) + b"JSON" + text
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunk)) + chunk


class Plans(ServiceTest):
    FLAGS = ["--device", "native"]

    def plan(self, scene, query="", content_type="application/json", origin=None):
        body = scene if isinstance(scene, bytes) else json.dumps(scene)
        headers = {"Content-Type": content_type} if content_type else {}
        if origin:
            headers["Origin"] = origin
        return self.server.request("POST", "/v1/plans" + query, body, headers)

    def test_a_scene_becomes_jobs_that_bake(self):
        answer = self.plan(PAINT, OPTIONS)
        self.assertEqual(answer.status, 200, answer.body)
        plan = answer.json
        self.assertEqual([table["name"] for table in plan["tables"]], ["specular", "sheen"])
        self.assertIn("lambert", [entry["rule"] for entry in plan["left_out"]])
        jobs = [table["job"] for table in plan["tables"]]
        batch = self.server.request("POST", "/v1/batches", json.dumps({"jobs": jobs}),
                                    {"Content-Type": "application/json"}).json
        for table, entry in zip(plan["tables"], batch["jobs"], strict=True):
            self.assertEqual(entry["job"]["id"], table["id"])
            done = self.server.get(f"/v1/jobs/{table['id']}?wait=60").json
            self.assertEqual(done["state"], "done", done["error"])
            report = self.server.get(f"/v1/jobs/{table['id']}/report").json
            self.assertEqual(report["work"]["brdf_evaluations"], table["estimate"]["evaluations"])

    def test_gltf_as_text_and_binary_is_the_same_plan(self):
        text = self.plan(SCENE, content_type="model/gltf+json").json
        binary = self.plan(glb(SCENE), content_type="model/gltf-binary").json
        self.assertEqual(text["scene"]["format"], "gltf")
        self.assertEqual(binary["scene"]["format"], "glb")
        for name in ("tables", "left_out", "materials", "unused"):
            self.assertEqual(text[name], binary[name])
        self.assertEqual(text["tables"][0]["job"]["resolution"], [64, 1])

    def test_options_and_scenes_by_name(self):
        self.assertEqual(self.plan(SCENE, "?scene=one").json["scene"]["index"], 0)
        empty = self.plan(SCENE, "?scene=1").json
        self.assertEqual((empty["scene"]["index"], empty["tables"]), (1, []))
        self.assertEqual([m["why"] for m in empty["unused"]],
                         ["no primitive that the scene reaches names it"])
        wide = self.plan(SCENE, "?resolution=128&multiscatter=none").json
        self.assertEqual(wide["tables"][0]["job"]["resolution"], [128, 1])

    def test_wrong_options_are_named(self):
        for query in ("?resolution=1", "?colour=red", "?multiscatter=all", "?pixel=uint8",
                      "?sample_count=x"):
            answer = self.plan(SCENE, query)
            self.assertEqual((answer.status, answer.json["code"]), (400, "bad_query"), query)
        answer = self.plan(SCENE, "?scene=9")
        self.assertEqual((answer.status, answer.json["code"]), (422, "invalid_scene"))

    def test_wrong_scenes_are_problem_documents_with_places(self):
        broken = json.loads(json.dumps(SCENE))
        broken["materials"][0]["pbrMetallicRoughness"] = {"roughnessFactor": 2}
        broken["nodes"][0]["children"] = "all"
        answer = self.plan(broken)
        self.assertEqual(answer.status, 422)
        self.assertEqual(answer.headers["Content-Type"], "application/problem+json")
        self.assertEqual({problem["pointer"] for problem in answer.json["problems"]},
                         {"/materials/0/pbrMetallicRoughness/roughnessFactor", "/nodes/0/children"})
        looped = json.loads(json.dumps(SCENE))
        looped["nodes"][0]["children"] = [0, 9]
        self.assertEqual([problem["pointer"] for problem in self.plan(looped).json["problems"]],
                         ["/nodes/0/children/1", "/nodes/0"])
        for body in (b"", b"{", b"glTF", b"\xff\xfe", b"[" * 100000, glb(SCENE)[:-1]):
            answer = self.plan(body)
            self.assertEqual((answer.status, answer.json["code"]), (400, "malformed"), body[:20])

    def test_hostile_scenes_get_a_problem_document_that_names_the_place(self):
        most = self.server.get("/v1/capabilities").json["limits"]["scene_bytes_max"]["value"]
        with tempfile.TemporaryDirectory(dir=SCRATCH) as folder:
            listing = subprocess.run([os.environ["KILN_HOSTILE_SCENES"], folder], check=True,
                                     capture_output=True, text=True).stdout.splitlines()
            self.assertGreaterEqual(len(listing), 100)
            for index, line in enumerate(listing):
                code, pointer, name = line.split("\t")
                with self.subTest(name), open(os.path.join(folder, str(index)), "rb") as file:
                    body = file.read()
                    if len(body) > most:  # refused by its length: see below
                        continue
                    answer = self.plan(body)
                    if code == "-":
                        self.assertEqual(answer.status, 200)
                        continue
                    self.assertEqual((answer.status, answer.json["code"]),
                                     ({"malformed": 400, "invalid_scene": 422}[code], code))
                    self.assertEqual(answer.headers["Content-Type"], "application/problem+json")
                    self.assertIn(pointer, [p["pointer"] for p in answer.json["problems"]])
        self.assertEqual(self.plan(SCENE).status, 200)

    def test_content_types(self):
        for name in ("text/plain", "image/png", "application/x-www-form-urlencoded", None):
            answer = self.plan(SCENE, content_type=name)
            self.assertEqual((answer.status, answer.json["code"]), (415, "wrong_type"), name)
        self.assertEqual(self.plan(SCENE, content_type="application/octet-stream").status, 200)

    def test_larger_than_a_scene_may_be(self):
        most = self.server.get("/v1/capabilities").json["limits"]["scene_bytes_max"]["value"]
        received = self.server.raw(b"POST /v1/plans HTTP/1.1\r\nHost: x\r\nContent-Type: "
                                   b"application/json\r\nContent-Length: %d\r\n\r\n" % (most + 1))
        self.assertIn(b"413", received.split(b"\r\n")[0])

    def test_large_bodies_share_a_bound(self):
        """A third upload of the largest size is refused, as soon as it is announced."""
        most = self.server.get("/v1/capabilities").json["limits"]["scene_bytes_max"]["value"]
        head = (b"POST /v1/plans HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
                b"Expect: 100-continue\r\nContent-Length: %d\r\n\r\n" % most)
        with self.announce(head), self.announce(head):
            answer = self.server.raw(head)
            self.assertIn(b" 503 ", answer.split(b"\r\n")[0])
            self.assertIn(b"too_many_uploads", answer)
            self.assertEqual(self.plan(SCENE).status, 200)  # small ones go on
        wait_until(lambda: b" 100 " in self.announced(head), what="room for another")

    def announce(self, head):
        """A connection whose body the server waits for."""
        connection = socket.create_connection(("127.0.0.1", self.server.port), 30)
        connection.sendall(head)
        self.assertIn(b" 100 ", connection.recv(100))
        return connection

    def announced(self, head):
        """What the server says to such a head alone."""
        with socket.create_connection(("127.0.0.1", self.server.port), 30) as connection:
            connection.sendall(head)
            return connection.recv(100)


if __name__ == "__main__":
    unittest.main()
