// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/sandbox.h
// Takes away from a process that parses a stranger's bytes whatever parsing does not need.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace dgm::bake {

struct Sandbox {
    std::vector<std::filesystem::path> readable;  ///< files, and folders with all that is in them
    std::vector<std::filesystem::path> writable;  ///< folders in which files may be made, changed and removed
    std::uint32_t cpu_seconds = 60;               ///< of all threads together; 0: no limit
    std::uint64_t file_bytes = 0;                 ///< the most that any file may grow to
    std::uint32_t descriptors = 1024;             ///< the largest number of one, too
    bool starts_threads = false;
};

/// For a process that reads a mesh and what it may name: its folder and `readable`. It starts no threads and writes
/// nothing.
[[nodiscard]] Sandbox import_sandbox(const std::filesystem::path& mesh, std::vector<std::filesystem::path> readable);

/// For a worker that also computes with threads and writes beside each of `outputs`; empty ones count for nothing. Its
/// time is the parent's to limit.
[[nodiscard]] Sandbox worker_sandbox(const std::filesystem::path& mesh, std::vector<std::filesystem::path> readable,
                                     const std::vector<std::filesystem::path>& outputs);

/// From now on this process may use the files given, allocate, compute, and write to descriptors that it has. It opens
/// no other files, makes no sockets, processes or programs, signals none but itself, and gains no rights: no_new_privs,
/// Landlock, a list of allowed system calls (libseccomp), limits of processor time, processes, file sizes and
/// descriptors. Memory is the caller's to limit (limit_worker_memory()). A call that is refused fails with an error
/// (EPERM, EACCES); the limit of processor time ends the process, that of file sizes makes writing fail (EFBIG).
/// @return what this system cannot take away, a line each; empty if all of it is gone. Never throws for that reason.
/// @throws model::Error kSystemBusy if a part of it failed for the moment; std::bad_alloc if memory is short, after the
///         new handler. Where libseccomp does not come back for want of memory, the process sends kOutOfMemoryLine and
///         ends.
/// The process must have one thread. There is no way back.
[[nodiscard]] std::vector<std::string> enter_sandbox(const Sandbox& sandbox);

/// The protection that enter_sandbox() cannot give here, a line each; changes nothing.
[[nodiscard]] std::vector<std::string> sandbox_lacks();

}  // namespace dgm::bake
