// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/level_of_detail.cpp
#include "export/level_of_detail.h"

#include <dgm/asset.h>
#include <dgm/reconstruct.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "dgm/dgm_writer.h"
#include "model/codes.h"

namespace dgm::exporter {
namespace {
template <class T>
T taken(Result<T> result) {
    if (!result)
        throw model::Error(model::codes::kBadValue,
                           std::string(error_name(result.error().code)) + ": " + result.error().message);
    return std::move(result).value();
}

/// The layers that make triangles, and no other.
model::MapSet shape_of(const model::MapSet& maps) {
    model::MapSet out;
    out.generator = maps.generator;
    out.report_json = "{}";
    for (const model::Chart& chart : maps.charts) {
        model::Chart& kept = out.charts.emplace_back(chart);
        std::erase_if(kept.layers, [](const model::Layer& layer) {
            constexpr std::array kShape{"geometry",  "seams",           "diagonals",   "mask",
                                        "border_uv", "border_geometry", "border_faces"};
            return std::find(kShape.begin(), kShape.end(), layer.name) == kShape.end();
        });
    }
    return out;
}
}  // namespace

std::vector<std::vector<model::Face>> faces_at_stride(const model::MapSet& maps, std::uint32_t stride,
                                                      const std::filesystem::path& scratch) {
    formats::write_dgm(shape_of(maps), scratch);
    const Asset asset = taken(Asset::open(scratch.c_str()));
    const ReconstructOptions options{.lod_stride = stride};
    std::vector<std::vector<model::Face>> out;
    for (std::uint32_t k = 0; k < asset.chart_count(); ++k) {
        const Chart chart = taken(asset.chart(k));
        std::vector<std::uint32_t> corners(taken(mesh_counts(chart, options)).indices);
        static_cast<void>(taken(reconstruct(chart, {}, corners, options)));
        std::vector<model::Face> faces(corners.size() / 3);
        for (std::size_t c = 0; c < corners.size(); ++c) faces[c / 3][c % 3] = corners[c];
        out.push_back(std::move(faces));
    }
    return out;
}

}  // namespace dgm::exporter
