// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/cell_rectangle.cpp
#include "geometry/parameterize/cell_rectangle.h"

#include <cmath>
#include <utility>

namespace dgm::bake {

CellRectangle::CellRectangle(const DiskView& disk) : disk_(disk), width_(std::sqrt(disk.aspect)), view_(disk) {
    view_.aspect = 1;
    if (width_ == 1) return;
    border_ = from_square({disk.border_uv.begin(), disk.border_uv.end()});
    view_.border_uv = border_;
}

std::vector<Vec2d> CellRectangle::from_square(std::vector<Vec2d> uv) const {
    if (width_ != 1)
        for (Vec2d& p : uv) p = {p.x * width_, p.y / width_};
    return uv;
}

std::vector<Vec2d> CellRectangle::to_square(std::vector<Vec2d> uv) const {
    if (width_ == 1) return uv;
    for (Vec2d& p : uv) p = {p.x / width_, p.y * width_};
    for (std::size_t k = 0; k < disk_.border.size(); ++k) uv[disk_.border[k]] = disk_.border_uv[k];
    return uv;
}

}  // namespace dgm::bake
