// SPDX-License-Identifier: GPL-3.0-or-later
// samples/support/soft_body.h
// Steps with libdgm that all samples share: open a map, make its shape touchable, hand out vertices.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <dgm/asset.h>
#include <dgm/reconstruct.h>
#include <dgm/state.h>
#include <dgm/tick.h>

#include "image/image.h"
#include "model/codes.h"
#include "path/tool_path.h"

namespace dgm::samples {
using formats::Knot;
using formats::ToolPath;
using formats::TouchSize;

/// The value, or a model::Error that says what failed and why.
template <class T>
T take(Result<T> result, const std::string& what) {
    if (!result)
        throw model::Error(model::codes::kBadValue,
                           std::string(error_name(result.error().code)) + ": " + result.error().message, what);
    return std::move(result).value();
}

struct Vertex {  // as a vertex buffer would hold it
    float position[3], normal[3], uv[2];
};

/// The first chart of a map as a thing to press.
class SoftBody {
 public:
    /// @throws model::Error if the file is no map, or the map has values that cannot be
    explicit SoftBody(const std::string& file, const StateOptions& options = {});

    [[nodiscard]] State& state() { return state_; }
    [[nodiscard]] Chart chart() const { return asset_.chart(0).value(); }
    /// From the mesh's frame to the state's, which may have its origin elsewhere.
    [[nodiscard]] Vec3 local(Vec3 source) const { return source - origin_; }
    /// Inputs of recorded tools for tick(). Valid until the next call.
    [[nodiscard]] std::span<const ToolInput> inputs(std::span<const Knot> tools);
    /// The present shape in the mesh's frame; `triangles` never change.
    [[nodiscard]] std::vector<Vertex> vertices() const;
    [[nodiscard]] std::span<const std::uint32_t> triangles() const { return triangles_; }

 private:
    Asset asset_;
    State state_;
    Vec3 origin_;
    std::vector<std::uint32_t> triangles_;
    std::vector<ToolInput> inputs_;
};

/// A path that moves one thing: a ball, a table. @throws model::Error kUsage for a path of several tools, and as
/// ToolPath
[[nodiscard]] ToolPath path_of_one_tool(const std::string& file);

/// The layer `texture` of the first chart of a map, of which nothing else is read: a picture for any state of that
/// chart, to be put on and taken off while it moves.
[[nodiscard]] formats::Image texture_of(const std::string& file);

}  // namespace dgm::samples
