// SPDX-License-Identifier: Apache-2.0
#include "server/worker/read_measurement.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <string>
#include <vector>

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/measured/bounds.h"
#include "server/measured/material.h"
#include "server/measured/survey.h"

namespace kiln {

namespace {

using namespace measured;

std::string standard_input() {
    struct stat status {};
    if (fstat(STDIN_FILENO, &status) != 0 || !S_ISREG(status.st_mode) ||
        static_cast<std::size_t>(status.st_size) > kFileBytesMax)
        throw Error("measurement_too_large",
                    "a measured file has at most " + std::to_string(kFileBytesMax) + " bytes");
    std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
    std::size_t filled = 0;
    while (filled < bytes.size()) {
        const ssize_t got = pread(STDIN_FILENO, bytes.data() + filled, bytes.size() - filled,
                                  static_cast<off_t>(filled));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) throw Error("unreadable_measurement", "the file could not be read back");
        filled += static_cast<std::size_t>(got);
    }
    return bytes;
}

/// Why no table can be made of what was read, "" where one can.
std::string unfit(const Reading& reading) {
    Understood ignored;
    try {
        const Material material(reading.components.front(), {}, ignored);
        return "";
    } catch (const Error& error) {
        return error.what();
    }
}

std::string account_of(const std::string& bytes) {
    const Reading reading = read_measurement(bytes);
    std::vector<ComponentSurvey> parts;
    for (const Component& part : reading.components) parts.push_back(survey(part));
    return R"({"unfit":")" + escaped(unfit(reading)) + R"(","account":)" +
           account_json(reading.understood, parts) + "}";
}

std::string refusal(const std::string& code, const std::string& detail) {
    return R"({"code":")" + escaped(code) + R"(","detail":")" + escaped(detail) + R"("})";
}

std::string answer() {
    try {
        return account_of(standard_input());
    } catch (const Error& error) {
        return refusal(error.code(), error.what());
    } catch (const std::bad_alloc&) {
        return refusal("measurement_too_large",
                       "the file needs more memory than reading it may take");
    }
}

}  // namespace

int read_measurement_once(int socket) {
    const std::string text = answer();
    for (std::size_t sent = 0; sent < text.size();) {
        const ssize_t count = send(socket, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return 1;
        sent += static_cast<std::size_t>(count);
    }
    return 0;
}

}  // namespace kiln
