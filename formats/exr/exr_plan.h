// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_plan.h
// Which layer lies in which file, part and channels: shared by writer and reader, so that they cannot disagree.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "exr/exr_files.h"
#include "exr/exr_layout.h"
#include "model/map_set.h"

namespace dgm::formats {

/// Changes with any change of what plan_exr gives, or of the attributes. 1: files with words as channels.
inline constexpr int kExrLayoutVersion = 2;

/// A layer of a chart, by their numbers.
struct LayerNumber {
    std::size_t chart = 0, layer = 0;
};

struct PlannedLayer {
    LayerNumber number;
    LayerImage image;
};

struct PlannedPart {
    std::string name;  ///< empty where it is the only part of its file
    std::uint32_t width = 1, height = 1;
    std::vector<PlannedLayer> layers;  ///< none: a part with the channel kEmptyChannel alone
};

/// All parts of a file have one size: programs that show several parts crash or refuse otherwise.
struct PlannedFile {
    std::string name;  ///< as exr_side_path takes it; empty for the map's own file
    std::vector<PlannedPart> parts;
};

struct ExrPlan {
    std::vector<PlannedFile> files;   ///< the map's own first
    std::vector<LayerNumber> tables;  ///< whose bytes are header attributes of the map's own file
};

inline constexpr char kEmptyChannel[] = "empty.V";

/// Looks at names, types and shapes alone. Layers without elements are in no part.
/// @throws model::Error kBadLayerShape for a name that is no clean text or used twice, a grid or layer of impossible
///         size, or two layers that need the same channel or file
[[nodiscard]] ExrPlan plan_exr(const std::vector<model::Chart>& charts, ExrLayout layout);

}  // namespace dgm::formats
