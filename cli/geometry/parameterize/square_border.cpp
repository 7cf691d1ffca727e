// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/square_border.cpp
// Positions along the border are counted in sample intervals: t in [0, 2(m-1) + 2(n-1)), whole numbers are samples.
#include "geometry/parameterize/square_border.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "geometry/mesh/union_find.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

/// tau[i]: position of the path's i-th vertex in intervals from the path's start, strictly growing from 0 to k.
std::vector<double> vertex_positions(const TriMesh& mesh, const BorderPath& path, std::uint32_t k) {
    const std::size_t edges = path.half_edges.size();
    std::vector<double> s(edges + 1, 0.0);
    for (std::size_t i = 0; i < edges; ++i) {
        const std::uint32_t h = path.half_edges[i];
        s[i + 1] = s[i] + length(mesh.positions[target(mesh.faces, h)] - mesh.positions[origin(mesh.faces, h)]);
    }
    const double total = s.back();
    // Where arc length has no room between two vertices (graded or coincident ones), mix in equal spacing.
    for (double share : {0.0, 0.01, 0.1, 1.0}) {
        std::vector<double> tau(edges + 1);
        bool strict = total > 0 || share == 1.0;
        for (std::size_t i = 0; i <= edges && strict; ++i) {
            const double arc = total > 0 ? s[i] / total : 0, even = static_cast<double>(i) / static_cast<double>(edges);
            tau[i] = k * (arc * (1 - share) + even * share);
            strict = i == 0 || tau[i] - tau[i - 1] > 1e-9;
        }
        tau.back() = k;
        if (strict || share == 1.0) return tau;
    }
    return {};
}

struct Laid {
    std::uint32_t start = 0, intervals = 0;
    std::uint32_t mate = kNone;
    bool same_way = false;
    std::vector<std::uint32_t> vertices;  // of the disk, in border order
    std::vector<double> tau;              // per vertex, from the path's own start
};

/// A path of least(path) intervals keeps its quads apart: a loop needs three, or its ends share a quad's triangle. Of
/// paths that join the same points one may have a single edge, or their edges would be the same: a hole would close.
std::uint32_t least(const BorderPath& path, bool roomy) {
    return path.is_loop ? 3u : roomy || path.parallel ? 2u : 1u;
}

bool has_four_real_sides(const std::vector<BorderPath>& paths) {
    return paths.size() == 4 &&
           std::all_of(paths.begin(), paths.end(), [](const BorderPath& p) { return p.mate == kNone; });
}

bool is_star_of_four(const std::vector<BorderPath>& paths) {
    if (paths.size() != 8) return false;
    // Each arm runs out and back; the first path of the cycle may be either.
    const std::size_t out = paths[0].mate == 1 ? 0 : 1;
    for (std::size_t p = out; p < 8; p += 2)
        if (paths[p].mate != (p + 1) % 8 || paths[p].same_way) return false;
    return true;
}

struct Shares {
    std::vector<std::uint32_t> intervals;  // per path
    std::uint32_t start;                   // border sample where the first path begins
};

Shares equal_arms(const std::vector<BorderPath>& paths, BorderGrid grid) {
    if (!is_star_of_four(paths))
        throw Error(codes::kMethodUnsuited, "the cut is no star of four arms, and cannot be laid as one");
    if (grid.m % 2 == 0 || grid.n % 2 == 0 || grid.m < 3 || grid.n < 3)
        throw Error(codes::kMethodUnsuited,
                    "each side of the square folds at its middle sample, which even numbers of samples do not have");
    const std::uint32_t half[2] = {(grid.m - 1) / 2, (grid.n - 1) / 2};
    const bool outwards = paths[0].mate == 1;
    Shares out{{}, outwards ? 0 : half[0]};
    for (std::uint32_t p = 0; p < 8; ++p) out.intervals.push_back(half[(p + (outwards ? 0 : 1)) / 2 % 2]);
    return out;
}

/// The two sides of a cut from loop to loop lie on two opposite sides of the square, the loops on the other two, each
/// of their paths by its length.
Shares facing_loops(const std::vector<BorderPath>& paths, BorderGrid grid, bool loops_on_m) {
    const auto is_cut = [](const BorderPath& path) { return path.mate != kNone; };
    const auto first = static_cast<std::size_t>(std::find_if(paths.begin(), paths.end(), is_cut) - paths.begin());
    const std::size_t second = first < paths.size() ? paths[first].mate : first;
    const bool one_path = std::count_if(paths.begin(), paths.end(), is_cut) == 2 && second != first &&
                          !paths[first].same_way && second - first > 1 && paths.size() + first - second > 1;
    if (!one_path) throw Error(codes::kMethodUnsuited, "the cut is no path between two loops");
    const std::uint32_t loop = (loops_on_m ? grid.m : grid.n) - 1, side = (loops_on_m ? grid.n : grid.m) - 1;
    Shares out{std::vector<std::uint32_t>(paths.size(), side), 0};
    for (const auto& [cut, next] : {std::pair{first, second}, std::pair{second, first + paths.size()}}) {
        std::vector<BorderPath> run;
        for (std::size_t p = cut + 1; p < next; ++p) run.push_back(paths[p % paths.size()]);
        const std::vector<std::uint32_t> intervals = allocate_intervals(run, loop);
        for (std::size_t p = cut + 1; p < next; ++p) out.intervals[p % paths.size()] = intervals[p - cut - 1];
    }
    std::uint32_t before = 0;
    for (std::size_t p = 0; p < first; ++p) before += out.intervals[p];
    out.start = (grid.corner(loops_on_m ? 1 : 0) + grid.count() - before) % grid.count();
    return out;
}

class BorderLayout {
 public:
    BorderLayout(Disk& disk, BorderGrid grid, std::uint32_t rotation, BorderShares shares) : disk_(disk), grid_(grid) {
        const std::vector<BorderPath> paths = border_paths(disk, grid.count());
        std::uint32_t start = rotation % grid.count();
        std::vector<std::uint32_t> intervals;
        if (shares != BorderShares::kByLength) {
            const Shares given = shares == BorderShares::kEqualArms
                                     ? equal_arms(paths, grid)
                                     : facing_loops(paths, grid, shares == BorderShares::kLoopsOnM);
            intervals = given.intervals;
            start = given.start;
        } else if (has_four_real_sides(paths)) {
            intervals = {grid.m - 1, grid.n - 1, grid.m - 1, grid.n - 1};
        } else {
            intervals = allocate_intervals(paths, grid.count());
        }
        for (std::size_t p = 0; p < paths.size(); ++p) {
            Laid l;
            l.start = start;
            l.intervals = intervals[p];
            l.mate = paths[p].mate;
            l.same_way = paths[p].same_way;
            for (std::uint32_t h : paths[p].half_edges) l.vertices.push_back(origin(disk.mesh.faces, h));
            l.vertices.push_back(target(disk.mesh.faces, paths[p].half_edges.back()));
            if (l.mate != kNone && l.mate < p) {
                const std::vector<double>& other = laid_[l.mate].tau;
                if (paths[p].same_way)
                    l.tau = other;
                else
                    for (std::size_t i = other.size(); i-- > 0;) l.tau.push_back(l.intervals - other[i]);
            } else {
                l.tau = vertex_positions(disk.mesh, paths[p], intervals[p]);
            }
            start = (start + intervals[p]) % grid.count();
            laid_.push_back(std::move(l));
            out_.smallest_interval = p == 0 ? paths[p].length / intervals[p]
                                            : std::min(out_.smallest_interval, paths[p].length / intervals[p]);
        }
    }

    SquareBorder run() {
        for (int k = 0; k < 4; ++k) put_corner(grid_.corner(k));
        split_chords();
        read_border();
        sample_border();
        return std::move(out_);
    }

 private:
    [[nodiscard]] std::uint32_t border_half_edge(std::uint32_t from) const {
        for (std::uint32_t h : disk_.border())
            if (origin(disk_.mesh.faces, h) == from) return h;
        return kNone;
    }

    /// Puts a vertex at border sample t (and at its mate's place), unless one is there.
    void put_corner(std::uint32_t t) {
        for (Laid& path : laid_) {
            const std::uint32_t q = (t + grid_.count() - path.start) % grid_.count();
            if (q >= path.intervals || q == 0) continue;
            Laid* mate = path.mate == kNone ? nullptr : &laid_[path.mate];
            const auto at =
                static_cast<std::size_t>(std::lower_bound(path.tau.begin(), path.tau.end(), q) - path.tau.begin());
            const auto snap = [&](std::size_t i) {
                path.tau[i] = q;
                if (mate != nullptr && path.same_way)
                    mate->tau[i] = q;
                else if (mate != nullptr)
                    mate->tau[mate->tau.size() - 1 - i] = mate->intervals - q;
            };
            constexpr double kSnap = 1e-6;  // of an interval: a vertex this near becomes the corner itself
            if (at + 1 < path.tau.size() && path.tau[at] - q < kSnap) return snap(at);
            if (at > 1 && q - path.tau[at - 1] < kSnap) return snap(at - 1);
            const double share = (q - path.tau[at - 1]) / (path.tau[at] - path.tau[at - 1]);
            const NewVertices added = disk_.split(border_half_edge(path.vertices[at - 1]), share);
            const auto offset = static_cast<std::ptrdiff_t>(at);
            path.vertices.insert(path.vertices.begin() + offset, added.vertex);
            path.tau.insert(path.tau.begin() + offset, q);
            if (mate != nullptr && path.same_way) {
                mate->vertices.insert(mate->vertices.begin() + offset, added.twin);
                mate->tau.insert(mate->tau.begin() + offset, q);
            } else if (mate != nullptr) {
                const auto back = static_cast<std::ptrdiff_t>(mate->tau.size()) - offset;
                mate->vertices.insert(mate->vertices.begin() + back, added.twin);
                mate->tau.insert(mate->tau.begin() + back, mate->intervals - static_cast<double>(q));
            }
            return;
        }
    }

    /// Border position of each border vertex, or -1.
    [[nodiscard]] std::vector<double> border_positions() const {
        std::vector<double> t(disk_.mesh.positions.size(), -1.0);
        for (const Laid& path : laid_)
            for (std::size_t i = 0; i + 1 < path.vertices.size(); ++i) {
                const double at = path.start + path.tau[i];
                t[path.vertices[i]] = at >= grid_.count() ? at - grid_.count() : at;
            }
        return t;
    }

    /// A chord on one side of the square would collapse the faces behind it; across a corner it would lock up the faces
    /// behind it in a triangle, however many there are.
    void split_chords() {
        const std::vector<double> t = border_positions();
        const std::size_t old_vertices = t.size();
        for (std::uint32_t h = 0; h < disk_.opposite.size(); ++h) {  // grows while it runs; new edges end inside
            if (disk_.opposite[h] == kNone) continue;
            const std::uint32_t a = origin(disk_.mesh.faces, h), b = target(disk_.mesh.faces, h);
            if (a >= old_vertices || b >= old_vertices || t[a] < 0 || t[b] < 0) continue;
            disk_.split(h, 0.5);
        }
    }

    void read_border() {
        const std::vector<double> t = border_positions();
        for (std::uint32_t h : disk_.border()) {
            const std::uint32_t v = origin(disk_.mesh.faces, h);
            half_edge_of_.resize(disk_.mesh.positions.size(), kNone);
            half_edge_of_[v] = h;
            out_.vertices.push_back(v);
            out_.uv.push_back(grid_.uv(t[v]));
        }
    }

    void sample_border() {
        const std::uint32_t count = grid_.count();
        UnionFind classes(count);
        out_.samples.resize(count);
        for (const Laid& path : laid_) {
            std::size_t i = 0;
            for (std::uint32_t q = 0; q < path.intervals; ++q) {
                while (i + 2 < path.tau.size() && path.tau[i + 1] <= q) ++i;
                const double share = std::clamp((q - path.tau[i]) / (path.tau[i + 1] - path.tau[i]), 0.0, 1.0);
                const std::uint32_t h = half_edge_of_[path.vertices[i]], t = (path.start + q) % count;
                BorderSample& sample = out_.samples[t];
                sample.index = grid_.sample(t);
                sample.at.face = h / 3;
                sample.at.b[h % 3] = 1 - share;
                sample.at.b[(h + 1) % 3] = share;
            }
            if (path.mate == kNone) continue;
            for (std::uint32_t q = 0; q <= path.intervals; ++q)
                classes.unite((path.start + q) % count, mate_of(path, q));
        }
        for (std::uint32_t t = 0; t < count; ++t) out_.samples[t].same_as = classes.find(t);
        if (std::any_of(laid_.begin(), laid_.end(), [](const Laid& path) { return path.same_way; })) mark_reversed();
    }

    /// The border sample across the cut from interval `q` of a path that has a mate.
    [[nodiscard]] std::uint32_t mate_of(const Laid& path, std::uint32_t q) const {
        return (laid_[path.mate].start + (path.same_way ? q : path.intervals - q)) % grid_.count();
    }

    /// Follows each class from its first sample over the paths: a path that runs in the direction of its mate reverses.
    void mark_reversed() {
        struct Link {
            std::uint32_t to;
            bool reverses;
        };
        const std::uint32_t count = grid_.count();
        std::vector<std::vector<Link>> links(count);
        for (const Laid& path : laid_) {
            if (path.mate == kNone) continue;
            for (std::uint32_t q = 0; q <= path.intervals; ++q)
                links[(path.start + q) % count].push_back({mate_of(path, q), path.same_way});
        }
        std::vector<char> known(count, 0);
        std::vector<std::uint32_t> walk;
        for (std::uint32_t first = 0; first < count; ++first) {
            if (known[first]) continue;
            known[first] = 1;
            walk.assign(1, first);
            for (std::size_t at = 0; at < walk.size(); ++at)
                for (const Link& link : links[walk[at]]) {
                    if (known[link.to]) continue;
                    known[link.to] = 1;
                    out_.samples[link.to].reversed = out_.samples[walk[at]].reversed != link.reverses;
                    walk.push_back(link.to);
                }
        }
    }

    Disk& disk_;
    BorderGrid grid_;
    std::vector<Laid> laid_;
    std::vector<std::uint32_t> half_edge_of_;
    SquareBorder out_;
};

}  // namespace

std::uint32_t BorderGrid::sample(std::uint32_t t) const {
    if (t < corner(1)) return t * n;
    if (t < corner(2)) return (m - 1) * n + (t - corner(1));
    if (t < corner(3)) return (m - 1 - (t - corner(2))) * n + n - 1;
    return n - 1 - (t - corner(3));
}

Vec2d BorderGrid::uv(double t) const {
    if (t < corner(1)) return {t / (m - 1), 0};
    if (t < corner(2)) return {1, (t - corner(1)) / (n - 1)};
    if (t < corner(3)) return {1 - (t - corner(2)) / (m - 1), 1};
    return {0, 1 - (t - corner(3)) / (n - 1)};
}

namespace {
/// Of all paths, each of two mates among them.
std::uint64_t intervals_needed(const std::vector<BorderPath>& paths, bool roomy) {
    std::uint64_t needed = 0;
    for (const BorderPath& path : paths) needed += least(path, roomy);
    return needed;
}
}  // namespace

std::vector<BorderPath> border_paths(const Disk& disk, std::uint32_t total) {
    std::vector<BorderPath> paths;
    for (const double corner_degrees : {50, 75, 100, 125, 150, 180}) {
        paths = disk.paths(corner_degrees);
        if (intervals_needed(paths, false) <= total) break;
    }
    return paths;
}

std::vector<std::uint32_t> allocate_intervals(const std::vector<BorderPath>& paths, std::uint32_t total) {
    // One entry per path or pair of mates; a pair costs two intervals for each one it gets.
    struct Share {
        std::size_t path;
        std::uint32_t cost, intervals, least;
        double ideal;
    };
    for (bool roomy : {true, false}) {
        std::vector<Share> shares;
        double weighted = 0;
        const std::uint64_t needed = intervals_needed(paths, roomy);
        for (std::size_t p = 0; p < paths.size(); ++p) {
            if (paths[p].mate != kNone && paths[p].mate < p) continue;
            const std::uint32_t cost = paths[p].mate == kNone ? 1 : 2;
            shares.push_back({p, cost, 0, least(paths[p], roomy), 0});
            weighted += cost * paths[p].length;
        }
        if (needed > total) {
            if (roomy) continue;
            throw Error(codes::kGridTooSmall, "the cut has " + std::to_string(paths.size()) +
                                                  " border paths and needs " + std::to_string(needed) +
                                                  " border intervals, the grid has " + std::to_string(total));
        }
        std::int64_t left = total;
        for (Share& s : shares) {
            s.ideal = weighted > 0 ? total * paths[s.path].length / weighted : 1.0 * total / (s.cost * shares.size());
            s.intervals = std::max(s.least, static_cast<std::uint32_t>(s.ideal));
            left -= std::int64_t{s.cost} * s.intervals;
        }
        const auto gain = [](const Share& s) { return s.ideal - s.intervals; };  // its missing part
        while (left != 0) {
            Share* best = nullptr;
            for (Share& s : shares) {
                if (left > 0 ? s.cost > left : s.intervals <= s.least) continue;
                if (best == nullptr || (left > 0 ? gain(s) > gain(*best) : gain(s) < gain(*best))) best = &s;
            }
            if (best == nullptr) break;
            best->intervals += left > 0 ? 1 : -1;
            left += left > 0 ? -std::int64_t{best->cost} : std::int64_t{best->cost};
        }
        if (left != 0) {
            if (roomy) continue;
            throw Error(codes::kGridTooSmall,
                        "the border paths cannot share " + std::to_string(total) + " intervals evenly");
        }
        std::vector<std::uint32_t> out(paths.size());
        for (const Share& s : shares) {
            out[s.path] = s.intervals;
            if (paths[s.path].mate != kNone) out[paths[s.path].mate] = s.intervals;
        }
        return out;
    }
    return {};
}

SquareBorder lay_square_border(Disk& disk, std::uint32_t m, std::uint32_t n, std::uint32_t rotation,
                               BorderShares shares) {
    disk.join_sides();
    return BorderLayout(disk, {m, n}, rotation, shares).run();
}

namespace {

/// The paths that lay_square_border() lays.
std::vector<BorderPath> joined_paths(const Disk& disk, std::uint32_t total) {
    if (disk.mesh.points.empty()) return border_paths(disk, total);
    Disk joined = disk;
    joined.join_sides();
    return border_paths(joined, total);
}

/// Marks the border samples of the unrotated cycle that are leaves of the cut, or corners of the real border.
struct BorderMarks {
    BorderGrid grid;
    std::vector<char> leaf, corner;

    BorderMarks(const std::vector<BorderPath>& paths, BorderGrid g)
        : grid(g), leaf(g.count(), 0), corner(g.count(), 0) {
        const std::vector<std::uint32_t> intervals = allocate_intervals(paths, g.count());
        std::uint32_t start = 0;
        for (std::size_t p = 0; p < paths.size(); ++p) {
            const std::size_t before = (p + paths.size() - 1) % paths.size();
            if (paths[p].mate == before && !paths[p].same_way && paths.size() > 1) leaf[start] = 1;
            if (paths[p].mate == kNone && paths[before].mate == kNone && paths.size() > 1) corner[start] = 1;
            start += intervals[p];
        }
    }
    /// Position s of the unrotated cycle lies on a corner of the square if s + r is one.
    [[nodiscard]] int hits(const std::vector<char>& marks, std::uint32_t r) const {
        int count = 0;
        for (int k = 0; k < 4; ++k) count += marks[(grid.corner(k) + grid.count() - r % grid.count()) % grid.count()];
        return count;
    }
};

}  // namespace

std::uint32_t nearest_rotation(const Disk& disk, std::uint32_t m, std::uint32_t n, std::uint32_t wanted) {
    const std::vector<BorderPath> paths = joined_paths(disk, BorderGrid{m, n}.count());
    if (has_four_real_sides(paths)) return 0;
    const BorderMarks marks(paths, {m, n});
    const std::uint32_t total = marks.grid.count();
    for (std::uint32_t d = 0; d < total; ++d)
        for (const std::uint32_t r : {(wanted + d) % total, (wanted + total - d) % total})
            if (marks.hits(marks.leaf, r) == 0) return r;
    return wanted;
}

std::vector<std::uint32_t> candidate_rotations(const Disk& disk, std::uint32_t m, std::uint32_t n,
                                               std::size_t how_many) {
    const std::vector<BorderPath> paths = joined_paths(disk, BorderGrid{m, n}.count());
    if (has_four_real_sides(paths)) return {0};
    const BorderMarks marks(paths, {m, n});
    const std::uint32_t period = m == n ? m - 1 : marks.grid.count() / 2;
    std::vector<std::uint32_t> out;
    // Rotations that put corners of the real border on corners of the square come first, best first.
    std::vector<std::pair<int, std::uint32_t>> by_corners;
    for (std::uint32_t r = 0; r < period; ++r)
        if (marks.hits(marks.leaf, r) == 0 && marks.hits(marks.corner, r) > 0)
            by_corners.emplace_back(-marks.hits(marks.corner, r), r);
    std::sort(by_corners.begin(), by_corners.end());
    for (const auto& entry : by_corners)
        if (out.size() < (how_many + 1) / 2) out.push_back(entry.second);
    for (std::size_t k = 0; k < 4 * how_many && out.size() < how_many; ++k) {
        auto r = static_cast<std::uint32_t>(k * period / how_many) % period;
        for (std::uint32_t tries = 0; tries < period && marks.hits(marks.leaf, r) > 0; ++tries) r = (r + 1) % period;
        if (marks.hits(marks.leaf, r) == 0 && std::find(out.begin(), out.end(), r) == out.end()) out.push_back(r);
    }
    if (out.empty()) out.push_back(0);
    return out;
}

}  // namespace dgm::bake
