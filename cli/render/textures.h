// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/textures.h
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "image/image.h"
#include "model/tri_mesh.h"

namespace dgm::render {

/// The diffuse maps of a mesh's materials, one a material; an empty image where there is none. One that cannot be read
/// is left out and reported to `warn`. @throws model::Error if the system failed for the moment (model::may_pass)
[[nodiscard]] std::vector<formats::Image> read_textures(const model::TriMesh& mesh,
                                                        const std::function<void(const std::string&)>& warn);

}  // namespace dgm::render
