// SPDX-License-Identifier: Apache-2.0
#include "client/measurements.h"

#include <filesystem>
#include <set>

#include "client/failure.h"
#include "client/files.h"
#include "client/terminal.h"
#include "server/base/sha256.h"
#include "server/measured/bounds.h"
#include "server/spec/measurement_names.h"

namespace kiln::client {

namespace {

namespace fs = std::filesystem;

std::string read_measured(const std::string& path) {
    return read_input(path, measured::kFileBytesMax);
}

}  // namespace

std::string MeasurementFiles::add(const std::string& path) {
    std::string digest = sha256_hex(read_measured(path));
    paths_[digest] = path;
    return digest;
}

std::string MeasurementFiles::bytes(const std::string& digest) const {
    const auto found = paths_.find(digest);
    if (found == paths_.end())
        throw Failure(Exit::usage, "measurement_missing",
                      "the job names sha256:" + digest +
                          ", which is not here; give its file with --measurement FILE");
    std::string bytes = read_measured(found->second);
    if (sha256_hex(bytes) != digest)
        throw Failure(Exit::usage, "file_changed", found->second + " changed while it was used");
    return bytes;
}

std::string take_measurements(const std::string& job_text, const std::string& job_path,
                              const std::vector<std::string>& more, MeasurementFiles& files) {
    const fs::path folder = job_path == "-" ? fs::path() : fs::path(job_path).parent_path();
    std::set<std::string> named;
    std::string text = with_measurements(job_text, [&](const std::string& name) {
        if (name.starts_with(kMeasurementPrefix)) {
            named.insert(name);
            return name;
        }
        const std::string id = kMeasurementPrefix + files.add((folder / name).string());
        named.insert(id);
        return id;
    });
    for (const std::string& path : more) {
        const std::string id = kMeasurementPrefix + files.add(path);
        if (!named.contains(id))
            throw Failure(Exit::usage, "unused_measurement",
                          "--measurement " + path + ": the job names no " + id);
    }
    return text;
}

void upload_missing(Api& api, const JobSpec& job, const MeasurementFiles& files) {
    std::set<std::string> looked;
    for (const MeasuredMaterial& material : job.measured.materials) {
        if (!files.has(material.data) || !looked.insert(material.data).second) continue;
        if (!api.has_measurement(material.data)) api.upload(files.bytes(material.data));
    }
}

}  // namespace kiln::client
