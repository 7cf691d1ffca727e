// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/bake_points.cpp
// Lists the bakes of a sweep.
#include <algorithm>

#include "baking/methods.h"
#include "bench/bake_sweep.h"

namespace dgm::bench {
namespace {

constexpr std::uint32_t kPaperSide = 81;

void add(std::vector<BakePoint>& points, const BakePoint& point) {
    if (std::find(points.begin(), points.end(), point) == points.end()) points.push_back(point);
}

void add_all_combinations(std::vector<BakePoint>& points, const BakeSweepOptions& o) {
    for (const std::string& method : o.methods)
        for (const std::uint32_t side : o.sizes)
            for (const std::string& precision : o.precisions)
                for (const std::string& fit : o.fits)
                    for (const std::string& layers : o.layers) add(points, {method, side, precision, fit, layers});
}

/// Each value of one choice with the defaults of the others, at `sides`.
template <class Values, class Member>
void vary(std::vector<BakePoint>& points, const Values& values, Member member,
          const std::vector<std::uint32_t>& sides) {
    for (const std::uint32_t side : sides)
        for (const auto& value : values) {
            BakePoint point = default_point();
            point.side = side;
            point.*member = value;
            add(points, point);
        }
}

}  // namespace

BakePoint default_point() {
    const bake::BakeOptions defaults;
    return {std::string(bake::name_of(defaults.method)), defaults.size.rows, "f32", "l2", "all"};
}

BakePoint paper_point() {
    return {"auto", kPaperSide, "f32", "sample", "all"};
}

std::vector<BakePoint> plan_points(const BakeSweepOptions& o) {
    std::vector<BakePoint> points;
    if (o.full) {
        add_all_combinations(points, o);
    } else {
        const std::vector<std::string> centre{default_point().method};
        vary(points, centre, &BakePoint::method, o.sizes);
        // The second and the third: these two show the worth of a choice at 257 a side, for a quarter of the time.
        const std::size_t first = o.sizes.size() > 1 ? 1 : 0, end = std::min<std::size_t>(first + 2, o.sizes.size());
        std::vector<std::uint32_t> some = o.compared;
        if (some.empty())
            some.assign(o.sizes.begin() + static_cast<std::ptrdiff_t>(first),
                        o.sizes.begin() + static_cast<std::ptrdiff_t>(end));
        vary(points, o.methods, &BakePoint::method, some);
        vary(points, o.fits, &BakePoint::fit, some);
        vary(points, o.precisions, &BakePoint::precision, some);
        vary(points, o.layers, &BakePoint::layers, {some.front()});
    }
    add(points, paper_point());
    return points;
}

unsigned repetitions_of(const BakePoint& point, unsigned asked) {
    return point.side > 600 ? 1 : point.side > 300 ? std::min(asked, 3U) : asked;
}

double work_of(const BakePoint& point, unsigned repetitions) {
    const double samples = static_cast<double>(point.side) * point.side;
    return repetitions * (1.2 + samples * (point.fit == "best" ? 8e-5 : point.fit == "sample" ? 1e-5 : 4e-5));
}

}  // namespace dgm::bench
