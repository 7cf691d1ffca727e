// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/memory_budget.h
// How many assets fit into memory at a time: a batch that swaps takes longer than one that waits.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>

#include "baking/bake_options.h"
#include "model/error.h"

namespace dgm::bake {

/// About what a worker takes at its peak, in bytes, from the size of the mesh file and the largest grid that the
/// options allow; rather too much than too little. 0 where the file cannot be looked at.
[[nodiscard]] std::uint64_t estimate_peak(const std::filesystem::path& mesh_file, const BakeOptions& options);

/// Why a worker that may take `memory_bytes` cannot bake the requested grid: it takes more, whatever the mesh. Names
/// the largest grid that fits. nullopt where it may fit, where the grid is searched, and for `memory_bytes` 0, which
/// is no limit.
[[nodiscard]] std::optional<model::Error> refuse_size(const BakeOptions& options, std::uint64_t memory_bytes);

/// Memory that this process and its children may still take without swapping: the system's available memory, or what
/// the control groups it is in have left, if that is less (a container, a Slurm job). 0 if the system does not tell.
[[nodiscard]] std::uint64_t available_memory();

/// Memory that a process holds now; 0 if it is gone.
[[nodiscard]] std::uint64_t resident_memory(pid_t process);

}  // namespace dgm::bake
