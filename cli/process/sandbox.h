// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/sandbox.h
// Takes away from a process that parses a stranger's bytes whatever parsing does not need.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace dgm::bake {

struct SandboxLimits {
    std::uint64_t memory_bytes = std::uint64_t{2} << 30;  ///< address space beside what the program has now
    std::uint32_t cpu_seconds = 60;
    std::uint32_t descriptors = 64;  ///< the largest number of one, too
};

/// From now on this process may read the files given (of them, folders whole), allocate, compute, and write to
/// descriptors that it has. It opens nothing for writing, makes no files, sockets, processes or programs, signals none
/// but itself, and gains no rights: no_new_privs, Landlock, a list of allowed system calls (libseccomp), limits of
/// processor time, memory and descriptors. All that is refused fails with an error (EPERM, EACCES), the limit of
/// processor time apart, which ends the process.
/// @return what this system cannot take away, a line each; empty if all of it is gone. Never throws for that reason.
/// The process must have one thread. There is no way back.
[[nodiscard]] std::vector<std::string> enter_sandbox(std::span<const std::filesystem::path> readable,
                                                     const SandboxLimits& limits = {});

}  // namespace dgm::bake
