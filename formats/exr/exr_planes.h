// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_planes.h
// Numbers out of EXR files that a painter has saved: whatever channels of a map are there, whatever the file has lost
// of its description.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "exr/exr_reader.h"
#include "model/map_set.h"

namespace dgm::formats {

/// A channel of a file that stands for one number of each element group of a layer.
struct ExrPlane {
    std::size_t chart = 0, layer = 0;  ///< by their numbers in the map
    std::uint32_t component = 0;
    /// The number that a u32 is shown by, or a code of a texture; else the element's value.
    enum class Meaning { kValue, kCode, kLow16, kHigh16 } meaning = Meaning::kValue;
    bool is_half = false;  ///< the file rounds to binary16
    std::filesystem::path file;
    std::vector<float> values;  ///< one a group, in the layer's order
};

/// The channels of the map `charts` that are found in `path`, as write_exr names them, in either layout, and in the
/// files of layers beside it; `path` may be one of those. Attributes, hashes, names of parts and channels that are
/// missing are not asked for: what is not there was not edited.
/// @throws model::Error kFileMissing, kReadFailed, kExrUnreadable; kEditUnrelated if no channel of the map is there, or
///         one has another size than its layer
[[nodiscard]] std::vector<ExrPlane> read_exr_planes(const std::filesystem::path& path,
                                                    const std::vector<model::Chart>& charts,
                                                    const ExrReadLimits& limits = {});

/// A picture of one part, as plain maps are.
struct ExrPicture {
    std::uint32_t width = 0, height = 0, channels = 1;  ///< 1: the only channel, or Y; 3, 4: R G B (A)
    bool is_half = false;
    std::vector<float> pixels;  ///< row-major from the top, channels interleaved
};
/// @throws model::Error kFileMissing, kReadFailed, kExrUnreadable
[[nodiscard]] ExrPicture read_exr_picture(const std::filesystem::path& path, const ExrReadLimits& limits = {});

/// True if the file says that it holds a map of ours, or layers of one. Never throws; false for what is no EXR.
[[nodiscard]] bool has_exr_description(const std::filesystem::path& path) noexcept;

/// What the functions above do, by another way. May throw model::Error kExrUnreadable, has_description too.
struct ExrPlaneReader {
    std::function<std::vector<ExrPlane>(const std::filesystem::path& path, const std::vector<model::Chart>& charts,
                                        const ExrReadLimits& limits)>
        planes;
    std::function<ExrPicture(const std::filesystem::path& path, const ExrReadLimits& limits)> picture;
    std::function<bool(const std::filesystem::path& path)> has_description;
};
/// They in this process, whatever set_exr_plane_reader() says.
[[nodiscard]] const ExrPlaneReader& exr_plane_reader_here();
/// From now on they call `reader`; an empty one ends that. Not thread-safe.
void set_exr_plane_reader(ExrPlaneReader reader);

}  // namespace dgm::formats
