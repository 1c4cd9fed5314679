// SPDX-License-Identifier: Apache-2.0
#include "server/http/measurement_reader.h"

#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/http/bounds.h"
#include "server/http/child_process.h"
#include "server/http/measurement_documents.h"
#include "server/http/problems.h"

namespace kiln {

namespace {

using Clock = std::chrono::steady_clock;
constexpr int kNice = 5;  // as workers: the front answers first

/// A child that is not left behind.
class ReadingProcess {
  public:
    explicit ReadingProcess(int file)
        : child_(start_child(
              {"read-measurement"}, worker_environment(""), kNice, file,
              ChildLimits{kReaderMemoryMax, static_cast<std::uint64_t>(kReaderTimeMax.count())})) {}
    ~ReadingProcess() {
        close(child_.socket);
        if (!ended_) {
            kill(child_.pid, SIGKILL);
            wait();
        }
    }
    ReadingProcess(const ReadingProcess&) = delete;
    ReadingProcess& operator=(const ReadingProcess&) = delete;

    /// All that it says, until it closes its end or a bound is met.
    std::string answer() {
        const Clock::time_point deadline = Clock::now() + kReaderWaitMax;
        std::string text;
        std::array<char, 65536> piece;
        while (text.size() <= kReaderAnswerBytesMax) {
            const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
            if (left.count() <= 0) return "";
            pollfd entry{child_.socket, POLLIN, 0};
            if (poll(&entry, 1, static_cast<int>(left.count())) <= 0) continue;
            const ssize_t got = recv(child_.socket, piece.data(), piece.size(), MSG_DONTWAIT);
            if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
            if (got <= 0) return text;
            text.append(piece.data(), static_cast<std::size_t>(got));
        }
        return "";
    }

    /// Its waitpid status.
    int wait() {
        int status = 0;
        while (waitpid(child_.pid, &status, 0) < 0 && errno == EINTR) continue;
        ended_ = true;
        return status;
    }

    void stop() { kill(child_.pid, SIGKILL); }

  private:
    ChildProcess child_;
    bool ended_ = false;
};

}  // namespace

Measurement read_in_a_process(int file, std::int64_t readers) {
    ReadingProcess reader(file);
    const std::string answer = reader.answer();
    if (answer.empty()) reader.stop();  // it may have ended on its own: then this does nothing
    const int status = reader.wait();
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        log_line("reader_died", {{"detail", describe_end(status)}});
        throw Error("unreadable_measurement", "the process that read the file " +
                                                  describe_end(status) +
                                                  ": nothing of the file is kept");
    }
    const ReaderAnswer read = read_reader_answer(answer);
    if (!read.code.empty())
        throw Error(status_of(read.code) == 422 ? read.code : "unreadable_measurement",
                    read.detail);
    Measurement what = read.measurement;
    what.readers = readers;
    return what;
}

}  // namespace kiln
