// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/child_process.cpp
#include "process/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "model/codes.h"
#include "process/worker_io.h"

namespace dgm::bake {
namespace {

constexpr std::size_t kMaxErrorText = 16384;

[[noreturn]] void fail(const char* what) {
    const bool is_short = errno == EAGAIN || errno == ENOMEM || errno == EMFILE || errno == ENFILE || errno == ENOSPC;
    throw model::Error(is_short ? model::codes::kSystemBusy : model::codes::kInternal,
                       std::string("the worker process cannot be started: ") + what + ": " + std::strerror(errno));
}

/// The same file at a number of 10 or more, clear of the numbers the child's own descriptors get.
Descriptor moved_up(int fd) {
    Descriptor original(fd);
    Descriptor high(fcntl(fd, F_DUPFD_CLOEXEC, 10));
    if (!high.is_open()) {
        if (errno == EINVAL) errno = EMFILE;  // the limit of descriptors is below the number asked for
        fail("fcntl");
    }
    return high;
}

struct Pipe {
    Descriptor read_end, write_end;
};

Pipe make_pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) fail("pipe");
    Descriptor second(ends[1]);
    Pipe out;
    out.read_end = moved_up(ends[0]);
    out.write_end = moved_up(second.release());
    if (fcntl(out.read_end.get(), F_SETFL, O_NONBLOCK) != 0) fail("fcntl");
    return out;
}

/// The part of this program's environment that a worker needs: how libraries are found and tuned, the locale,
/// and what sanitizers and coverage write where. Passwords and keys that callers pass on by it are not among that.
std::vector<char*> worker_environment() {
    constexpr std::array<std::string_view, 21> kKept{"PATH=",         "LD_LIBRARY_PATH=",
                                                     "LD_PRELOAD=",   "LANG=",
                                                     "LC_ALL=",       "TZ=",
                                                     "TMPDIR=",       "GLIBC_TUNABLES=",
                                                     "MALLOC_",       "TBB_",
                                                     "OMP_",          "ASAN_OPTIONS=",
                                                     "LSAN_OPTIONS=", "UBSAN_OPTIONS=",
                                                     "TSAN_OPTIONS=", "MSAN_OPTIONS=",
                                                     "GCOV_",         "LLVM_PROFILE_FILE=",
                                                     "EMBREE_",       "HDF5_",
                                                     "DGM_"};
    std::vector<char*> out;
    for (char** variable = environ; *variable != nullptr; ++variable)
        if (std::any_of(kKept.begin(), kKept.end(),
                        [&](std::string_view start) { return std::string_view(*variable).starts_with(start); }))
            out.push_back(*variable);
    out.push_back(nullptr);
    return out;
}

/// Between fork and exec: async-signal-safe calls only. False if a descriptor could not be placed.
bool become_worker(pid_t parent, int job, int messages, int errors) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(kCannotRunAgain);  // it died before prctl was heard
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    // Ctrl-C reaches the whole foreground group: the parent alone answers it.
    signal(SIGINT, SIG_IGN);
    signal(SIGTERM, SIG_DFL);
    signal(SIGHUP, SIG_DFL);
    signal(SIGPIPE, SIG_DFL);
    signal(SIGXFSZ, SIG_IGN);  // a limit of file size is a failed write (EFBIG), not a crash
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    return dup2(job, kJobDescriptor) >= 0 && dup2(errors, STDOUT_FILENO) >= 0 && dup2(errors, STDERR_FILENO) >= 0 &&
           dup2(messages, kMessageDescriptor) >= 0;
}

[[noreturn]] void run_program_again(char* const* environment) {
    char name[] = "dgm-bake", flag[] = "--worker";
    char* const arguments[] = {name, flag, nullptr};
    if (close_range(kMessageDescriptor + 1, ~0U, CLOSE_RANGE_CLOEXEC) == 0)
        execve("/proc/self/exe", arguments, environment);
    constexpr std::string_view kMessage = "/proc/self/exe cannot be run again\n";
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kMessage.data(), kMessage.size());
    _exit(kCannotRunAgain);
}

/// Takes the bytes that have arrived, at most one buffer full: a worker that never stops writing must not keep the
/// others' deadlines waiting. Closes `from` at its end.
std::string_view take(Descriptor& from, std::array<char, 65536>& buffer) {
    if (!from.is_open()) return {};
    const ssize_t n = read(from.get(), buffer.data(), buffer.size());
    if (n > 0) return {buffer.data(), static_cast<std::size_t>(n)};
    if (n == 0 || (errno != EINTR && errno != EAGAIN)) from.reset();
    return {};
}

}  // namespace

Descriptor memory_file(std::string_view bytes) {
    const int fd = memfd_create("dgm-job", MFD_CLOEXEC);
    if (fd < 0) fail("memfd_create");
    Descriptor file = moved_up(fd);
    while (!bytes.empty()) {
        const ssize_t n = write(file.get(), bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) fail("write");
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    if (lseek(file.get(), 0, SEEK_SET) != 0) fail("lseek");
    return file;
}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
    if (this != &other) {
        reset();
        fd_ = other.release();
    }
    return *this;
}

void Descriptor::reset() {
    if (fd_ >= 0) close(fd_);
    fd_ = -1;
}

int Descriptor::release() {
    return std::exchange(fd_, -1);
}

template <class Begin>
void ChildProcess::start(const Begin& begin) {
    Pipe message_pipe = make_pipe(), error_pipe = make_pipe();
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child < 0) fail("fork");
    if (child == 0) begin(parent, message_pipe.write_end.get(), error_pipe.write_end.get());
    pid_ = child;
    messages_ = std::move(message_pipe.read_end);
    errors_ = std::move(error_pipe.read_end);
}

ChildProcess::ChildProcess(std::string_view job) {
    const Descriptor input = memory_file(job);
    const std::vector<char*> environment = worker_environment();
    start([&](pid_t parent, int messages, int errors) {
        if (become_worker(parent, input.get(), messages, errors)) run_program_again(environment.data());
        _exit(kCannotRunAgain);
    });
}

ChildProcess::ChildProcess(const std::function<void()>& work) {
    const Descriptor nothing = memory_file({});
    start([&](pid_t parent, int messages, int errors) {
        if (!become_worker(parent, nothing.get(), messages, errors)) _exit(kCannotRunAgain);
        close_range(kMessageDescriptor + 1, ~0U, 0);
        try {
            work();
        } catch (...) { _exit(static_cast<int>(model::ExitCode::kInternal)); }
        _exit(static_cast<int>(model::ExitCode::kOk));
    });
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      messages_(std::move(other.messages_)),
      errors_(std::move(other.errors_)),
      pending_(std::move(other.pending_)),
      error_text_(std::move(other.error_text_)) {}

ChildProcess::~ChildProcess() {
    kill();
}

bool ChildProcess::read_messages(std::vector<std::string>& lines, std::size_t max_line) {
    std::array<char, 65536> buffer;
    std::string_view bytes = take(messages_, buffer);
    while (!bytes.empty()) {
        const std::size_t newline = bytes.find('\n');
        pending_ += bytes.substr(0, newline);
        if (pending_.size() > max_line) return false;
        if (newline == std::string_view::npos) break;
        lines.push_back(std::exchange(pending_, {}));
        bytes.remove_prefix(newline + 1);
    }
    return true;
}

void ChildProcess::read_errors() {
    std::array<char, 65536> buffer;
    error_text_ += take(errors_, buffer);
    if (error_text_.size() > kMaxErrorText) error_text_.erase(0, error_text_.size() - kMaxErrorText);
}

std::optional<ChildEnd> ChildProcess::poll_end() {
    int status = 0;
    if (pid_ < 0 || waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
    pid_ = -1;
    if (WIFSIGNALED(status)) return ChildEnd{0, WTERMSIG(status)};
    return ChildEnd{WEXITSTATUS(status), 0};
}

void ChildProcess::begin_kill() {
    if (pid_ >= 0) ::kill(pid_, SIGKILL);
}

void ChildProcess::leave(std::chrono::steady_clock::time_point deadline) {
    while (pid_ >= 0 && !poll_end() && std::chrono::steady_clock::now() < deadline)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    pid_ = -1;
}

void ChildProcess::kill() {
    if (pid_ < 0) return;
    begin_kill();
    while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {}
    pid_ = -1;
}

}  // namespace dgm::bake
