// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/fork_server.h
// Disposable processes made of a copy of the young program: a fork of the program as it is later would copy threads'
// locks and the meshes in memory.
#pragma once
#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "process/child_process.h"

namespace dgm::bake {

/// A copy of this program that is made by the constructor and forks again for each request: create it first of all in
/// main(), before any thread and before anything large is loaded.
class ForkServer {
 public:
    struct Duty {
        /// Runs in the disposable process, which has no descriptors but null ones and kMessageDescriptor. Its answer
        /// goes there (answer_in_sandbox()); it ends the process with an exit code of 0 if all was sent.
        std::function<void(std::string_view request)> work;
        std::function<void()> prepare;  ///< once, in the copy of the program; may be empty
        unsigned seconds = 120;         ///< wall clock of one request; SIGALRM ends it then
    };
    /// @throws model::Error kSystemBusy if the system has no process, memory or descriptor left
    explicit ForkServer(const Duty& duty);
    ForkServer(const ForkServer&) = delete;
    ForkServer& operator=(const ForkServer&) = delete;
    ~ForkServer();

    /// A request that is being worked at.
    class Reply {
     public:
        /// Up to `size` bytes of the answer; 0 at its end.
        [[nodiscard]] std::size_t read(char* into, std::size_t size);
        /// Stops listening: a process that goes on sending is ended by that. @return how it ended
        /// @throws model::Error kWorkerKilled if the copy of the program is gone; kSystemBusy if it could not fork
        [[nodiscard]] ChildEnd end();

     private:
        friend class ForkServer;
        Descriptor answer_, status_;
    };

    /// For requests of any length. Thread-safe, several at a time. @throws model::Error kWorkerKilled, kSystemBusy
    [[nodiscard]] Reply ask(std::string_view request);

 private:
    Descriptor server_;
    pid_t pid_ = -1;
};

}  // namespace dgm::bake
