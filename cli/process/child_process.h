// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/child_process.h
// One disposable copy of this program (POSIX). The copy dies with its parent, dumps no core, and its output is bounded.
#pragma once
#include <signal.h>
#include <sys/types.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dgm::bake {

/// An open file descriptor, closed with its owner.
class Descriptor {
 public:
    Descriptor() = default;
    explicit Descriptor(int fd) : fd_(fd) {}
    Descriptor(Descriptor&& other) noexcept : fd_(other.release()) {}
    Descriptor& operator=(Descriptor&& other) noexcept;
    ~Descriptor() { reset(); }
    [[nodiscard]] int get() const { return fd_; }
    [[nodiscard]] bool is_open() const { return fd_ >= 0; }
    void reset();
    int release();

 private:
    int fd_ = -1;
};

/// A nameless file in memory that holds `bytes` and stands at its start: unlike a pipe it takes any length without a
/// reader. @throws model::Error kSystemBusy
[[nodiscard]] Descriptor memory_file(std::string_view bytes);

/// The exit code of a child that could not run the program again.
inline constexpr int kCannotRunAgain = 127;

/// How a child ended.
struct ChildEnd {
    int exit_code = 0;
    int signal = 0;  ///< 0 if it exited by itself

    /// Not by itself: the kernel where memory ran out, a scheduler, or a person.
    [[nodiscard]] bool is_killed() const { return signal == SIGKILL || signal == SIGTERM; }
};

/// Runs /proc/self/exe with `--worker`, or a copy of this process; see worker_io.h for the descriptors it finds. Killed
/// and reaped with its owner. Not thread-safe; create it on the thread that lives as long as the batch (the child gets
/// a signal at its death).
class ChildProcess {
 public:
    /// @throws model::Error kSystemBusy if the system has no process, memory or descriptor left
    explicit ChildProcess(std::string_view job);
    /// Runs `work` in a copy of this program as it is now, which then ends: cheaper than the program anew, and it has
    /// all that the program has in memory. Of its descriptors it keeps those above alone. The program must have one
    /// thread. @throws model::Error as above
    explicit ChildProcess(const std::function<void()>& work);
    ChildProcess(ChildProcess&&) noexcept;
    ChildProcess& operator=(ChildProcess&&) = delete;
    ~ChildProcess();

    [[nodiscard]] pid_t pid() const { return pid_; }                ///< -1 once it has ended
    [[nodiscard]] int messages() const { return messages_.get(); }  ///< -1 once at its end
    [[nodiscard]] int errors() const { return errors_.get(); }      ///< -1 once at its end

    /// Takes some of the arrived bytes, without waiting, and appends whole message lines (no newline) to `lines`. False
    /// if a line is longer than `max_line`.
    [[nodiscard]] bool read_messages(std::vector<std::string>& lines, std::size_t max_line);
    /// Takes some of the bytes arrived on stderr, keeping the last 16 KiB.
    void read_errors();
    [[nodiscard]] const std::string& error_text() const { return error_text_; }

    /// The end, if it has come.
    [[nodiscard]] std::optional<ChildEnd> poll_end();
    /// SIGKILL, and waits for the end.
    void kill();
    /// SIGKILL without waiting: the end may take long where the system is busy and the worker's memory large.
    void begin_kill();
    /// Waits for the end until `deadline`; after that the child is left to the system, which ends it all the same.
    void leave(std::chrono::steady_clock::time_point deadline);

 private:
    template <class Begin>
    void start(const Begin& begin);

    pid_t pid_ = -1;
    Descriptor messages_, errors_;
    std::string pending_, error_text_;
};

}  // namespace dgm::bake
