// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/hdf5_apart.h
// The HDF5 part of .dgm files is read in disposable processes: HDF5 1.10 crashes on structures that somebody has made
// to that end, and hashes without a key do not keep anybody from making them.
#pragma once
#include <mutex>

#include "dgm/dgm_reader.h"
#include "process/fork_server.h"

namespace dgm::bake {

/// While it lives, formats::read_dgm() and its like read every file's HDF5 part in a process of its own, which can read
/// that file and do nothing else (sandbox.h). If it dies, the file has a finding and the program goes on.
/// Create it as a ForkServer. One at a time.
class Hdf5Apart {
 public:
    /// @throws model::Error kSystemBusy if the system has no process, memory or descriptor left
    Hdf5Apart();
    Hdf5Apart(const Hdf5Apart&) = delete;
    Hdf5Apart& operator=(const Hdf5Apart&) = delete;
    ~Hdf5Apart();

    /// Thread-safe; one file at a time. @throws model::Error kWorkerKilled if the copied process is gone
    [[nodiscard]] formats::Hdf5Part read(const std::filesystem::path& path, const formats::DgmReadLimits& limits);

 private:
    std::mutex one_file_;
    ForkServer server_;
};

/// The message of the disposable process, as bytes.
[[nodiscard]] std::string encode_hdf5_part(const formats::Hdf5Part& part);
/// nullopt for bytes that are none.
[[nodiscard]] std::optional<formats::Hdf5Part> decode_hdf5_part(std::string_view bytes);

}  // namespace dgm::bake
