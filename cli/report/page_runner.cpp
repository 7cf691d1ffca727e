// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/page_runner.cpp
#include "report/page_runner.h"

#include <fmt/format.h>
#include <string.h>

#include <chrono>
#include <iterator>
#include <list>
#include <string>
#include <utility>

#include "dgm/atomic_file.h"
#include "model/codes.h"
#include "pipeline/child_process.h"
#include "pipeline/signal_scope.h"
#include "pipeline/worker_protocol.h"

namespace dgm::report {
namespace {
namespace codes = model::codes;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto kLastWait = std::chrono::milliseconds(500);
constexpr std::size_t kMaxMessageBytes = std::size_t{1} << 20;

struct Running {
    std::size_t task;
    bake::ChildProcess child;
    Clock::time_point started;
    std::optional<model::Error> said;  // the worker's own account of a failure
    bool done = false;                 // it said that the page is written
};

class Runner {
 public:
    Runner(const std::vector<PageTask>& tasks, const PageLimits& limits,
           const std::function<void(std::size_t)>& on_done)
        : tasks_(tasks), limits_(limits), on_done_(on_done), outcomes_(tasks.size()) {}

    std::vector<PageOutcome> run() {
        while (!signals_.stop_requested() && (next_ < tasks_.size() || !running_.empty())) {
            while (next_ < tasks_.size() && running_.size() < limits_.jobs) start(next_++);
            wait();
            for (auto it = running_.begin(); it != running_.end();)
                it = advance(*it) ? running_.erase(it) : std::next(it);
        }
        if (signals_.stop_requested()) interrupt();
        return std::move(outcomes_);
    }

 private:
    void start(std::size_t k) {
        try {
            running_.push_back({k, bake::ChildProcess(encode(tasks_[k].job)), Clock::now(), {}, false});
        } catch (const model::Error& error) { finish(k, error); }
    }

    void wait() const {
        std::vector<const bake::ChildProcess*> workers;
        for (const Running& r : running_) workers.push_back(&r.child);
        signals_.wait(workers, false);
    }

    /// True if the worker is through.
    bool advance(Running& r) {
        r.child.read_errors();
        std::vector<std::string> lines;
        if (!r.child.read_messages(lines, kMaxMessageBytes)) {
            r.child.kill();
            finish(r.task, model::Error(codes::kWorkerCrashed, "the worker sent something that is not a message"));
            return true;
        }
        for (const std::string& line : lines) take(r, line);
        if (Clock::now() - r.started > std::chrono::duration<double>(limits_.time_limit_seconds)) {
            r.child.kill();
            finish(r.task, model::Error(codes::kWorkerTimeout,
                                        fmt::format("it was not done after {} s", limits_.time_limit_seconds)));
            return true;
        }
        if (r.child.messages() >= 0 || r.child.errors() >= 0) return false;
        const std::optional<bake::ChildEnd> end = r.child.poll_end();
        if (!end) return false;
        finish(r.task, error_of(r, *end));
        return true;
    }

    static void take(Running& r, const std::string& line) {
        const std::optional<bake::WorkerMessage> message = bake::decode_message(line);
        if (!message) return;
        if (const auto* error = std::get_if<bake::ErrorMessage>(&*message)) r.said = error->error;
        if (std::holds_alternative<bake::OutOfMemoryMessage>(*message) && !r.said)
            r.said = model::Error(codes::kWorkerMemory, "it needs more memory than it may take");
        if (std::holds_alternative<bake::ResultMessage>(*message)) r.done = true;
    }

    static std::optional<model::Error> error_of(const Running& r, bake::ChildEnd end) {
        if (r.said) return r.said;
        if (end.signal != 0)
            return model::Error(codes::kWorkerCrashed, fmt::format("the worker process was ended by signal {} ({})",
                                                                   end.signal, strsignal(end.signal)));
        if (r.done && end.exit_code == 0) return std::nullopt;
        return model::Error(codes::kWorkerCrashed,
                            fmt::format("the worker process ended with exit code {} and no page", end.exit_code));
    }

    void finish(std::size_t k, std::optional<model::Error> error) {
        const PageTask& task = tasks_[k];
        if (!error) {
            try {
                formats::publish_file(task.job.output, task.final_path);
            } catch (const model::Error& failure) { error = failure; }
        }
        outcomes_[k].error = std::move(error);
        std::error_code ignored;
        fs::remove(task.job.output, ignored);  // if it was not renamed
        if (on_done_) on_done_(k);
    }

    void interrupt() {
        for (Running& r : running_) r.child.begin_kill();
        const Clock::time_point deadline = Clock::now() + kLastWait;
        for (Running& r : running_) {
            r.child.leave(deadline);
            outcomes_[r.task].interrupted = true;
            std::error_code ignored;
            fs::remove(tasks_[r.task].job.output, ignored);
        }
        running_.clear();
        for (; next_ < tasks_.size(); ++next_) outcomes_[next_].interrupted = true;
    }

    const std::vector<PageTask>& tasks_;
    const PageLimits& limits_;
    const std::function<void(std::size_t)>& on_done_;
    std::vector<PageOutcome> outcomes_;
    std::size_t next_ = 0;
    bake::SignalScope signals_;
    std::list<Running> running_;  // last: its workers are killed first
};
}  // namespace

std::vector<PageOutcome> run_pages(const std::vector<PageTask>& tasks, const PageLimits& limits,
                                   const std::function<void(std::size_t)>& on_done) {
    return Runner(tasks, limits, on_done).run();
}

}  // namespace dgm::report
