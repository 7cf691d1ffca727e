// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/hdf5_apart.cpp
// A fork server: main() forks a copy of the young program, which forks again for each file. A fork of the program as it
// is later would copy threads' locks and the meshes in memory.
#include "process/hdf5_apart.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <new>

#include "model/codes.h"
#include "process/byte_stream.h"
#include "process/sandbox.h"
#include "process/worker_io.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;
using formats::Hdf5Part;

constexpr char kPart = 'H', kEnd = '.';
/// A report of 256 MiB, attributes of 64 KiB for thousands of layers, and more.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;
constexpr std::uint64_t kMostMemory = std::uint64_t{2} << 30;
constexpr unsigned kMostSeconds = 120;
constexpr std::size_t kMostPath = 8192;

struct Request {
    formats::DgmReadLimits limits;
    std::uint32_t path_bytes = 0;
    std::array<char, kMostPath> path{};
};

/// A request and a descriptor as one message. It points into itself and at `request`.
struct Envelope {
    explicit Envelope(Request& request) : part{&request, sizeof request} {
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        message.msg_control = control.data();
        message.msg_controllen = control.size();
    }
    Envelope(const Envelope&) = delete;
    Envelope& operator=(const Envelope&) = delete;

    iovec part;
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
    msghdr message{};
};

/// sendmsg() or recvmsg(), again where a signal comes between. True if a whole request went.
template <class Move>
bool moved_whole(const Move& move) {
    ssize_t bytes = 0;
    do bytes = move();
    while (bytes < 0 && errno == EINTR);
    return bytes == static_cast<ssize_t>(sizeof(Request));
}

bool send_request(int socket, Request& request, int descriptor) {
    Envelope out(request);
    cmsghdr* header = CMSG_FIRSTHDR(&out.message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(header), &descriptor, sizeof descriptor);
    return moved_whole([&] { return sendmsg(socket, &out.message, MSG_NOSIGNAL); });
}

/// The next request, and the descriptor that came with it; none once the program has ended.
Descriptor receive_request(int socket, Request& request) {
    Envelope in(request);
    if (!moved_whole([&] { return recvmsg(socket, &in.message, MSG_CMSG_CLOEXEC); })) return {};
    const cmsghdr* header = CMSG_FIRSTHDR(&in.message);
    if (header == nullptr || header->cmsg_type != SCM_RIGHTS) return {};
    int descriptor = -1;
    std::memcpy(&descriptor, CMSG_DATA(header), sizeof descriptor);
    return Descriptor(descriptor);
}

/// In the disposable process: reads the file, sends what it holds, and ends.
[[noreturn]] void read_and_end(const Request& request, int answer) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    alarm(kMostSeconds);
    const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
    for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, standard);
    dup2(answer, kMessageDescriptor);
    close_range(kMessageDescriptor + 1, ~0U, 0);
    const std::filesystem::path path(std::string(request.path.data(), request.path_bytes));
    try {
        limit_worker_memory(kMostMemory, 1);
        static_cast<void>(enter_sandbox({.readable = {path}, .writable = {}}));
        Hdf5Part part;
        try {
            part = formats::read_hdf5_part(path, request.limits);
        } catch (const model::Error& error) {
            part.findings.push_back({&error.code(), formats::Severity::kError, error.what(), error.place(), {}, {}});
        }
        if (send_message(encode_hdf5_part(part))) _exit(0);
    } catch (const std::exception&) {}  // no memory: said already
    _exit(static_cast<int>(model::ExitCode::kInternal));
}

/// The copied process, until the program ends.
[[noreturn]] void serve(int socket) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    signal(SIGINT, SIG_IGN);  // Ctrl-C reaches the whole foreground group: the program alone answers it
    signal(SIGTERM, SIG_DFL);
    signal(SIGHUP, SIG_IGN);
    formats::prepare_hdf5();
    for (;;) {
        Request request;
        const Descriptor answer = receive_request(socket, request);
        if (!answer.is_open()) _exit(0);
        const pid_t child = fork();
        if (child == 0) read_and_end(request, answer.get());
        int status = -1;
        while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {}
        if (send(socket, &status, sizeof status, MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof status)) _exit(0);
    }
}

/// All that arrives until the end of it, or nullopt if that is too much.
std::optional<std::string> read_all(int from) {
    std::string bytes;
    std::array<char, 65536> buffer;
    for (;;) {
        const ssize_t n = ::read(from, buffer.data(), buffer.size());
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return bytes;
        if (bytes.size() + static_cast<std::size_t>(n) > kMostBytes) return std::nullopt;
        bytes.append(buffer.data(), static_cast<std::size_t>(n));
    }
}

Hdf5Part unreadable(std::string message) {
    Hdf5Part part;
    part.findings.push_back({&codes::kHdf5Unreadable, formats::Severity::kError, std::move(message), "/", {}, {}});
    return part;
}

[[noreturn]] void fail(const char* action) {
    throw model::Error(codes::kSystemBusy, std::string(action) + ": " + std::strerror(errno));
}

void put_value(ByteWriter& out, const model::AttributeValue& value) {
    out.put(static_cast<std::uint8_t>(value.index()));
    if (const auto* text = std::get_if<std::string>(&value)) out.put(*text);
    if (const auto* doubles = std::get_if<std::vector<double>>(&value)) out.put_all(*doubles);
    if (const auto* words = std::get_if<std::vector<std::uint32_t>>(&value)) out.put_all(*words);
}

model::AttributeValue get_value(ByteReader& in) {
    const auto kind = in.get<std::uint8_t>();
    if (kind == 0) return in.text();
    if (kind == 1) {
        std::vector<double> doubles;
        in.get_all(doubles);
        return doubles;
    }
    std::vector<std::uint32_t> words;
    in.get_all(words);
    return words;
}

}  // namespace

std::string encode_hdf5_part(const Hdf5Part& part) {
    ByteWriter out;
    out.put(kPart);
    out.put_each(part.findings, [&](const formats::Finding& f) {
        out.put(std::int32_t{f.code->number});
        out.put(f.message);
        out.put(f.place);
        for (const auto& figure : {f.measured, f.limit}) {
            out.put(static_cast<char>(figure.has_value()));
            out.put(figure.value_or(0));
        }
    });
    for (const std::string* text : {&part.generator, &part.source_name, &part.report_json}) out.put(*text);
    out.put_each(part.attributes, [&](const auto& layer) {
        out.put(std::uint64_t{layer.size()});
        for (const auto& [name, value] : layer) {
            out.put(name);
            put_value(out, value);
        }
    });
    out.put(kEnd);
    return out.take();
}

std::optional<Hdf5Part> decode_hdf5_part(std::string_view bytes) {
    ByteReader in(bytes);
    if (in.get<char>() != kPart) return std::nullopt;
    Hdf5Part part;
    bool known = true;
    in.get_each([&] {
        formats::Finding& f = part.findings.emplace_back();
        f.code = code_of(in.get<std::int32_t>());
        known = known && f.code != nullptr;
        f.message = in.text();
        f.place = in.text();
        for (auto* figure : {&f.measured, &f.limit}) {
            const bool is_there = in.get<char>() != 0;
            const auto value = in.get<double>();
            if (is_there) *figure = value;
        }
    });
    for (std::string* text : {&part.generator, &part.source_name, &part.report_json}) *text = in.text();
    in.get_each([&] {
        auto& layer = part.attributes.emplace_back();
        in.get_each([&] {
            std::string name = in.text();
            layer.emplace(std::move(name), get_value(in));
        });
    });
    if (in.get<char>() != kEnd || !in.at_end() || !known) return std::nullopt;
    return part;
}

Hdf5Apart::Hdf5Apart() {
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
        serve(other.get());
    }
    formats::set_hdf5_reader([this](const auto& path, const auto& limits) { return read(path, limits); });
}

Hdf5Apart::~Hdf5Apart() {
    formats::set_hdf5_reader({});
    server_.reset();
    while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {}
}

Hdf5Part Hdf5Apart::read(const std::filesystem::path& path, const formats::DgmReadLimits& limits) {
    Request request{.limits = limits, .path_bytes = static_cast<std::uint32_t>(path.native().size())};
    if (path.native().size() > request.path.size())
        throw model::Error(codes::kReadFailed, "the path is too long", path.string());
    path.native().copy(request.path.data(), request.path.size());
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) fail("pipe");
    Descriptor from(ends[0]), to(ends[1]);

    const std::scoped_lock lock(one_file_);
    const bool sent = send_request(server_.get(), request, to.get());
    to.reset();
    const std::optional<std::string> bytes = sent ? read_all(from.get()) : std::nullopt;
    from.reset();  // a process that sends without end is ended by the next byte
    int status = -1;
    if (!sent || recv(server_.get(), &status, sizeof status, 0) != static_cast<ssize_t>(sizeof status))
        throw model::Error(codes::kWorkerKilled, "the process that reads HDF5 has been ended from outside",
                           path.string());
    if (status == -1) throw model::Error(codes::kSystemBusy, "there is no process to read HDF5 in", path.string());
    if (bytes && bytes->starts_with(kOutOfMemoryLine)) return unreadable("HDF5 needs more than 2 GiB to read it");
    if (WIFSIGNALED(status)) {
        const int signal = WTERMSIG(status);
        if (signal == SIGALRM || signal == SIGXCPU)
            return unreadable(fmt::format("HDF5 has not read it after {} seconds", kMostSeconds));
        return unreadable(fmt::format("HDF5 crashes on it: signal {} ({})", signal, strsignal(signal)));
    }
    if (bytes && WEXITSTATUS(status) == 0)
        if (auto part = decode_hdf5_part(*bytes)) return std::move(*part);
    return unreadable("HDF5 sends nothing of use about it");
}

}  // namespace dgm::bake
