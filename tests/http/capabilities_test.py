# SPDX-License-Identifier: Apache-2.0
"""Every bound of the service can be read from GET /v1/capabilities."""
import pathlib
import re
import unittest

from service import ServiceTest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# What a client or an operator can meet, beside the settings.
BOUNDS = {
    "head_bytes_max": 16384, "head_lines_max": 64, "path_bytes_max": 256,
    "target_bytes_max": 2048, "backlog_max": 1024, "linger_ms_max": 1000,
    "linger_bytes_max": 4194304, "send_rate_min": 16384, "coalesced_bytes_max": 16384,
    "image_index_entries_max": 4096, "worker_line_bytes_max": 262144,
    "worker_backoff_ms_max": 5000, "worker_abandon_s_max": 3, "finished_jobs_max": 100000,
    "quarantine_files_max": 16, "busy_ms_max": 5000, "storing_min_max": 10,
    "device_failures_max": 3, "replicates_max": 16, "batch_points_max": 1024,
    "list_limit_max": 1000, "list_limit_default": 100, "job_bytes_max": 65536,
    "scene_bytes_max": 33554432, "scene_values_max": 1500000, "scene_entries_max": 200000,
    "scene_materials_max": 4096, "scene_name_bytes_max": 256, "image_texels_max": 16777216,
    "scene_texels_max": 67108864, "scene_image_bytes_max": 67108864,
    "gltf_materials_max": 20000, "image_memory_bytes_max": 134217728, "image_scans_max": 64,
    "rows_max": 8, "upload_bytes_max": 67108864, "plans_max": 4, "plan_patience_s_max": 10,
    "batch_bytes_max": 1048576, "batch_jobs_max": 64, "wait_s_max": 60, "upload_mib": 64,
    "measurements_mib": 4096, "measurements_max": 20000, "measurement_uploads_max": 16,
    "readers_max": 2, "reader_s_max": 60, "reader_memory_bytes_max": 2147483648,
    "atlas_materials_max": 256, "slice_count_max": 64, "atlas_texels_max": 67108864,
    "measurement_bytes_max": 75497472,
}
# Constants that are named like bounds and bound nothing that is shared or waits.
NO_BOUNDS = {
    "kHalfMax": "the largest binary16 number",
    "kLanesMax": "the width of a vector",
    "kWorkersMax": "the range of a setting",
    "kMebibytesMax": "the range of settings",
    "kDecodeSideMax": "of files that the command line reads; the service decodes none",
    "kDecodeChannelsMax": "the same",
    "kFacetsMax": "a walk that meets more fails its study",
    "kRoundsMax": "of an iteration whose rate is known",
    "kDeviationsMax": "a verdict's threshold",
    "kLobesMax": "the incidences that a fit takes of all",
    "kAzimuthGapMax": "degrees that the contract names at measured.phi_in",
}
# kSomethingMax or kSomethingLimit, where it is declared.
DECLARED = re.compile(r"constexpr [\w:<> ]*?[\w:>]+ (k\w*(?:Max|Limit)\w*)\b\s*[={]")


class Capabilities(ServiceTest):
    FLAGS = ["--workers", "0"]

    def limits(self):
        return self.server.get("/v1/capabilities").json["limits"]

    def test_every_bound_is_told(self):
        limits = self.limits()
        told = {name: limits[name]["value"] for name in BOUNDS if name in limits}
        self.assertEqual(told, BOUNDS)
        for name, limit in limits.items():
            self.assertTrue(limit["description"], name)

    def test_every_number_of_the_settings_is_told(self):
        table = (ROOT / "server/settings/settings_table.cpp").read_text()
        supervised = {"opencl_off_s", "doorbell_fd"}  # between a server and its workers
        fields = (ROOT / "server/settings/settings.h").read_text()
        numbers = set(re.findall(r"(?m)^    std::int64_t (\w+) = [-\d]+;", fields)) - supervised
        self.assertGreater(len(numbers), 10)
        for name in numbers:
            self.assertIn(f'"{name}"', table)
        self.assertEqual(numbers - set(self.limits()), set())

    def test_no_bound_is_declared_beside_the_lists(self):
        sources = [path for path in sorted((ROOT / "server").rglob("*"))
                   if path.suffix in (".cpp", ".h")]
        listed = "".join(path.read_text() for path in sources if path.name == "bounds.cpp")
        declared = {}
        for path in sources:
            for name in DECLARED.findall(path.read_text()):
                declared.setdefault(name, []).append(str(path.relative_to(ROOT)))
        self.assertIn("kHeadBytesMax", declared)  # or the pattern finds nothing
        self.assertEqual({name for name in declared if name not in NO_BOUNDS and
                          not re.search(rf"\b{name}\b", listed)}, set())
        self.assertEqual({name: where for name, where in declared.items() if len(where) > 1}, {})
        self.assertLessEqual(set(NO_BOUNDS), set(declared))


if __name__ == "__main__":
    unittest.main()
