// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/apart_answer.h
// The answer of a disposable process of a ForkServer: a head, then the bytes of the arrays that it announces. Nothing
// of it is trusted: memory grows with what comes, and a process that dies is told by name.
#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "process/fork_server.h"
#include "process/sandbox.h"
#include "process/worker_io.h"

namespace dgm::bake {

/// In the disposable process: enters the sandbox, with memory of `memory_bytes` beside what it has, and ends well once
/// `answer` has sent everything, or the model::Error that it threw has been sent. Returns if the program is gone.
void answer_in_sandbox(const Sandbox& sandbox, std::uint64_t memory_bytes, const std::function<bool()>& answer);

/// The length of `head`, then itself. False if the program is gone.
[[nodiscard]] bool send_head(const std::string& head);

/// The bytes of an array, after the head. False if the program is gone.
template <class T>
[[nodiscard]] bool send_array(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    return send_message({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

/// The program's end of it. For one thread.
class ApartAnswer {
 public:
    /// Asks. @throws model::Error kWorkerKilled, kSystemBusy
    ApartAnswer(ForkServer& server, std::string_view request);

    /// nullopt if what comes is no head, or one of more than `most` bytes. @throws model::Error the one that was sent
    [[nodiscard]] std::optional<std::string> head(std::uint64_t most);

    /// `count` more values. False if there are fewer.
    template <class T>
    [[nodiscard]] bool array(std::vector<T>& into, std::uint64_t count) {
        static_assert(std::is_trivially_copyable_v<T>);
        return grow(into, count);
    }

    /// Stops listening, and says why there was no answer of use. @param reader  who reads, such as "OpenEXR"
    /// @param seconds  what it had
    /// @throws model::Error kWorkerKilled, kSystemBusy
    [[nodiscard]] std::string failure(std::string_view reader, unsigned seconds);
    /// An allocation failed before anything was sent.
    [[nodiscard]] bool lacked_memory() const;

 private:
    /// Exactly `size` bytes. False if there are fewer.
    bool read_whole(char* into, std::size_t size);
    template <class Values>
    bool grow(Values& into, std::uint64_t count) {
        constexpr std::uint64_t kValue = sizeof(typename Values::value_type),
                                kStep = (std::uint64_t{64} << 20) / kValue;
        into.reserve(std::min(count, kStep));
        while (into.size() < count) {
            const std::size_t old = into.size(), step = static_cast<std::size_t>(std::min(kStep, count - old));
            into.resize(old + step);
            if (!read_whole(reinterpret_cast<char*>(into.data() + old), step * kValue)) return false;
        }
        return true;
    }

    ForkServer::Reply reply_;
    std::string begun_;  ///< the first bytes
};

}  // namespace dgm::bake
