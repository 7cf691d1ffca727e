// SPDX-License-Identifier: GPL-3.0-or-later
// samples/support/soft_body.cpp
#include "support/soft_body.h"

#include <cstddef>

namespace dgm::samples {

SoftBody::SoftBody(const std::string& file, const StateOptions& options)
    : asset_(take(Asset::open(file.c_str()), file)),
      state_(take(State::create(take(asset_.chart(0), file), options), file)) {
    const auto offset = chart().offset();
    origin_ = {static_cast<float>(offset[0]), static_cast<float>(offset[1]), static_cast<float>(offset[2])};
    triangles_.resize(take(mesh_counts(state_), file).indices);
    static_cast<void>(take(reconstruct(state_, {}, triangles_), file));
}

std::span<const ToolInput> SoftBody::inputs(std::span<const Knot> tools) {
    inputs_.clear();
    for (const Knot& knot : tools)
        inputs_.push_back(
            {.tool = knot.tool, .kind = knot.kind, .position = local(knot.position), .engaged = knot.engaged});
    return inputs_;
}

std::vector<Vertex> SoftBody::vertices() const {
    std::vector<Vertex> out(state_.sample_count());
    static_cast<void>(take(reconstruct(state_,
                                       {.memory = std::as_writable_bytes(std::span(out)),
                                        .stride = sizeof(Vertex),
                                        .position_offset = offsetof(Vertex, position),
                                        .normal_offset = offsetof(Vertex, normal),
                                        .uv_offset = offsetof(Vertex, uv)},
                                       {}),
                           "vertices"));
    for (Vertex& v : out) {
        v.position[0] += origin_.x;
        v.position[1] += origin_.y;
        v.position[2] += origin_.z;
    }
    return out;
}

ToolPath path_of_one_tool(const std::string& file) {
    ToolPath path(file);
    if (path.tool_count() > 1)
        throw model::Error(model::codes::kUsage,
                           "the path has " + std::to_string(path.tool_count()) + " tools; here one thing moves", file);
    return path;
}

formats::Image texture_of(const std::string& file) {
    constexpr const char* kOnly[] = {"texture"};
    const Asset asset = take(Asset::open(file.c_str(), {.required_layers = kOnly, .layers = kOnly}), file);
    const LayerView layer = take(take(asset.chart(0), file).find("texture"), file);
    const auto texels = take(layer.as<std::uint8_t>(), file);
    formats::Image image{static_cast<std::uint32_t>(layer.shape[1]), static_cast<std::uint32_t>(layer.shape[0]), {}};
    image.pixels.resize(std::size_t{image.width} * image.height);
    for (std::size_t k = 0; k < image.pixels.size(); ++k)
        image.pixels[k] = {texels[4 * k], texels[4 * k + 1], texels[4 * k + 2], texels[4 * k + 3]};
    return image;
}

}  // namespace dgm::samples
