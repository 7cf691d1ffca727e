// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/page_runner.h
// Makes pages in worker processes, several at a time.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "model/error.h"
#include "report/page_job.h"

namespace dgm::report {

struct PageTask {
    PageJob job;
    std::filesystem::path final_path;  ///< where the page goes once it is whole
};

struct PageLimits {
    unsigned jobs = 1;                                    ///< workers at a time, >= 1
    double time_limit_seconds = 600;                      ///< wall clock of one page
    std::uint64_t memory_bytes = std::uint64_t{8} << 30;  ///< address space of one worker; 0: no limit
};

struct PageOutcome {
    std::optional<model::Error> error;  ///< nothing: the page is in place
    bool interrupted = false;           ///< stopped by a signal; there is no error then, and no new page
};

/// One outcome a task. A page that cannot be made leaves what was there. On SIGINT, SIGTERM or SIGHUP the workers are
/// killed and the rest is interrupted. No temporary file is left. `on_done` is told after each page.
[[nodiscard]] std::vector<PageOutcome> run_pages(const std::vector<PageTask>& tasks, const PageLimits& limits,
                                                 const std::function<void(std::size_t task)>& on_done);

}  // namespace dgm::report
