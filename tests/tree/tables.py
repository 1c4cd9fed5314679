# SPDX-License-Identifier: Apache-2.0
"""What the rules over the tree allow: limits, arrows, and the excesses that exist. An excess may shrink
and go, never grow: an entry larger than what it describes fails as well."""

# Lines a file, by the first pattern that fits; data, licence and generated files have no limit.
FILE_LINES_MAX = [
    ("kernels/*.h", 210),
    ("kernels/*.cl", 150),
    ("README.md", 150),
    ("ARCHITECTURE.md", 240),
    ("CONTRIBUTING.md", 120),
    ("*.json", None),
    ("LICENSE", None),
    ("examples/measured/*.csv", None),
    ("*", 400),
]
FUNCTION_LINES_MAX = 70
COLUMNS_MAX = 120   # a hard limit
COLUMNS_AIM = 100   # what clang-format keeps to
WIDE_LINES_MAX = 110  # lines between the two in the whole tree; lower it whenever the test says so

# file → lines wider than COLUMNS_MAX
OVERWIDE_LINES = {
    "cmake/Embed.cmake": 1,  # a regular expression of 81 dots
    "tests/client/CMakeLists.txt": 1,
    "tests/compute/test_opencl.cpp": 1,
}
# Files that clang-format would change.
UNFORMATTED = set()

# Who may include what of ours, besides its own folder. A path ending in "/" is a folder; the longest
# matching key speaks for a file; "*" is everything.
ARROWS = {
    "kernels/": [],
    "server/base/": [],
    "server/settings/": ["server/base/"],
    "server/spec/": ["server/base/"],
    "server/scene/": ["server/spec/", "server/base/"],
    "server/measured/": ["server/compute/", "server/spec/", "server/base/"],
    "server/store/": ["server/base/"],
    "server/compute/": ["kernels/", "server/spec/", "server/base/"],
    "server/image/": ["server/spec/", "server/base/", "server/compute/table.h"],
    "server/study/": ["kernels/", "server/measured/", "server/compute/", "server/spec/",
                      "server/base/"],
    "server/worker/": ["server/spec/", "server/store/", "server/compute/", "server/image/",
                       "server/study/", "server/measured/", "server/settings/", "server/base/"],
    # What the client shares: no store.
    "server/worker/bake": ["server/spec/", "server/compute/", "server/image/", "server/study/",
                           "server/measured/", "server/base/"],
    "server/http/": ["server/spec/", "server/scene/", "server/store/", "server/settings/", "server/base/"],
    "server/kilnd.cpp": ["server/"],
    # The HTTP API, and the engine for --local.
    "client/": ["server/spec/", "server/scene/", "server/measured/", "server/compute/", "server/image/",
                "server/study/",
                "server/worker/bake.h", "server/base/"],
    # Shares no line with what it is the reference for.
    "tests/reference/": [],
    "tests/": ["*"],
    "benchmarks/": ["*"],
}

# What cmake/ makes of the contract, in the build's folder.
GENERATED = {"kernels/words.h", "server/spec/closed_sets.h"}

# Third-party headers that are slow to compile or belong behind one file: who may include them. Headers
# of ours never include the first four.
HEAVY_HEADERS = {
    "nlohmann/json.hpp": [
        "client/json.cpp", "client/scene_json.cpp", "server/compute/devices_json.cpp",
        "server/compute/report.cpp", "server/http/documents.cpp",
        "server/http/measurement_documents.cpp",
        "server/scene/material_list.cpp", "server/scene/plan_document.cpp",
        "server/scene/plan_options.cpp", "server/scene/scene.cpp", "server/scene/gltf_document.cpp",
        "server/scene/tiny_gltf.cpp",
        "server/measured/account.cpp", "server/measured/bird_json.cpp",
        "server/measured/job_product.cpp", "server/measured/job_sidecar.cpp",
        "server/measured/sidecar.cpp",
        "server/spec/canonical.cpp", "server/spec/contract.cpp", "server/spec/job.cpp",
        "server/spec/json_text.cpp", "server/spec/measured_fields.cpp", "server/spec/models.cpp",
        "server/spec/phrases.cpp", "server/spec/problem_document.cpp",
        "server/spec/schema.cpp", "server/spec/settings.cpp", "server/study/study_json.cpp",
        "tests/compute/test_report.cpp", "tests/measured/test_job.cpp",
        "tests/measured/test_products.cpp",
        "tests/scene/test_material_list.cpp",
        "tests/spec/*.cpp"],
    "httplib.h": ["server/http/listener.cpp"],
    "CLI/*": ["client/arguments.h"],
    "valijson/*": ["tests/spec/test_oracle.cpp"],
    "CL/*": ["server/compute/opencl_api.h", "tests/compute/clfault.cpp"],
    "curl/*": ["client/http.cpp"],
    "cairo*": ["server/measured/canvas.cpp", "server/study/charts.h", "server/study/draw.cpp"],
    "sqlite3.h": ["server/store/sqlite.cpp", "tests/store/test_sqlite_job_store.cpp"],
    "pugixml.hpp": ["server/measured/lbnl_xml.cpp"],
    "openssl/*": ["server/base/sha256.cpp"],
    "png.h": ["server/base/png_input.cpp", "server/image/png_read.cpp", "server/image/png_write.cpp",
              "tests/compute/test_published.cpp",
              "server/scene/png_texels.cpp", "tests/scene/made_images.cpp"],
    "jpeglib.h": ["server/scene/jpeg_texels.cpp", "tests/scene/made_images.cpp"],
    "Imf*": ["server/image/exr_read.cpp", "server/image/exr_write.cpp",
             "tests/compute/test_published.cpp"],
}

# A kernel header NAME.h is tested by tests/kernels/test_NAME.cpp or by the files here.
KERNEL_TESTS = {
    "kernels.h": [],  # the list of the others
    "models.h": [],  # a part of it
    "lane_arc.h": ["tests/kernels/test_lane_math.cpp"],
    "material.h": ["tests/compute/test_models.cpp", "tests/compute/test_backends.cpp"],
    "sample_lobe.h": ["tests/compute/test_models.cpp", "tests/compute/test_backends.cpp"],
    "microfacet.h": ["tests/compute/test_models.cpp", "tests/compute/test_backends.cpp"],
    "batch.h": ["tests/compute/test_backends.cpp", "tests/compute/test_accuracy.cpp"],
    "quadrature.h": ["tests/compute/test_quadrature.cpp"],
    "quadrature_lobe.h": ["tests/compute/test_quadrature_lobes.cpp"],
    "elevation.h": ["tests/compute/test_quadrature_lobes.cpp"],
    "charlie.h": ["tests/compute/test_models.cpp", "tests/compute/test_quadrature_lobes.cpp"],
    "quadrature_diffuse.h": ["tests/compute/test_quadrature_diffuse.cpp"],
    "ray.h": ["tests/compute/test_quadrature.cpp"],
    "lane_table.h": ["tests/kernels/test_measured.cpp"],
    "measured_albedo.h": ["tests/measured/test_resample.cpp"],
}

PACKAGE_LISTS = ["deploy/apt-packages.txt", "deploy/apt-packages-test.txt",
                 "deploy/apt-packages-fuzz.txt"]
PACKAGE_INSTALLER = "deploy/install-packages.sh"
