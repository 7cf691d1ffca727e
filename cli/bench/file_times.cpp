// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/file_times.cpp
#include "bench/file_times.h"

#include <dgm/asset.h>
#include <dgm/reconstruct.h>

#include <array>
#include <string_view>
#include <vector>

#include "bench/repeat.h"
#include "bench/runtime_error.h"

namespace dgm::bench {
namespace {

Asset open(const std::filesystem::path& path, bool verify) {
    OpenOptions options;
    options.verify_hashes = verify;
    return take(Asset::open(path.c_str(), options));
}

bool is_geometry(std::string_view layer) {
    constexpr std::array kOthers{"normal", "texture",     "bump",    "collision",
                                 "cover",  "deformation", "contact", "border_normal"};
    for (const char* other : kOthers)
        if (layer == other) return false;
    return true;
}

struct Buffers {
    std::vector<float> vertices;
    std::vector<std::uint32_t> indices;
};

}  // namespace

FileTimes measure_file(const std::filesystem::path& dgm) {
    FileTimes out;
    out.bytes = std::filesystem::file_size(dgm);
    out.load_seconds = time_of_call([&] { (void)open(dgm, true); });
    const Asset asset = open(dgm, false);
    std::vector<Buffers> buffers(asset.chart_count());
    bool normals = true;
    for (std::uint32_t k = 0; k < asset.chart_count(); ++k) {
        const Chart chart = take(asset.chart(k));
        const MeshCounts counts = take(mesh_counts(chart));
        buffers[k].vertices.resize(std::size_t{6} * counts.vertices);
        buffers[k].indices.resize(counts.indices);
        out.triangles += counts.indices / 3;
        normals = normals && chart.find("normal");
        for (std::uint32_t l = 0; l < chart.layer_count(); ++l) {
            const LayerView layer = take(chart.layer(l));
            if (is_geometry(layer.name)) out.geometry_bytes += layer.bytes;
        }
    }
    out.reconstruct_seconds = time_of_call([&] {
        for (std::uint32_t k = 0; k < asset.chart_count(); ++k) {
            VertexTarget target;
            target.memory = std::as_writable_bytes(std::span(buffers[k].vertices));
            target.stride = 6 * sizeof(float);
            if (normals) target.normal_offset = 3 * sizeof(float);
            (void)take(reconstruct(take(asset.chart(k)), target, buffers[k].indices));
        }
    });
    return out;
}

}  // namespace dgm::bench
