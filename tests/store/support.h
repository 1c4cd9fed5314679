// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>
#include <string>
#include <thread>

#include "server/base/error.h"

namespace kiln::test {

/// A folder of the test's own inside the build folder, removed at the end.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string name = std::string(KILN_BINARY_DIR) + "/test_store.XXXXXX";
        if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp " + name);
        path_ = name;
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::string& path() const { return path_; }
    std::string operator/(const std::string& name) const { return path_ + "/" + name; }

  private:
    std::string path_;
};

/// The code of the Error that `action` throws, and its sentence; {"", ""} when it throws none.
inline std::array<std::string, 2> error_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        return {error.code(), error.what()};
    }
    return {};
}

inline std::string random_bytes(std::mt19937& random, std::size_t byte_count) {
    std::string bytes(byte_count, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random() & 0xff);
    return bytes;
}

inline std::string read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

inline void write_file(const std::string& path, std::string_view bytes) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    ASSERT_TRUE(file.flush()) << path;
}

/// Runs `action`, which writes to a pipe without end, in a child process, and kills it with SIGKILL
/// `delay` after its first words (or after its start, where it is to be killed `early`). Gives all
/// that it wrote.
inline std::string killed_child(const std::function<void(int)>& action,
                                std::chrono::microseconds delay, bool early) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("pipe");
    const pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        action(ends[1]);
        _exit(0);
    }
    close(ends[1]);
    std::string words;
    char part[4096];
    const auto more = [&] {
        const ssize_t got = read(ends[0], part, sizeof part);
        if (got > 0) words.append(part, static_cast<std::size_t>(got));
        return got > 0;
    };
    if (!early) more();
    std::this_thread::sleep_for(delay);
    kill(child, SIGKILL);
    while (more()) {
    }
    close(ends[0]);
    waitpid(child, nullptr, 0);
    return words;
}

/// A child process that runs `action`, which returns "" for all well. To be started while the test
/// has one thread only: a fork copies locks that other threads hold.
class Child {
  public:
    explicit Child(const std::function<std::string()>& action) {
        int ends[2];
        if (pipe(ends) != 0) throw std::runtime_error("pipe");
        pid_ = fork();
        if (pid_ == 0) {
            std::string message;
            try {
                message = action();
            } catch (const std::exception& error) {
                message = std::string("exception: ") + error.what();
            }
            const ssize_t written = write(ends[1], message.data(), message.size());
            _exit(written == static_cast<ssize_t>(message.size()) ? 0 : 1);
        }
        close(ends[1]);
        out_ = ends[0];
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// Waits for the end; what the action returned. To be called once.
    std::string outcome() {
        std::string message;
        char part[4096];
        for (ssize_t got; (got = read(out_, part, sizeof part)) > 0;)
            message.append(part, static_cast<std::size_t>(got));
        close(out_);
        int status = 0;
        waitpid(pid_, &status, 0);
        if (status != 0) message += " (child ended with " + std::to_string(status) + ")";
        return message;
    }

  private:
    pid_t pid_ = -1;
    int out_ = -1;
};

inline std::string in_child(const std::function<std::string()>& action) {
    return Child(action).outcome();
}

}  // namespace kiln::test
