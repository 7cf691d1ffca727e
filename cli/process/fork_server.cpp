// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/fork_server.cpp
// For each request the server forks a handler, which forks the process that does the work, waits for it and tells how
// it ended. So requests do not wait for each other, and no answer can pretend how its process ended.
#include "process/fork_server.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "model/codes.h"
#include "process/worker_io.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;

/// The status of a process that could not be made; no wait status.
constexpr int kNoProcess = -1;

/// The descriptors of a request: its bytes, and where its answer and its status go.
using Descriptors = std::array<int, 3>;

/// They as one message, which has to have a byte as well. It points into itself.
struct Envelope {
    Envelope() : part{&byte, 1} {
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        message.msg_control = control.data();
        message.msg_controllen = control.size();
    }
    Envelope(const Envelope&) = delete;
    Envelope& operator=(const Envelope&) = delete;

    char byte = 0;
    iovec part;
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(Descriptors))> control{};
    msghdr message{};
};

/// A call again where a signal comes between.
template <class Call>
ssize_t retried(const Call& call) {
    ssize_t result = 0;
    do result = call();
    while (result < 0 && errno == EINTR);
    return result;
}

bool send_request(int socket, const Descriptors& descriptors) {
    Envelope out;
    cmsghdr* header = CMSG_FIRSTHDR(&out.message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof descriptors);
    std::memcpy(CMSG_DATA(header), descriptors.data(), sizeof descriptors);
    return retried([&] { return sendmsg(socket, &out.message, MSG_NOSIGNAL); }) == 1;
}

/// What the server gets of a request.
struct Received {
    Descriptor request, answer, status;
};

/// nullopt once the program has ended.
std::optional<Received> receive_request(int socket) {
    Envelope in;
    const ssize_t size = retried([&] { return recvmsg(socket, &in.message, MSG_CMSG_CLOEXEC); });
    const cmsghdr* header = size <= 0 ? nullptr : CMSG_FIRSTHDR(&in.message);
    if (header == nullptr || header->cmsg_type != SCM_RIGHTS) return std::nullopt;
    Descriptors descriptors{-1, -1, -1};
    std::memcpy(descriptors.data(), CMSG_DATA(header), sizeof descriptors);
    return Received{Descriptor(descriptors[0]), Descriptor(descriptors[1]), Descriptor(descriptors[2])};
}

/// In the disposable process.
[[noreturn]] void work_and_end(const ForkServer::Duty& duty, const Received& received) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    signal(SIGCHLD, SIG_DFL);
    alarm(duty.seconds);
    const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
    dup2(received.request.get(), kJobDescriptor);
    for (const int standard : {STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, standard);
    dup2(received.answer.get(), kMessageDescriptor);
    close_range(kMessageDescriptor + 1, ~0U, 0);
    try {
        const std::string request = read_job_text();
        const int end_of_file = open("/dev/null", O_RDWR | O_CLOEXEC);
        dup2(end_of_file, kJobDescriptor);
        close(end_of_file);
        duty.work(request);
    } catch (const std::exception&) {}  // no memory: said already
    _exit(static_cast<int>(model::ExitCode::kInternal));
}

void tell(const Descriptor& to, int status) {
    static_cast<void>(retried([&] { return write(to.get(), &status, sizeof status); }));
}

/// Between the server and the disposable process: waits for it.
[[noreturn]] void handle(const ForkServer::Duty& duty, Received received) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    signal(SIGCHLD, SIG_DFL);
    const pid_t child = fork();
    if (child == 0) work_and_end(duty, received);
    received.request.reset();
    received.answer.reset();
    int status = kNoProcess;
    if (child > 0) static_cast<void>(retried([&] { return waitpid(child, &status, 0); }));
    tell(received.status, status);
    _exit(0);
}

/// The copied process, until the program ends.
[[noreturn]] void serve(int socket, const ForkServer::Duty& duty) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    signal(SIGINT, SIG_IGN);  // Ctrl-C reaches the whole foreground group: the program alone answers it
    signal(SIGTERM, SIG_DFL);
    signal(SIGHUP, SIG_IGN);
    signal(SIGCHLD, SIG_IGN);  // handlers leave nothing to wait for
    if (duty.prepare) duty.prepare();
    while (std::optional<Received> received = receive_request(socket)) {
        const pid_t handler = fork();
        if (handler == 0) {
            close(socket);
            handle(duty, std::move(*received));
        }
        if (handler < 0) tell(received->status, kNoProcess);
    }
    _exit(0);
}

[[noreturn]] void fail(const char* action) {
    throw model::Error(codes::kSystemBusy, std::string(action) + ": " + std::strerror(errno));
}

/// The ends for reading and writing.
std::array<Descriptor, 2> make_pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) fail("pipe");
    return {Descriptor(ends[0]), Descriptor(ends[1])};
}

}  // namespace

ForkServer::ForkServer(const Duty& duty) {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) fail("socketpair");
    server_ = Descriptor(ends[0]);
    Descriptor other(ends[1]);
    const pid_t program = getpid();
    pid_ = fork();
    if (pid_ < 0) fail("fork");
    if (pid_ == 0) {
        server_.reset();
        if (getppid() != program) _exit(0);
        serve(other.get(), duty);
    }
}

ForkServer::~ForkServer() {
    server_.reset();
    static_cast<void>(retried([&] { return waitpid(pid_, nullptr, 0); }));
}

ForkServer::Reply ForkServer::ask(std::string_view request) {
    const Descriptor bytes = memory_file(request);
    auto [answer, to_answer] = make_pipe();
    auto [status, to_status] = make_pipe();
    if (!send_request(server_.get(), {bytes.get(), to_answer.get(), to_status.get()}))
        throw model::Error(codes::kWorkerKilled, "the process that reads strangers' files has been ended from outside");
    Reply out;
    out.answer_ = std::move(answer);
    out.status_ = std::move(status);
    return out;
}

std::size_t ForkServer::Reply::read(char* into, std::size_t size) {
    const ssize_t n = retried([&] { return ::read(answer_.get(), into, size); });
    return n > 0 ? static_cast<std::size_t>(n) : 0;
}

ChildEnd ForkServer::Reply::end() {
    answer_.reset();
    int status = 0;
    if (retried([&] { return ::read(status_.get(), &status, sizeof status); }) != static_cast<ssize_t>(sizeof status))
        throw model::Error(codes::kWorkerKilled, "the process that reads strangers' files has been ended from outside");
    if (status == kNoProcess) throw model::Error(codes::kSystemBusy, "there is no process to read the file in");
    if (WIFSIGNALED(status)) return {0, WTERMSIG(status)};
    return {WEXITSTATUS(status), 0};
}

}  // namespace dgm::bake
