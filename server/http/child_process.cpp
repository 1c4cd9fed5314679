// SPDX-License-Identifier: Apache-2.0
#include "server/http/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>

#include "server/base/error.h"
#include "server/base/exit_status.h"

namespace kiln {

namespace {

std::vector<char*> pointers_of(const std::vector<std::string>& texts) {
    std::vector<char*> pointers;
    for (const std::string& text : texts) pointers.push_back(const_cast<char*>(text.c_str()));
    pointers.push_back(nullptr);
    return pointers;
}

void restrict_to(const ChildLimits& limits) {
// Sanitizers reserve more addresses than any bound on them would leave.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    const rlimit memory{limits.memory_bytes_max, limits.memory_bytes_max};
    setrlimit(RLIMIT_AS, &memory);
#endif
    const rlimit cpu{limits.cpu_s_max, limits.cpu_s_max}, no_file{0, 0};
    setrlimit(RLIMIT_CPU, &cpu);
    setrlimit(RLIMIT_FSIZE, &no_file);
}

/// Between fork and exec: async-signal-safe calls only.
[[noreturn]] void become(int socket, int input, const std::optional<ChildLimits>& limits,
                         pid_t parent, int nice_level, char* const* arguments,
                         char* const* environment) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);  // it died before the line above
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    setpriority(PRIO_PROCESS, 0, nice_level);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    if (input >= 0) dup2(input, STDIN_FILENO);
    if (limits) restrict_to(*limits);
    if (socket == kWorkerSocket)
        fcntl(socket, F_SETFD, 0);
    else
        dup2(socket, kWorkerSocket);
    close_range(kWorkerSocket + 1, ~0U, 0);
    const int null = open("/dev/null", O_RDWR);
    if (input < 0) dup2(null, STDIN_FILENO);
    dup2(null, STDOUT_FILENO);
    if (null > kWorkerSocket) close(null);
    execve("/proc/self/exe", arguments, environment);
    _exit(127);
}

}  // namespace

ChildProcess start_child(const std::vector<std::string>& arguments,
                         const std::vector<std::string>& environment, int nice_level, int input,
                         std::optional<ChildLimits> limits) {
    std::array<int, 2> sockets{};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets.data()) != 0)
        throw Error("cannot_start", std::string("socketpair: ") + std::strerror(errno));
    std::vector<std::string> all{"kilnd"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const std::vector<char*> argument_pointers = pointers_of(all);
    const std::vector<char*> environment_pointers = pointers_of(environment);
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child == 0)
        become(sockets[1], input, limits, parent, nice_level, argument_pointers.data(),
               environment_pointers.data());
    const int fork_error = errno;
    close(sockets[1]);
    if (child < 0) {
        close(sockets[0]);
        throw Error("cannot_start", std::string("fork: ") + std::strerror(fork_error));
    }
    fcntl(sockets[0], F_SETFL, O_NONBLOCK);
    return {child, sockets[0]};
}

std::vector<std::string> worker_environment(const std::string& cache_dir) {
    // These choose or bound a device; every other POCL_ variable stays out, as
    // POCL_EXTRA_BUILD_FLAGS and its like change what kernels compute.
    static constexpr std::array<std::string_view, 5> kKept{
        "POCL_AFFINITY=", "POCL_KERNELLIB_NAME=", "POCL_DEVICES=", "POCL_MAX_PTHREAD_COUNT=",
        "POCL_MEMORY_LIMIT="};
    std::vector<std::string> kept;
    for (char** entry = environ; *entry != nullptr; ++entry) {
        const std::string_view text = *entry;
        bool keep = text.substr(0, 5) != "POCL_";
        for (const std::string_view name : kKept)
            keep = keep || text.substr(0, name.size()) == name;
        if (keep) kept.emplace_back(text);
    }
    kept.push_back("POCL_CACHE_DIR=" + cache_dir);
    return kept;
}

std::string describe_end(int status) {
    if (WIFSIGNALED(status))
        return "was killed by signal " + std::to_string(WTERMSIG(status)) + " (" +
               strsignal(WTERMSIG(status)) + ")";
    if (WEXITSTATUS(status) == kExitHung) return "ended itself, as its device made no progress";
    return "ended with status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace kiln
