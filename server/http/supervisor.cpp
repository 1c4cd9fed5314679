// SPDX-License-Identifier: Apache-2.0
#include "server/http/supervisor.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/http/bounds.h"

namespace kiln {

namespace {

constexpr std::chrono::milliseconds kTick{100};
constexpr int kNice = 5;  // the front answers first when cores are scarce
constexpr std::chrono::milliseconds kBackoffFirst{100};
/// A worker that lived this long starts its backoff afresh.
constexpr std::chrono::seconds kStable{10};

std::string slot_name(std::int64_t index) { return "local-" + std::to_string(index); }

}  // namespace

Supervisor::Supervisor(const Settings& settings, JobStore& store, Changes& changes,
                       Metrics& metrics)
    : settings_(settings), store_(store), changes_(changes), metrics_(metrics) {
    wake_fd_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (wake_fd_ < 0) throw Error("cannot_start", "eventfd failed");
}

Supervisor::~Supervisor() {
    if (thread_.joinable()) {
        hurried_ = true;
        begin_stop();
        thread_.join();
    }
    close(wake_fd_);
}

void Supervisor::start() {
    // Whoever held these names is gone: this process has the data directory's lock.
    for (std::int64_t i = 0; i < kWorkersMax; ++i) store_.release(slot_name(i), "");
    const std::string caches = settings_.data_dir + "/pocl";
    mkdir(caches.c_str(), 0700);
    for (std::int64_t i = 0; i < settings_.workers; ++i) {
        Slot slot;
        slot.name = slot_name(i);
        slot.cache_dir = caches + "/" + slot.name;
        slots_.push_back(std::move(slot));
    }
    thread_ = std::thread([this] { run(); });
}

void Supervisor::ring() {
    ring_due_ = true;
    wake();
}

void Supervisor::wake() {
    const std::uint64_t one = 1;
    // EAGAIN means that it is awake already.
    [[maybe_unused]] const ssize_t written = write(wake_fd_, &one, sizeof one);
}

std::vector<WorkerStatus> Supervisor::workers() {
    const std::lock_guard lock(mutex_);
    std::vector<WorkerStatus> all;
    for (const Slot& slot : slots_)
        all.push_back({slot.name, slot.child.pid > 0, slot.devices_json});
    return all;
}

void Supervisor::begin_stop() {
    stopping_ = true;
    wake();
}

void Supervisor::run() {
    for (;;) {
        if (stopping_) {
            push_to_end();
            if (!any_alive()) break;
        }
        for (Slot& slot : slots_)
            if (!stopping_ && slot.child.pid < 0 && Clock::now() >= slot.restart_at)
                start_worker(slot);
        wait_for_events();
        if (ring_due_.exchange(false)) ring_all();
        for (Slot& slot : slots_) {
            listen_to(slot);
            kill_if_silent(slot);
            reap(slot);
            release(slot);
        }
    }
    stopped_ = true;
}

void Supervisor::wait_for_events() {
    std::vector<pollfd> entries{{wake_fd_, POLLIN, 0}};
    for (const Slot& slot : slots_)
        if (slot.child.socket >= 0) entries.push_back({slot.child.socket, POLLIN, 0});
    poll(entries.data(), entries.size(), static_cast<int>(kTick.count()));
    std::uint64_t count = 0;
    while (read(wake_fd_, &count, sizeof count) > 0) continue;
}

void Supervisor::ring_all() {
    for (const Slot& slot : slots_)
        if (slot.child.socket >= 0) send(slot.child.socket, "\n", 1, MSG_NOSIGNAL | MSG_DONTWAIT);
}

std::vector<std::string> Supervisor::arguments_for(const Slot& slot) const {
    std::vector<std::string> arguments{"worker"};
    const auto add = [&](std::string name, const std::string& value) {
        std::replace(name.begin(), name.end(), '_', '-');
        arguments.push_back("--" + name + "=" + value);
    };
    for (const Setting& setting : settings_table())
        if (setting.reader == Reader::both)
            add(std::string(setting.name), value_text(settings_, setting));
    add("worker_name", slot.name);
    add("doorbell_fd", std::to_string(kWorkerSocket));
    const auto off = std::chrono::ceil<std::chrono::seconds>(opencl_off_until_ - Clock::now());
    if (off.count() > 0) {
        add("opencl_off_reason", opencl_off_reason_);
        add("opencl_off_s", std::to_string(off.count()));
    }
    return arguments;
}

void Supervisor::start_worker(Slot& slot) {
    slot.heard = slot.started = Clock::now();
    ChildProcess child;
    try {
        mkdir(slot.cache_dir.c_str(), 0700);
        child = start_child(arguments_for(slot), worker_environment(slot.cache_dir), kNice);
    } catch (const Error& failure) {
        log_line("worker_not_started", {{"worker", slot.name}, {"detail", failure.what()}});
        slot.restart_at = Clock::now() + kBackoffMax;
        return;
    }
    if (slot.started_before) ++metrics_.worker_restarts;
    slot.started_before = true;
    log_line("worker_started", {{"worker", slot.name}, {"pid", std::to_string(child.pid)}});
    const std::lock_guard lock(mutex_);
    slot.child = child;
}

void Supervisor::listen_to(Slot& slot) {
    if (slot.child.socket < 0) return;
    std::array<char, 4096> bytes;
    for (;;) {
        const ssize_t got = recv(slot.child.socket, bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (got <= 0) break;
        slot.heard = Clock::now();
        slot.input.append(bytes.data(), static_cast<std::size_t>(got));
    }
    std::size_t end = 0;
    while ((end = slot.input.find('\n')) != slot.input.npos) {
        take_line(slot, std::string_view(slot.input).substr(0, end));
        slot.input.erase(0, end + 1);
    }
    if (slot.input.size() > kWorkerLineBytesMax) slot.input.clear();
}

void Supervisor::take_line(Slot& slot, std::string_view line) {
    const std::size_t space = std::min(line.find(' '), line.size());
    const std::string_view word = line.substr(0, space);
    const std::string rest(line.substr(std::min(space + 1, line.size())));
    if (word == "state") {
        changes_.notify(rest, Changes::Interest::state);
    } else if (word == "progress") {
        changes_.notify(rest, Changes::Interest::progress);
    } else if (word == "devices") {
        const std::lock_guard lock(mutex_);
        slot.devices_json = rest;
    }
}

void Supervisor::kill_if_silent(Slot& slot) {
    if (slot.child.pid < 0 || !slot.end_reason.empty()) return;
    if (Clock::now() - slot.heard < std::chrono::seconds(settings_.silence_s)) return;
    slot.end_reason =
        "gave no sign of life for " + std::to_string(settings_.silence_s) + " s and was killed";
    kill(slot.child.pid, SIGKILL);
}

void Supervisor::reap(Slot& slot) {
    int status = 0;
    if (slot.child.pid < 0 || waitpid(slot.child.pid, &status, WNOHANG) != slot.child.pid) return;
    listen_to(slot);  // its last words
    buried(slot, status);
}

void Supervisor::buried(Slot& slot, int status) {
    close(slot.child.socket);
    {
        const std::lock_guard lock(mutex_);
        slot.child = {};
    }
    slot.input.clear();
    // One that this process stopped is not to blame, however it ended.
    const bool clean = stop_signals_ > 0 || (WIFEXITED(status) && WEXITSTATUS(status) == 0);
    std::string note;
    if (!clean) {
        const std::string how = slot.end_reason.empty() ? describe_end(status) : slot.end_reason;
        note = "the worker " + how;
        log_line("worker_died", {{"worker", slot.name}, {"detail", note}});
        // A damaged kernel cache is one cause of such an end, and costs only a compilation to lose.
        std::error_code ignored;
        std::filesystem::remove_all(slot.cache_dir, ignored);
        note_death();
    }
    slot.end_reason.clear();
    slot.release_note = note;
    slot.release_due = true;
    const bool stable = Clock::now() - slot.started >= kStable;
    slot.backoff = stable || slot.backoff.count() == 0 ? kBackoffFirst
                                                       : std::min(2 * slot.backoff, kBackoffMax);
    slot.restart_at = Clock::now() + slot.backoff;
}

void Supervisor::release(Slot& slot) {
    if (!slot.release_due) return;
    try {
        store_.release(slot.name, slot.release_note);
        slot.release_due = false;
    } catch (const Error& failure) {
        log_line("release_failed", {{"worker", slot.name}, {"detail", failure.what()}});
        return;  // the next tick tries again
    }
    ring_all();
}

void Supervisor::note_death() {
    const Clock::time_point now = Clock::now();
    const std::chrono::seconds span(settings_.breaker_s);
    deaths_.push_back(now);
    while (now - deaths_.front() > span) deaths_.pop_front();
    if (static_cast<std::int64_t>(deaths_.size()) < settings_.breaker_deaths) return;
    opencl_off_until_ = now + span;
    opencl_off_reason_ = std::to_string(deaths_.size()) + " worker deaths within " +
                         std::to_string(settings_.breaker_s) + " s: OpenCL is off for as long";
    log_line("opencl_off", {{"detail", opencl_off_reason_}});
}

void Supervisor::push_to_end() {
    const Clock::time_point now = Clock::now();
    const auto signal_all = [this](int signal) {
        for (const Slot& slot : slots_)
            if (slot.child.pid > 0) kill(slot.child.pid, signal);
        ++stop_signals_;
        stop_began_ = Clock::now();
    };
    const auto waited = now - stop_began_;
    if (stop_signals_ == 0)
        signal_all(SIGTERM);  // finish the job
    else if (stop_signals_ == 1 && (hurried_ || waited >= std::chrono::seconds(settings_.drain_s)))
        signal_all(SIGTERM);  // drop it
    else if (stop_signals_ == 2 && waited >= kAbandonTimeMax)
        signal_all(SIGKILL);
}

bool Supervisor::any_alive() const {
    return std::any_of(slots_.begin(), slots_.end(),
                       [](const Slot& slot) { return slot.child.pid > 0 || slot.release_due; });
}

}  // namespace kiln
