// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/worker_io.h
// Steps that all disposable processes share, whatever their work: worker.h, mesh_import.h.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "model/codes.h"

namespace dgm::bake {

/// Descriptors that a worker finds open: the job, and where its messages go. Its stdout is its stderr, so that a
/// library that prints cannot write into the messages.
inline constexpr int kJobDescriptor = 0, kMessageDescriptor = 3;

/// The message that an allocation failed. It is sent at once, without allocating, because a crash may follow.
inline constexpr std::string_view kOutOfMemoryLine = "{\"type\":\"out-of-memory\"}\n";

/// The code of a number that a worker has sent; nullptr for one that no code has.
[[nodiscard]] const model::Code* code_of(std::uint64_t number);

/// True if the arguments are those ChildProcess starts a worker with.
[[nodiscard]] bool is_worker(int argc, const char* const* argv);

/// False if the program was called with `--worker` by hand; says so on stderr.
[[nodiscard]] bool has_message_descriptor();
/// All of descriptor 0.
[[nodiscard]] std::string read_job_text();
/// Limits the address space to its present size plus `allowed` (0: no limit). From then on a failed allocation sends
/// kOutOfMemoryLine before it throws.
void limit_worker_memory(std::uint64_t allowed, std::uint32_t threads);
/// Writes all of it to descriptor 3. False if the parent is gone.
[[nodiscard]] bool send_message(std::string_view bytes);

}  // namespace dgm::bake
