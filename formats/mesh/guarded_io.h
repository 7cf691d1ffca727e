// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/guarded_io.h
// The files that assimp opens: only where a mesh may name some, and a read that fails is no end of a file.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include <assimp/DefaultIOSystem.h>

#include "mesh/asset_folders.h"
#include "model/error.h"

namespace dgm::formats {

/// What an importer asked for.
struct OpenedFiles {
    std::vector<std::filesystem::path> opened, refused;
    std::optional<model::Error> trouble;  ///< the first open or read that failed, but for files that are not there
};

/// Opens the mesh and the further files that an importer asks for (the buffers of a glTF, say), for reading, if they
/// lie where a mesh may name files.
class GuardedIo : public Assimp::DefaultIOSystem {
 public:
    /// @param files  must outlive the object and what it opens
    GuardedIo(const std::filesystem::path& mesh_file, std::span<const std::filesystem::path> asset_roots,
              std::uint64_t max_file_bytes, OpenedFiles& files)
        : mesh_file_(mesh_file.string()),
          folders_(mesh_file, asset_roots),
          max_file_bytes_(max_file_bytes),
          files_(files) {}

    bool Exists(const char* file) const override;
    Assimp::IOStream* Open(const char* file, const char* mode) override;
    void Close(Assimp::IOStream* stream) override;

 private:
    /// True for a file that is not there as well, unless its name leads elsewhere.
    [[nodiscard]] bool may_open(const std::filesystem::path& file) const;

    std::filesystem::path mesh_file_;
    AssetFolders folders_;
    std::uint64_t max_file_bytes_;
    OpenedFiles& files_;
};

}  // namespace dgm::formats
