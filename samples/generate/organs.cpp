// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/organs.cpp
#include "organs.h"

namespace dgm::samples {

MaterialText organ_material(const Textured& organ) {
    return {organ.name, "colour.png", "bump.png", organ.bump_scale, 60};
}

std::filesystem::path write_organ(const Textured& organ, const std::filesystem::path& folder) {
    write_colour_png(organ.picture, folder / "colour.png");
    write_relief_png(organ.picture, folder / "bump.png");
    const std::filesystem::path obj = folder / (organ.name + ".obj");
    write_obj({{organ.name, organ.mesh}}, organ_material(organ), obj);
    return obj;
}

}  // namespace dgm::samples
