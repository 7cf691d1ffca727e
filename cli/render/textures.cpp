// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/textures.cpp
#include "render/textures.h"

#include "model/shortage.h"

namespace dgm::render {

std::vector<formats::Image> read_textures(const model::TriMesh& mesh,
                                          const std::function<void(const std::string&)>& warn) {
    std::vector<formats::Image> textures;
    for (const model::Material& material : mesh.materials) {
        textures.emplace_back();
        if (material.diffuse_map.empty()) continue;
        try {
            textures.back() = formats::read_image(material.diffuse_map);
        } catch (const model::Error& error) {
            if (model::may_pass(error)) throw;
            warn("texture " + material.diffuse_map.path.string() + " is left out: " + error.what());
        }
    }
    return textures;
}

}  // namespace dgm::render
