#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The project's speed claims, as ratios of medians within one run (absolute times say little on a shared machine).

    benchmarks/headline.py [--bin build/release/bin] [--runs 15]

Baselines, each used where it is installed: cmgen (libfilament-tools) for integration, nginx and wrk for serving.
"""

import argparse
import http.client
import json
import os
import shutil
import statistics
import subprocess
import tempfile
import time

SPLIT_SUM = {"quantities": ["split_sum_scale", "split_sum_bias"], "resolution": [256, 256], "sample_count": 1024}


class Server:
    """A kilnd of its own on a free port."""

    def __init__(self, binaries, *flags):
        self.folder = tempfile.TemporaryDirectory()
        self.started = time.perf_counter()
        self.process = subprocess.Popen(
            [os.path.join(binaries, "kilnd"), "serve", "--listen", "127.0.0.1:0",
             "--data-dir", self.folder.name, *flags],
            stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            if "listening on http://" in line:
                self.port = int(line.rsplit(":", 1)[1])
                break
        self.log = subprocess.Popen(["cat"], stdin=self.process.stderr, stdout=subprocess.DEVNULL)

    def request(self, method, path, body=None):
        """On a connection of its own: the server closes idle ones, and a benchmark idles while others run."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        text = None if body is None else json.dumps(body)
        headers = {} if body is None else {"Content-Type": "application/json"}
        connection.request(method, path, text, headers)
        answer = connection.getresponse()
        result = answer.status, answer.read()
        connection.close()
        return result

    def bake(self, job):
        """Wall seconds until the image's bytes are here, and the report."""
        start = time.perf_counter()
        status, text = self.request("POST", "/v1/jobs?wait=60", job)
        assert status == 200, text
        links = json.loads(text)["links"]
        status, _ = self.request("GET", links["image"])
        assert status == 200
        seconds = time.perf_counter() - start
        return seconds, json.loads(self.request("GET", links["report"])[1])

    def stop(self):
        self.process.terminate()
        self.process.wait()
        self.log.wait()
        self.folder.cleanup()


def time_cmgen(folder):
    start = time.perf_counter()
    subprocess.run(["cmgen", "--quiet", f"--ibl-dfg={folder}/dfg.exr", "-s", "256"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - start


def integration(binaries, runs):
    if shutil.which("cmgen") is None:
        print("integration: skipped, cmgen is not installed (package libfilament-tools)")
        return
    server = Server(binaries)
    seed = 0
    while server.bake({**SPLIT_SUM, "device": "opencl", "resolution": [16, 16], "seed": seed})[1]["device"]["fallback"]:
        seed += 1
    times = {"cmgen": [], "native": [], "opencl": [], "http": []}
    with tempfile.TemporaryDirectory() as folder:
        for run in range(runs):  # interleaved, so that a slow minute slows all
            times["cmgen"].append(time_cmgen(folder))
            for device in ("native", "opencl"):
                wall, report = server.bake({**SPLIT_SUM, "device": device, "seed": 1000 + run})
                times[device].append(report["run_time_s"]["integrate"])
            times["http"].append(server.bake({**SPLIT_SUM, "seed": 5000 + run})[0])
    server.stop()
    middle = {name: statistics.median(values) for name, values in times.items()}
    print(f"256 x 256 split sum, 1024 samples a texel, medians of {runs} interleaved runs:")
    print(f"  cmgen, whole process            {middle['cmgen'] * 1e3:8.1f} ms    1.0 x")
    for name, what in (("native", "native, integration"), ("opencl", "OpenCL, integration"),
                       ("http", "over HTTP, warm, not cached")):
        print(f"  {what:31} {middle[name] * 1e3:8.1f} ms {middle['cmgen'] / middle[name]:6.1f} x")


def first_answer(binaries, runs):
    times = []
    for run in range(max(3, runs // 3)):
        server = Server(binaries)
        server.bake(SPLIT_SUM)
        times.append(time.perf_counter() - server.started)
        server.stop()
    print(f"first answer after the start of a server with an empty data folder: {statistics.median(times):.2f} s "
          f"(slowest {max(times):.2f} s)")


def wrk(url):
    out = subprocess.run(["wrk", "-t2", "-c32", "-d5s", url], check=True, capture_output=True, text=True).stdout
    for line in out.splitlines():
        if line.startswith("Requests/sec:"):
            return float(line.split()[1])
    raise RuntimeError(out)


def start_nginx(folder, image):
    os.chmod(folder, 0o755)
    with open(os.path.join(folder, "image.exr"), "wb") as file:
        file.write(image)
    with open(os.path.join(folder, "nginx.conf"), "w", encoding="ascii") as file:
        file.write(f"""worker_processes 2; pid {folder}/pid; error_log {folder}/error; daemon off;
events {{ worker_connections 256; }}
http {{ access_log off; sendfile on; tcp_nopush on; keepalive_requests 1000000;
  server {{ listen 127.0.0.1:8199; root {folder}; }} }}
""")
    process = subprocess.Popen(["nginx", "-c", os.path.join(folder, "nginx.conf"), "-p", folder],
                               stderr=subprocess.DEVNULL)
    time.sleep(1)
    return process


def serving(binaries, runs):
    if shutil.which("wrk") is None or shutil.which("nginx") is None:
        print("serving: skipped, wrk or nginx is not installed")
        return
    server = Server(binaries)
    status, text = server.request("POST", "/v1/jobs?wait=60", SPLIT_SUM)
    links = json.loads(text)["links"]
    image = server.request("GET", links["image"])[1]
    rates = {"nginx": [], "kilnd": []}
    with tempfile.TemporaryDirectory() as folder:
        nginx = start_nginx(folder, image)
        for _ in range(max(1, runs // 5)):
            rates["nginx"].append(wrk("http://127.0.0.1:8199/image.exr"))
            rates["kilnd"].append(wrk(f"http://127.0.0.1:{server.port}{links['image']}"))
        nginx.terminate()
        nginx.wait()
    server.stop()
    middle = {name: statistics.median(values) for name, values in rates.items()}
    print(f"a cached image of {len(image)} bytes, wrk -t2 -c32: nginx {middle['nginx']:.0f} requests/s, "
          f"kilnd {middle['kilnd']:.0f} requests/s, {middle['kilnd'] / middle['nginx']:.2f} x")


def health_under_load(binaries):
    server = Server(binaries)
    job = json.loads(server.request("POST", "/v1/jobs",
                                    {**SPLIT_SUM, "resolution": [1024, 1024], "sample_count": 4096})[1])["id"]
    slowest = 0.0
    for _ in range(100):
        start = time.perf_counter()
        assert server.request("GET", "/healthz")[0] == 200
        slowest = max(slowest, time.perf_counter() - start)
        time.sleep(0.01)
    state = json.loads(server.request("GET", f"/v1/jobs/{job}")[1])["state"]
    server.request("DELETE", f"/v1/jobs/{job}")
    server.stop()
    print(f"/healthz beside a job that keeps every core busy ({state}): slowest of 100 {slowest * 1e3:.1f} ms")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", default="build/release/bin")
    parser.add_argument("--runs", type=int, default=15)
    arguments = parser.parse_args()
    integration(arguments.bin, arguments.runs)
    first_answer(arguments.bin, arguments.runs)
    health_under_load(arguments.bin)
    serving(arguments.bin, arguments.runs)


if __name__ == "__main__":
    main()
