// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/worker.h
// The disposable process that bakes one asset (docs/design.md section 2.1). Importers and geometry libraries may crash,
// hang or eat memory in it, and that costs one asset.
#pragma once
#include <filesystem>
#include <functional>
#include <string_view>

#include "baking/pipeline.h"
#include "process/worker_io.h"

namespace dgm::bake {

/// bake_asset, or what a test puts in its place.
using BakeFunction =
    std::function<BakeResult(const std::filesystem::path&, const BakeOptions&, const model::Progress&)>;

/// Makes one page of a report from a job that is_page_job(), and writes it to the file that the job names.
using PageFunction = std::function<void(std::string_view job)>;

/// Reads a job from descriptor 0. A page job goes to `page`. For any other it bakes, writes the files under the
/// temporary names it was given, reads them back and compares, and sends progress and the outcome to descriptor 3
/// (worker_protocol.h). Limits its own memory first. Publishes nothing and removes nothing: the parent does, which is
/// still there when this process is not.
/// @return the process's exit code: 0 if an outcome was sent, success or not
[[nodiscard]] int run_worker(const BakeFunction& bake, const PageFunction& page = {});

struct OutputCheck {
    std::filesystem::path source;
    std::vector<std::filesystem::path> outputs;
    BakeOptions options;
    std::uint64_t memory_bytes = 0;  ///< as of a bake
    bool wants_inputs = false;
};

/// For a copy of this process (ChildProcess): sends a result with the stored report if the outputs are up to date
/// (up_to_date.h), or nothing. Source, textures and outputs may be anybody's: it limits its memory and enters the
/// sandbox first.
void send_if_up_to_date(const OutputCheck& check);

}  // namespace dgm::bake
