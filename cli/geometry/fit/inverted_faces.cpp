// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/inverted_faces.cpp
#include "geometry/fit/inverted_faces.h"

#include <limits>
#include <utility>

namespace dgm::bake {

std::vector<std::uint32_t> InvertedFaces::faces(std::span<const char> among, bool nearly) {
    constexpr double kNever = std::numeric_limits<double>::quiet_NaN();  // equal to nothing
    judged_.resize(grid_.faces.size(), {{Vec3d{kNever, kNever, kNever}, Vec3d{}, Vec3d{}}, false, false});
    TriMesh surface;
    surface.positions = grid_.positions;
    std::vector<std::uint32_t> number, out;
    std::vector<char> either_side, close_either_side;
    for (std::uint32_t f = 0; f < grid_.faces.size(); ++f)
        if (const auto q = grid_.corners(f); (among.empty() || among[f]) && q != judged_[f].corners) {
            surface.faces.push_back(grid_.faces[f]);
            number.push_back(f);
            if (!grid_.either_side.empty()) either_side.push_back(grid_.either_side[f]);
            judged_[f] = {q, false, false};
        }
    const std::vector<std::uint32_t> found =
        find_turned_faces(source_index(), surface, kSafeTie, kSafeCosine, either_side);
    std::vector<Face> close;
    for (const std::uint32_t k : found) {
        judged_[number[k]].nearly = true;
        close.push_back(surface.faces[k]);
        if (!either_side.empty()) close_either_side.push_back(either_side[k]);
    }
    surface.faces = std::move(close);
    for (const std::uint32_t k : find_turned_faces(source_index(), surface, kTurnedTie, 0, close_either_side))
        judged_[number[found[k]]].inverted = true;
    for (const std::uint32_t f : number)
        if (is_flat(judged_[f].corners)) judged_[f].nearly = true;
    for (std::uint32_t f = 0; f < grid_.faces.size(); ++f)
        if ((among.empty() || among[f]) && (nearly ? judged_[f].nearly : judged_[f].inverted)) out.push_back(f);
    return out;
}

std::vector<std::uint32_t> InvertedFaces::doubtful_faces(const Matches& matches, double upright) {
    std::vector<char> doubtful(grid_.faces.size());
    for (std::size_t f = 0; f < doubtful.size(); ++f)
        doubtful[f] = !(dot(grid_.normals[f], source_.normals[matches.middles[f].hit.face]) > upright);
    return faces(doubtful);
}

}  // namespace dgm::bake
