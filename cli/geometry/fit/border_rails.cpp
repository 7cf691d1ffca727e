// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/border_rails.cpp
#include "geometry/fit/border_rails.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr double kCornerTurn = 0.52;  // 30 degrees: a corner in any case
constexpr double kLeastTurn = 0.10;   // 6 degrees: one if its own two edges make most of the turn
constexpr double kOwnShare = 0.6;
constexpr double kCornerStep = 0.75;  // of a mean chord: between two corners
constexpr double kOnCorner = 1e-6;    // of a mean chord: a stop this near to a corner is on it
constexpr double kPointStep = 0.25;   // of a mean chord: longest way between two points of a loop
constexpr double kOnBorder = 1e-9;    // squared barycentric distance; the normalised frame is 1 across
constexpr std::size_t kMostPoints = 4'000'000;

/// The corner nearer than `within` to t, or t. Corners are sorted and lie much farther from each other.
double on_corner_near(const std::vector<double>& corners, double t, double within) {
    const auto next = std::lower_bound(corners.begin(), corners.end(), t);
    if (next != corners.end() && *next - t < within) return *next;
    if (next != corners.begin() && t - *std::prev(next) < within) return *std::prev(next);
    return t;
}

}  // namespace

BorderRails::BorderRails(const SampledChart& chart, const LinkedSurface& source, const WeldedGrid& grid)
    : source_(source), grid_(grid) {
    freedom_.assign(grid.on_border.size(), Freedom::kFree);
    directions_.assign(grid.on_border.size(), Vec3d{});
    for (std::size_t c = 0; c < freedom_.size(); ++c)
        if (grid.on_border[c]) freedom_[c] = Freedom::kHeld;
    if (std::find(grid.on_border.begin(), grid.on_border.end(), 1) == grid.on_border.end()) return;
    if (!grid.reversed.empty()) return;  // a border without a direction: its samples stay where they are
    find_loops();
    find_stops(chart);
    order_stops();
    find_corners();
    first_places_ = places_;
    refresh();
}

void BorderRails::find_loops() {
    const std::size_t count = 3 * source_.faces.size();
    std::vector<char> seen(count, 0);
    for (std::uint32_t first = 0; first < count; ++first) {
        if (seen[first] || source_.neighbours[first / 3][first % 3] != kNone) continue;
        Loop& loop = loops_.emplace_back();
        double length_so_far = 0;
        for (std::uint32_t h = first; !seen[h];) {
            seen[h] = 1;
            loop.half_edges.push_back(h);
            loop.starts.push_back(length_so_far);
            const auto q = source_.corners(h / 3);
            length_so_far += length(q[(h % 3 + 1) % 3] - q[h % 3]);
            // Round the end of the edge to the next one on the border.
            const std::uint32_t turn = source_.faces[h / 3][(h % 3 + 1) % 3];
            std::uint32_t face = h / 3, edge = (h % 3 + 1) % 3;
            for (std::size_t guard = 0; guard < count && source_.neighbours[face][edge] != kNone; ++guard) {
                face = source_.neighbours[face][edge];
                const Face& f = source_.faces[face];
                edge = f[0] == turn ? 0 : f[1] == turn ? 1 : 2;
            }
            h = 3 * face + edge;
        }
        loop.starts.push_back(length_so_far);
    }
}

/// Each sample on the border lies on a border edge of its face, or on a vertex that such an edge begins or ends at.
void BorderRails::find_stops(const SampledChart& chart) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> place(3 * source_.faces.size(), {kNone, kNone});
    std::vector<std::uint32_t> from_vertex(source_.positions.size(), kNone);
    for (std::uint32_t l = 0; l < loops_.size(); ++l)
        for (std::uint32_t k = 0; k < loops_[l].half_edges.size(); ++k) {
            const std::uint32_t h = loops_[l].half_edges[k];
            place[h] = {l, k};
            from_vertex[source_.faces[h / 3][h % 3]] = h;
        }
    stop_of_.assign(freedom_.size(), kNone);
    for (std::uint32_t c = 0; c < freedom_.size(); ++c) {
        if (freedom_[c] == Freedom::kFree) continue;
        const SurfaceSample& at = chart.samples[grid_.sample_of[c]];
        if (at.face == kNone) continue;
        const auto stop = [&](std::uint32_t h, double x) {
            const auto [l, k] = place[h];
            stop_of_[c] = static_cast<std::uint32_t>(stops_.size());
            stops_.push_back({c, l, kNone, kNone});
            const Loop& loop = loops_[l];
            places_.push_back(loop.starts[k] + std::clamp(x, 0.0, 1.0) * (loop.starts[k + 1] - loop.starts[k]));
        };
        for (std::uint32_t k = 0; k < 3 && stop_of_[c] == kNone; ++k) {
            const std::uint32_t h = 3 * at.face + k;
            if (source_.neighbours[at.face][k] == kNone && at.b[(k + 2) % 3] < kOnBorder) stop(h, at.b[(k + 1) % 3]);
        }
        for (std::uint32_t k = 0; k < 3 && stop_of_[c] == kNone; ++k) {
            const std::uint32_t h = from_vertex[source_.faces[at.face][k]];
            if (at.b[k] > 1 - kOnBorder && h != kNone) stop(h, 0);
        }
    }
}

std::vector<std::uint32_t> BorderRails::leaving_half_edges() const {
    std::vector<std::uint32_t> leaving(freedom_.size(), kNone);
    for (std::uint32_t f = 0; f < grid_.surface.faces.size(); ++f)
        for (std::uint32_t k = 0; k < 3; ++k)
            if (grid_.surface.neighbours[f][k] == kNone) leaving[grid_.surface.faces[f][k]] = 3 * f + k;
    return leaving;
}

void BorderRails::order_stops() {
    const std::vector<std::uint32_t> leaving = leaving_half_edges();
    std::vector<char> pinched(freedom_.size(), 0);  // two border edges of the grid leave it: it stays
    for (std::uint32_t f = 0; f < grid_.surface.faces.size(); ++f)
        for (std::uint32_t k = 0; k < 3; ++k)
            if (grid_.surface.neighbours[f][k] == kNone && leaving[grid_.surface.faces[f][k]] != 3 * f + k)
                pinched[grid_.surface.faces[f][k]] = 1;
    orders_.resize(loops_.size());
    for (std::uint32_t s = 0; s < stops_.size(); ++s) orders_[stops_[s].loop].push_back(s);
    for (std::vector<std::uint32_t>& order : orders_) {
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            return places_[a] != places_[b] ? places_[a] < places_[b] : a < b;
        });
        bool sound = order.size() >= 3;
        for (std::size_t k = 0; sound && k < order.size(); ++k) {
            Stop& stop = stops_[order[k]];
            stop.after = order[(k + 1) % order.size()];
            stop.before = order[(k + order.size() - 1) % order.size()];
            const std::uint32_t h = leaving[stop.class_id];
            sound = h != kNone && !pinched[stop.class_id] && piece(stop) > 0 &&
                    grid_.surface.faces[h / 3][(h % 3 + 1) % 3] == stops_[stop.after].class_id;
        }
        if (!sound) order.clear();
    }
}

double BorderRails::turn_at(const Loop& loop, double t, double reach) const {
    const Vec3d p = point_at_length(loop, t), a = p - point_at_length(loop, t - reach),
                b = point_at_length(loop, t + reach) - p;
    return math::atan2(length(cross(a, b)), dot(a, b));
}

void BorderRails::find_corners() {
    for (std::size_t l = 0; l < loops_.size(); ++l) {
        Loop& loop = loops_[l];
        if (orders_[l].empty()) continue;
        const double chord = loop.length() / static_cast<double>(orders_[l].size());
        // Per vertex: the turn of the border over half a chord to each side, and that of its two edges alone. A vertex
        // of a finely divided arc turns little by itself, and one place of an arc is as good as another.
        std::vector<std::pair<double, std::size_t>> turns;
        for (std::size_t k = 0; k < loop.half_edges.size(); ++k) {
            const double t = loop.starts[k];
            const std::size_t last = (k + loop.half_edges.size() - 1) % loop.half_edges.size();
            const double own = std::min({chord / 2, loop.starts[k + 1] - t, loop.starts[last + 1] - loop.starts[last]});
            const double wide = turn_at(loop, t, chord / 2);
            if (wide > kCornerTurn || (wide > kLeastTurn && turn_at(loop, t, own) > kOwnShare * wide))
                turns.emplace_back(-wide, k);
        }
        std::sort(turns.begin(), turns.end());
        std::set<double> corners;
        for (const auto& [wide, k] : turns) {
            const double t = loop.starts[k];
            const auto near = [&](double corner) {
                const double way = std::abs(corner - t);
                return std::min(way, loop.length() - way) < kCornerStep * chord;
            };
            // Of all corners so far, the next ones either way round the loop are the nearest.
            const auto next = corners.lower_bound(t);
            const bool taken =
                !corners.empty() && (near(next == corners.end() ? *corners.begin() : *next) ||
                                     near(next == corners.begin() ? *corners.rbegin() : *std::prev(next)));
            if (!taken) corners.insert(next, t);
        }
        loop.corners.assign(corners.begin(), corners.end());
        for (const std::uint32_t s : orders_[l])
            places_[s] = on_corner_near(loop.corners, places_[s], kOnCorner * chord);
        for (std::size_t k = 0; k < loop.half_edges.size(); ++k) {
            const double from = loop.starts[k], along = loop.starts[k + 1] - from;
            const double parts = std::min(std::ceil(along / (kPointStep * chord)), 1e6);
            for (double p = 0; p == 0 || (p < parts && loop.points.size() < kMostPoints); ++p)
                loop.points.push_back(from + along * (p / std::max(1.0, parts)));
        }
    }
}

std::size_t BorderRails::edge_at(const Loop& loop, double t) const {
    const auto next = std::upper_bound(loop.starts.begin(), loop.starts.end() - 1, t);
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, next - loop.starts.begin() - 1));
}

Vec3d BorderRails::point_at_length(const Loop& loop, double t) const {
    if (t < 0) t += loop.length();
    if (t >= loop.length()) t -= loop.length();
    const std::size_t k = edge_at(loop, t);
    const std::uint32_t h = loop.half_edges[k];
    const auto q = source_.corners(h / 3);
    const double along = loop.starts[k + 1] - loop.starts[k], x = along > 0 ? (t - loop.starts[k]) / along : 0;
    if (x <= 0) return q[h % 3];
    return q[h % 3] * (1 - x) + q[(h % 3 + 1) % 3] * x;
}

double BorderRails::piece(const Stop& stop) const {
    const double from = places_[&stop - stops_.data()], to = places_[stop.after];
    return to > from ? to - from : to - from + loops_[stop.loop].length();
}

double BorderRails::reach(std::uint32_t c) const {
    const Stop& stop = stops_[stop_of_[c]];
    return 0.4 * std::min(piece(stop), piece(stops_[stop.before]));
}

double BorderRails::after_sliding(const Stop& stop, double by) const {
    const Loop& loop = loops_[stop.loop];
    const double from = places_[&stop - stops_.data()];
    double to = from + by;
    // The first corner on the way, in this turn round the loop or the one beside it.
    for (const double turn : {-loop.length(), 0.0, loop.length()}) {
        const auto next = std::partition_point(loop.corners.begin(), loop.corners.end(), [&](double corner) {
            return by > 0 ? corner + turn <= from : corner + turn < from;
        });
        if (by > 0) {
            if (next != loop.corners.end() && *next + turn <= to) to = *next + turn;
        } else if (next != loop.corners.begin() && to <= *std::prev(next) + turn) {
            to = *std::prev(next) + turn;
        }
    }
    if (to < 0) to += loop.length();
    if (to >= loop.length()) to -= loop.length();
    // The corner itself, not its rounded place after a turn.
    return on_corner_near(loop.corners, to, 1e-12 * loop.length());
}

Vec3d BorderRails::place_after(std::uint32_t c, double by) const {
    const Stop& stop = stops_[stop_of_[c]];
    return point_at_length(loops_[stop.loop], after_sliding(stop, by));
}

void BorderRails::slide(std::span<const std::pair<std::uint32_t, double>> ways) {
    std::vector<double> places = places_;
    for (const auto& [c, by] : ways) places[stop_of_[c]] = after_sliding(stops_[stop_of_[c]], by);
    set_places(places);
}

bool BorderRails::has_moved(std::uint32_t c) const {
    const std::uint32_t s = stop_of_.empty() ? kNone : stop_of_[c];
    return s != kNone && places_[s] != first_places_[s];
}

void BorderRails::set_places(const std::vector<double>& places) {
    places_ = places;
    refresh();
}

void BorderRails::refresh() {
    // Stops keep their order round the loop, but may pass its beginning.
    const auto lower = [&](std::uint32_t a, std::uint32_t b) { return places_[a] < places_[b]; };
    for (std::vector<std::uint32_t>& order : orders_)
        std::rotate(order.begin(), std::min_element(order.begin(), order.end(), lower), order.end());
    for (std::size_t s = 0; s < stops_.size(); ++s) {
        const Stop& stop = stops_[s];
        if (orders_[stop.loop].empty()) continue;
        const Loop& loop = loops_[stop.loop];
        const bool corner = std::binary_search(loop.corners.begin(), loop.corners.end(), places_[s]);
        freedom_[stop.class_id] = corner ? Freedom::kHeld : Freedom::kSlides;
        const double half = 0.25 * std::min(piece(stop), piece(stops_[stop.before]));
        const Vec3d along = point_at_length(loop, places_[s] + half) - point_at_length(loop, places_[s] - half);
        directions_[stop.class_id] = corner ? Vec3d{} : normalized(along, Vec3d{});
        if (directions_[stop.class_id] == Vec3d{}) freedom_[stop.class_id] = Freedom::kHeld;
    }
}

std::vector<double> BorderRails::ways_to_corners() const {
    std::vector<double> ways(freedom_.size(), 0.0);
    for (std::size_t l = 0; l < loops_.size(); ++l) {
        const std::vector<std::uint32_t>& order = orders_[l];
        if (order.empty()) continue;
        for (const double corner : loops_[l].corners) {
            const auto above =
                std::partition_point(order.begin(), order.end(), [&](std::uint32_t s) { return places_[s] < corner; });
            const std::uint32_t next = above == order.end() ? order.front() : *above, last = stops_[next].before;
            double forward = corner - places_[last], backward = places_[next] - corner;
            if (backward == 0) continue;
            if (forward < 0) forward += loops_[l].length();
            if (backward < 0) backward += loops_[l].length();
            const auto send = [&](std::uint32_t s, double by) {
                const std::uint32_t c = stops_[s].class_id;
                if (freedom_[c] != Freedom::kSlides || ways[c] != 0) return false;
                ways[c] = by;
                return true;
            };
            if (forward < backward)
                send(last, forward) || send(next, -backward);
            else
                send(next, -backward) || send(last, forward);
        }
    }
    return ways;
}

SurfaceSample BorderRails::sample(std::uint32_t c) const {
    const std::uint32_t s = stop_of_[c];
    const Loop& loop = loops_[stops_[s].loop];
    const std::size_t k = edge_at(loop, places_[s]);
    const std::uint32_t h = loop.half_edges[k];
    const double along = loop.starts[k + 1] - loop.starts[k], x = along > 0 ? (places_[s] - loop.starts[k]) / along : 0;
    SurfaceSample out{h / 3, {0, 0, 0}};
    out.b[h % 3] = 1 - x;
    out.b[(h % 3 + 1) % 3] = x;
    return out;
}

template <class Visit>
void BorderRails::for_gaps(Visit visit) const {
    for (std::size_t l = 0; l < loops_.size(); ++l) {
        const std::vector<std::uint32_t>& order = orders_[l];
        if (order.empty()) continue;
        std::size_t passed = 0;
        for (const double t : loops_[l].points) {
            while (passed < order.size() && places_[order[passed]] <= t) ++passed;
            const std::size_t at = passed > 0 ? passed - 1 : order.size() - 1;
            const Stop& stop = stops_[order[at]];
            const Vec3d &a = grid_.surface.positions[stop.class_id],
                        &b = grid_.surface.positions[stops_[stop.after].class_id];
            const Vec3d e = b - a, p = point_at_length(loops_[l], t);
            const double squared = dot(e, e), x = squared > 0 ? std::clamp(dot(p - a, e) / squared, 0.0, 1.0) : 0.0;
            visit(Gap{order[at], x, p - a - e * x, e});
        }
    }
}

void BorderRails::add_rows(NormalEquations& equations, double weight,
                           const std::function<double(double)>& urgency) const {
    std::vector<double> share(loops_.size(), 0);
    for (std::size_t l = 0; l < loops_.size(); ++l)
        if (!loops_[l].points.empty())
            share[l] = weight * static_cast<double>(orders_[l].size()) / static_cast<double>(loops_[l].points.size());
    const std::vector<std::uint32_t> leaving = leaving_half_edges();  // diagonals may have changed
    for_gaps([&](const Gap& g) {
        const Stop& stop = stops_[g.stop];
        const std::uint32_t h = leaving[stop.class_id];
        std::array<double, 3> b{0, 0, 0};
        b[h % 3] = 1 - g.x;
        b[(h % 3 + 1) % 3] = g.x;
        // Both directions across the chord: where there is no gap, none shall come.
        const Vec3d along = normalized(g.chord, Vec3d{}),
                    n = normalized(g.gap - along * dot(along, g.gap), any_perpendicular(along));
        const double w = share[stop.loop] * urgency(dot(g.gap, g.gap));
        equations.add(h / 3, b, g.gap, n, w);
        equations.add(h / 3, b, g.gap, normalized(cross(along, n), any_perpendicular(along)), w);
    });
}

double BorderRails::largest_gap() const {
    double squared = 0;
    for_gaps([&](const Gap& g) { squared = std::max(squared, dot(g.gap, g.gap)); });
    return std::sqrt(squared);
}

}  // namespace dgm::bake
