// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/page_runner.cpp
#include "report/page_runner.h"

#include <iterator>
#include <list>
#include <string>
#include <utility>

#include "files/atomic_file.h"
#include "model/codes.h"
#include "process/signal_scope.h"
#include "worker/running_worker.h"
#include "worker/worker_protocol.h"

namespace dgm::report {
namespace {
namespace codes = model::codes;
namespace fs = std::filesystem;

struct Running : bake::RunningWorker {
    using RunningWorker::RunningWorker;
    std::size_t task = 0;
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
            signals_.wait(bake::children_of(running_), false);
            for (auto it = running_.begin(); it != running_.end();)
                it = advance(*it) ? running_.erase(it) : std::next(it);
        }
        if (signals_.stop_requested()) interrupt();
        return std::move(outcomes_);
    }

 private:
    void start(std::size_t k) {
        try {
            running_.emplace_back(encode(tasks_[k].job)).task = k;
        } catch (const model::Error& error) { finish(k, error); }
    }

    /// True if the worker is through.
    bool advance(Running& r) {
        const bool through = r.advance(limits_.time_limit_seconds, [&](const std::string& line) {
            take(r, line);
            return true;
        });
        if (through) finish(r.task, error_of(r));
        return through;
    }

    static void take(Running& r, const std::string& line) {
        const std::optional<bake::WorkerMessage> message = bake::decode_message(line);
        if (!message) return;
        if (const auto* error = std::get_if<bake::ErrorMessage>(&*message)) r.said = error->error;
        if (std::holds_alternative<bake::OutOfMemoryMessage>(*message) && !r.said)
            r.said = model::Error(codes::kWorkerMemory, "it needs more memory than it may take");
        if (std::holds_alternative<bake::ResultMessage>(*message)) r.done = true;
    }

    static std::optional<model::Error> error_of(const Running& r) {
        if (r.verdict) return r.verdict;
        if (r.said) return r.said;
        if (r.done && r.end.exit_code == 0 && r.end.signal == 0) return std::nullopt;
        return r.crash("page");
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
        bake::kill_all(running_);
        for (const Running& r : running_) {
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
