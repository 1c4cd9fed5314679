// SPDX-License-Identifier: Apache-2.0
// `measure upload`: measured files to a server.
#include <cstdio>

#include "client/api.h"
#include "client/commands.h"
#include "client/files.h"
#include "client/json.h"
#include "server/measured/bounds.h"

namespace kiln::client {

Exit measure_upload(const ServerOptions& options, const std::vector<std::string>& files) {
    Api api(options.server.empty() ? kDefaultServer : options.server, [] { return false; });
    std::vector<std::string> documents;
    for (const std::string& path : files) {
        try {
            documents.push_back(api.upload(read_input(path, measured::kFileBytesMax)));
        } catch (const Failure& failure) {
            // What the server finds wrong with a file is no fault of a job.
            const bool refused = failure.exit == Exit::invalid_job;
            throw Failure(refused ? Exit::usage : failure.exit, failure.code(),
                          path + ": " + failure.what());
        }
        const auto answer = read_measurement_answer(documents.back());
        if (!answer)
            throw Failure(Exit::failed, "no_kiln_server",
                          api.url() + " does not answer like a Kiln server");
        if (options.json) continue;
        std::printf("%s\n", printable(answer->id).c_str());
        say(printable(path + ": " + answer->format +
                      (answer->title.empty() ? "" : ", " + answer->title)));
        if (!answer->unfit.empty()) say("kiln: " + printable(path + ": " + answer->unfit));
    }
    if (options.json) std::printf("%s\n", measurements_json(documents).c_str());
    return Exit::done;
}

}  // namespace kiln::client
