// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/worker_protocol.h
// Messages between the parent and a worker: one JSON job in, JSON lines out. The worker reads strangers' meshes with
// strangers' libraries, so the parent believes nothing it sends: sizes are bounded, types are checked.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "baking/bake_options.h"
#include "baking/bake_report.h"
#include "model/error.h"

namespace dgm::bake {

/// Longest message line the parent takes; a report with 10 000 charts has about 10 MiB.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{64} << 20;

struct WorkerJob {
    std::filesystem::path source;
    BakeOptions options;
    std::filesystem::path dgm, exr;              ///< temporary files to write; empty: not asked for
    std::vector<std::filesystem::path> exports;  ///< meshes to write beside them, each into a folder of its own
    bool wants_inputs = false;                   ///< the result says which files were read
    std::uint64_t memory_bytes = 0;  ///< address space the worker may take beside its own program; 0: no limit
    std::uint32_t threads = 1;
    std::uint32_t cpu_seconds = 0;  ///< processor time of all threads, should the parent's clock fail; 0: no limit
};

struct ProgressMessage {
    std::string stage;
    double share = 0;  ///< of the stage, 0..1
};
/// A warning or note about the mesh, in plain language, as soon as it is known.
struct NoticeMessage {
    Notice notice;
};
struct ResultMessage {
    BakeReport report;                          ///< the files are written, read back and equal
    std::vector<std::filesystem::path> inputs;  ///< every file that the bake reads; if asked for
};
struct ErrorMessage {
    model::Error error;
};
/// An allocation failed (kOutOfMemoryLine, worker_io.h).
struct OutOfMemoryMessage {};

using WorkerMessage = std::variant<ProgressMessage, NoticeMessage, ResultMessage, ErrorMessage, OutOfMemoryMessage>;

/// Paths travel with every byte outside printable ASCII as %XX: file names need not be UTF-8, JSON must be.
/// decode_path throws model::Error kInternal for a % without two digits.
[[nodiscard]] std::string encode_path(const std::filesystem::path& path);
[[nodiscard]] std::filesystem::path decode_path(std::string_view text);

/// Limits that every job states.
struct JobLimits {
    std::uint64_t memory_bytes = 0;
    std::uint32_t threads = 1;
};
/// @throws model::Error kInternal if `text` does not say them
[[nodiscard]] JobLimits decode_limits(std::string_view text);
/// True for a job with the key "page": a page of the report instead of a bake.
[[nodiscard]] bool is_page_job(std::string_view text);

[[nodiscard]] std::string encode(const WorkerJob& job);
/// @throws model::Error kInternal if `text` is not a job
[[nodiscard]] WorkerJob decode_job(std::string_view text);

/// One line, with its newline.
[[nodiscard]] std::string encode(const WorkerMessage& message);
/// nullopt for anything that is not a well-formed message. Unknown error codes come back as kInternal.
[[nodiscard]] std::optional<WorkerMessage> decode_message(std::string_view line);

}  // namespace dgm::bake
