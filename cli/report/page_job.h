// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/page_job.h
// A page as a job for a worker process: importers may crash on a stranger's mesh a second time.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "report/asset_page.h"

namespace dgm::report {

struct PageJob {
    AssetPage page;
    std::filesystem::path output;  ///< temporary file to write
    std::uint64_t memory_bytes = 0;
    std::uint32_t threads = 1;
};

/// A job as bake::is_page_job.
[[nodiscard]] std::string encode(const PageJob& job);
/// @throws model::Error kInternal if `text` is not such a job
[[nodiscard]] PageJob decode_page_job(std::string_view text);

/// Decodes the job, makes the page and writes it: bake::PageFunction.
/// @throws model::Error as asset_page; kWriteFailed
void make_page(std::string_view job);

}  // namespace dgm::report
