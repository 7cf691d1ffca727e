// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/dgm_reader.h
// .dgm to MapSet through HDF5, and the checks of its container.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "model/error.h"
#include "model/map_set.h"

namespace dgm::formats {

enum class Severity { kError, kWarning, kNote };

/// One thing that is wrong with a file.
struct Finding {
    const model::Code* code = nullptr;
    Severity severity = Severity::kError;
    std::string message;  ///< one line, with figures
    std::string place;    ///< HDF5 path ("/charts/0/normal[3][4]"), "user block", or FILE:LINE of a mesh
    std::optional<double> measured, limit;
};
using FileFindings = std::vector<Finding>;

struct DgmReadLimits {
    std::uint64_t max_layer_bytes = std::uint64_t{8} << 30;
    std::uint64_t max_total_bytes = std::uint64_t{64} << 30;  ///< of all layers, where they are kept
    std::uint32_t max_charts = 1u << 20;
    std::uint32_t max_layers = 1u << 22;
};

/// The part of a file that HDF5 alone knows: texts and attributes, and where its structures differ from the index.
struct Hdf5Part {
    FileFindings findings;
    std::string generator, source_name, report_json;
    /// Those of each layer but offset and scale, chart after chart, in the index's order. Empty if there are findings.
    std::vector<std::map<std::string, model::AttributeValue>> attributes;
};

/// Reads it by HDF5, in this process. HDF5 1.10 can crash on structures that somebody has made to that end: whoever
/// reads files of strangers does it in a process that may die.
/// @throws model::Error kFileMissing, kReadFailed
[[nodiscard]] Hdf5Part read_hdf5_part(const std::filesystem::path& path, const DgmReadLimits& limits = {});

/// Makes HDF5's own tables now, so that a copy of this process (fork) has them already.
void prepare_hdf5();

/// Has the functions below take every file's HDF5 part from `reader`; an empty one stands for read_hdf5_part(). Nothing
/// that it returns is believed: counts are checked against the index. Call it before any thread reads.
using Hdf5Reader = std::function<Hdf5Part(const std::filesystem::path&, const DgmReadLimits&)>;
void set_hdf5_reader(Hdf5Reader reader);

/// Reads a whole file and checks it on the way: header, index, hashes, index against H5Dget_offset, types, shapes,
/// names. Sizes from the file are trusted only after they fit the file's real length. External links, external storage
/// and filters are refused, not followed.
/// @throws model::Error with the code of the first finding of check_container; kFileMissing, kReadFailed
/// Thread-safe; the part that HDF5 reads is done by one thread at a time.
[[nodiscard]] model::MapSet read_dgm(const std::filesystem::path& path, const DgmReadLimits& limits = {});

/// The same without the layers, whose bytes are neither read nor checked: where the file comes from.
[[nodiscard]] model::MapSet read_dgm_head(const std::filesystem::path& path, const DgmReadLimits& limits = {});

/// Everything that is wrong with the container, at most 100 findings; empty for a good file. Checks structure and
/// hashes, not the meaning of the values. Layers are read in pieces of a MiB.
/// @throws model::Error kFileMissing, kReadFailed
[[nodiscard]] FileFindings check_container(const std::filesystem::path& path, const DgmReadLimits& limits = {});

/// Both at once, reading each byte once. `maps` is whole if nothing was found; else its content is unspecified.
/// @throws model::Error kFileMissing, kReadFailed
[[nodiscard]] FileFindings read_and_check(const std::filesystem::path& path, model::MapSet& maps,
                                          const DgmReadLimits& limits = {});

/// A file whose layers somebody has changed in place, such as by h5py: the hashes do not fit any more.
struct ChangedDgm {
    model::MapSet maps;
    std::vector<std::vector<bool>> fits;  ///< of each chart: whether each layer's bytes fit their hash
    bool rest_fits = true;                ///< HDF5's own structures fit theirs: no attribute has changed
};

/// As read_dgm, but layers may differ from their hashes, and so may what lies between them. Header and index must fit,
/// and the datasets be where the index says.
/// @throws model::Error as read_dgm
[[nodiscard]] ChangedDgm read_changed_dgm(const std::filesystem::path& path, const DgmReadLimits& limits = {});

}  // namespace dgm::formats
