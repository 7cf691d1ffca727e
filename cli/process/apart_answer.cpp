// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/apart_answer.cpp
#include "process/apart_answer.h"

#include <fmt/format.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include <cstring>

#include "model/codes.h"
#include "process/byte_stream.h"
#include "process/error_stream.h"

namespace dgm::bake {

void answer_in_sandbox(const Sandbox& sandbox, std::uint64_t memory_bytes, const std::function<bool()>& answer) {
    limit_worker_memory(memory_bytes, 1);
    bool is_sent = false;
    try {
        static_cast<void>(enter_sandbox(sandbox));
        is_sent = answer();
    } catch (const model::Error& error) { is_sent = send_head(encode_error(error)); }
    if (is_sent) _exit(0);
}

bool send_head(const std::string& head) {
    ByteWriter length;
    length.put(std::uint64_t{head.size()});
    return send_message(length.take()) && send_message(head);
}

ApartAnswer::ApartAnswer(ForkServer& server, std::string_view request) : reply_(server.ask(request)) {}

std::optional<std::string> ApartAnswer::head(std::uint64_t most) {
    std::uint64_t length = 0;
    begun_.resize(sizeof length);
    if (!read_whole(begun_.data(), begun_.size())) return std::nullopt;
    std::memcpy(&length, begun_.data(), sizeof length);
    std::string head;
    if (length > most || !grow(head, length)) return std::nullopt;
    throw_sent_error(head);
    return head;
}

bool ApartAnswer::lacked_memory() const {
    return !begun_.empty() && kOutOfMemoryLine.starts_with(begun_);
}

std::string ApartAnswer::failure(std::string_view reader, unsigned seconds) {
    const ChildEnd end = reply_.end();
    if (lacked_memory()) return fmt::format("{} needs too much memory for it", reader);
    if (end.signal == SIGALRM || end.signal == SIGXCPU)
        return fmt::format("{} has not read it after {} seconds", reader, seconds);
    if (end.is_killed())
        throw model::Error(model::codes::kWorkerKilled,
                           fmt::format("the process that reads strangers' files was ended by signal {}", end.signal));
    if (end.signal != 0)
        return fmt::format("{} crashes on it: signal {} ({})", reader, end.signal, strsignal(end.signal));
    return fmt::format("{} sends nothing of use about it", reader);
}

bool ApartAnswer::read_whole(char* into, std::size_t size) {
    while (size > 0) {
        const std::size_t n = reply_.read(into, size);
        if (n == 0) return false;
        into += n;
        size -= n;
    }
    return true;
}

}  // namespace dgm::bake
