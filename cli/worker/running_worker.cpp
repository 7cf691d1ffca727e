// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/running_worker.cpp
#include "worker/running_worker.h"

#include <fmt/format.h>
#include <string.h>

#include "model/codes.h"
#include "worker/worker_protocol.h"

namespace dgm::bake {

namespace codes = model::codes;

bool RunningWorker::advance(double time_limit_seconds, const std::function<bool(const std::string& line)>& take) {
    child.read_errors();
    std::vector<std::string> lines;
    bool sane = child.read_messages(lines, kMaxMessageBytes);
    for (const std::string& line : lines) sane = sane && take(line);
    if (!sane)
        verdict = model::Error(codes::kWorkerCrashed, "the worker sent something that is not a message");
    else if (Clock::now() - started > std::chrono::duration<double>(time_limit_seconds))
        verdict = model::Error(codes::kWorkerTimeout, fmt::format("it was not done after {} s", time_limit_seconds));
    if (verdict) {
        child.kill();
        return true;
    }
    if (child.messages() >= 0 || child.errors() >= 0) return false;
    const std::optional<ChildEnd> ended = child.poll_end();
    if (ended) end = *ended;
    return ended.has_value();
}

model::Error RunningWorker::crash(std::string_view missing) const {
    if (end.signal != 0)
        return {codes::kWorkerCrashed,
                fmt::format("the worker process was ended by signal {} ({})", end.signal, strsignal(end.signal))};
    if (end.exit_code == kCannotRunAgain && child.error_text().find("/proc/self/exe") != std::string::npos)
        return model::Error(codes::kReadFailed, "the program cannot be run again for a worker", "/proc/self/exe")
            .with_hint("mount /proc");
    return {codes::kWorkerCrashed,
            fmt::format("the worker process ended with exit code {} and no {}", end.exit_code, missing)};
}

}  // namespace dgm::bake
