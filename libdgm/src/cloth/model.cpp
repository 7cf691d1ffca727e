// SPDX-License-Identifier: MIT
// libdgm/src/cloth/model.cpp
// Measures the rest shape of a cloth on every stride of its map.
//
// Membrane: quads with the strain of their middle, and how it changes across them, so that a quad cannot fold into a
// zigzag for nothing. The mean edges of a quad span its area, so any affine map of a flat sheet is in equilibrium,
// whatever its quads. Bending: a thin plate, 1/2 B A (|b_u|^2 + |b_v|^2) at samples and B A |t|^2 at quads. b_u is the
// second derivative along a line of the grid less c^k x_k, its part along the surface at rest, and less its normal part
// at rest, which is the formula of Gauss [do Carmo 1976]; t is the twist of a quad, likewise.
#include <algorithm>
#include <cmath>

#include "cloth/cloth_impl.h"

namespace dgm::detail::cloth {
namespace {

constexpr double kThin = 1e-4;  ///< height over length below which a quad counts as none
constexpr double kSteep = 4;    ///< largest weight of a stencil over that of a grid of squares
constexpr double kConvex = 2;   ///< largest share of a corner in the twist of a convex quad
/// Sine of the angle between a quad's mean edges below which it is weakened, by its third power. Across such a quad
/// strain is the square of a sample's way over next to nothing, and a single one would let no line search go on.
constexpr double kOpen = 0.2;
/// Share of the moduli that resists uneven strain on the finest level of a cloth that is curved at rest, and the bound
/// of the smoother's eigenvalues that goes with it. With all of it a sample has five lengths to keep and three ways to
/// go, so that folds which cross the lines of the grid lock (docs/cloth.md). Coarse levels keep all of it: their uneven
/// strain stands for even strain of the finest quads.
constexpr float kUneven = 0.05f, kHighest = 4;

double length(Double3 v) noexcept {
    return std::sqrt(dot(v, v));
}
std::size_t pitch_of(std::uint32_t cols) noexcept {
    return (cols + kBlock) / kBlock * kBlock;
}

/// Planes of a level with a row of zeros, and a block, on both sides.
bool make_planes(Level& l, const Allocator& a, bool curved) noexcept {
    Sheet& on = l.on;
    on.rows = l.rows;
    on.cols = l.cols;
    const std::size_t pitch = pitch_of(l.cols);
    on.pitch = static_cast<std::ptrdiff_t>(pitch);
    l.count = l.rows * pitch;
    const std::size_t margin = pitch + 2 * kBlock, plane = l.count + 2 * margin;
    float** one[] = {&on.q11,      &on.q12,    &on.q22,     &on.area,    &on.uneven,   &on.twist_u,  &on.twist_v,
                     &on.s1,       &on.s2,     &on.square1, &on.square2, &on.u_up,     &on.u_down,   &on.v_up,
                     &on.v_down,   &on.u_side, &on.v_side,  &on.saddle,  &on.u_curved, &on.v_curved, &on.tension1,
                     &on.tension2, &on.mass,   &on.press,   &on.drag,    &l.free,      &l.own};
    Field* three[] = {&on.f1, &on.f2, &on.normal, &l.residual, &l.way, &l.product, &l.sum, &l.right};
    const std::size_t planes = std::size(one) + 3 * std::size(three) + 6;
    if (!l.planes.allocate(a, planes * plane) || !l.places.allocate(a, 3 * plane)) return false;
    if (!l.clamped.allocate(a, std::uint64_t{l.rows} * l.cols)) return false;
    if (!l.touched.allocate(a, l.rows) || !l.scratch.allocate(a, kMostProducts * kScratchRows * (pitch + 2 * kBlock)))
        return false;
    float* next = l.planes.data() + margin;
    const auto take = [&](float*& p) {
        p = next;
        next += plane;
    };
    for (float** p : one) take(*p);
    for (Field* f : three)
        for (float*& p : f->p) take(p);
    for (float*& p : l.inverse.p) take(p);
    for (int c = 0; c < 3; ++c) l.at[c] = l.places.data() + margin + static_cast<std::size_t>(c) * plane;
    on.touched = l.touched.data();
    on.scratch = l.scratch.data();
    if (!curved) on.saddle = on.u_curved = on.v_curved = nullptr;
    return true;
}

Double3 place(const Level& l, Spot k) noexcept {
    return {l.at[0][k], l.at[1][k], l.at[2][k]};
}

/// Rest shape of quads. @return area of all
double measure_quads(Level& l, double density) noexcept {
    Sheet& on = l.on;
    double total = 0;
    const auto n = static_cast<Spot>(on.pitch);
    for (std::uint32_t i = 0; i + 1 < l.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < l.cols; ++j) {
            const Spot k = i * n + j;
            const Double3 a = place(l, k), b = place(l, k + n), c = place(l, k + 1), d = place(l, k + n + 1);
            const Double3 u = 0.5 * ((b - a) + (d - c)), v = 0.5 * ((c - a) + (d - b)), h = (d - c) - (b - a);
            const double lu = length(u);
            const Double3 e1 = lu > 0 ? (1 / lu) * u : Double3{};
            const double along = dot(v, e1);
            const Double3 across = v - along * e1;
            const double height = length(across);
            if (!(lu > 0) || !(height > kThin * std::max(lu, length(v))) || !(lu > kThin * height)) continue;
            const Double3 e2 = (1 / height) * across;
            const double beta = dot(h, e2) / height, area = lu * height;
            on.q11[k] = static_cast<float>(1 / lu);
            on.q12[k] = static_cast<float>(-along / (lu * height));
            on.q22[k] = static_cast<float>(1 / height);
            on.twist_u[k] = static_cast<float>((dot(h, e1) - beta * along) / lu);
            on.twist_v[k] = static_cast<float>(beta);
            on.area[k] = static_cast<float>(area);
            const double share = 1 + 0.5 * (std::fabs(double{on.twist_u[k]}) + std::fabs(double{on.twist_v[k]}));
            on.uneven[k] = static_cast<float>(std::min(1.0, kConvex * kConvex / (share * share)));
            if (on.saddle != nullptr) on.saddle[k] = static_cast<float>(dot(h, cross(u, v)) / (lu * height));
            total += area;
            for (const Spot s : {k, k + n, k + 1, k + n + 1}) on.mass[s] += static_cast<float>(density * area / 4);
            const double open = height / (kOpen * length(v));
            if (open < 1) on.area[k] *= static_cast<float>(open * open * open);
        }
    return total;
}

/// Neighbours of a sample, [di + 1][dj + 1]; kNone where there is none.
struct Around {
    Spot at[3][3];
};
/// Stencil of one line of the grid: ahead, behind, and to both sides.
struct Bend {
    double up = 0, down = 0, side = 0, curved = 0;
};
struct Bends {
    Bend u, v;
    bool any = false;
    double part = 1;  ///< of the bending stiffness
};
/// Second derivative by length along `ahead - behind`, without its part along the surface. `half_side`: the other line
/// of the grid has both neighbours, and `side` is half their difference.
Bend bend_along(Double3 ahead, Double3 behind, Double3 side, bool half_side, Double3 normal) noexcept {
    const Double3 along = 0.5 * (ahead - behind);
    const double e = dot(along, along), f = dot(along, side), g = dot(side, side), det = e * g - f * f;
    const Double3 value = (1 / e) * (ahead + behind);
    const double tu = dot(value, along), tv = dot(value, side);
    const double cu = (g * tu - f * tv) / det, cv = (e * tv - f * tu) / det;
    return {1 / e - 0.5 * cu, 1 / e + 0.5 * cu, half_side ? -0.5 * cv : -cv, dot(value, normal)};
}
Bends bend_at(const Level& l, const Around& near) noexcept {
    Bends out;
    const Double3 x = place(l, near.at[1][1]);
    const auto has = [&](int i, int j) { return near.at[i][j] != kNone; };
    const auto way = [&](int i, int j) { return has(i, j) ? place(l, near.at[i][j]) - x : Double3{}; };
    const bool up = has(2, 1), down = has(0, 1), right = has(1, 2), left = has(1, 0);
    if (!(up || down) || !(right || left)) return out;
    const Double3 u = (up && down ? 0.5 : 1) * (way(2, 1) - way(0, 1)),
                  v = (right && left ? 0.5 : 1) * (way(1, 2) - way(1, 0));
    const double e = dot(u, u), f = dot(u, v), g = dot(v, v);
    if (!(e * g - f * f > kThin * kThin * e * g) || !(e > 0) || !(g > 0)) return out;
    const Double3 area = cross(u, v), n = (1 / length(area)) * area;
    if (up && down) out.u = bend_along(way(2, 1), way(0, 1), v, right && left, n);
    if (right && left) out.v = bend_along(way(1, 2), way(1, 0), u, up && down, n);
    out.any = (up && down) || (right && left);
    // Where the lines of the grid nearly meet, weights are as large as the angle is small.
    const double natural = kSteep * (1 / e + 1 / g);
    for (const Bend& b : {out.u, out.v})
        for (const double w : {b.up, b.down, b.side})
            if (std::fabs(w) > natural) out.part = std::min(out.part, natural / w * (natural / w));
    return out;
}

Around around(const Level& l, std::uint32_t i, std::uint32_t j) noexcept {
    Around out;
    for (int di = -1; di <= 1; ++di)
        for (int dj = -1; dj <= 1; ++dj) {
            const auto r = static_cast<std::int64_t>(i) + di, s = static_cast<std::int64_t>(j) + dj;
            const bool in = r >= 0 && s >= 0 && r < l.rows && s < l.cols;
            out.at[di + 1][dj + 1] = in ? static_cast<Spot>(r * l.on.pitch + s) : kNone;
        }
    return out;
}

/// Ids of classes by spot of a level; kNone: alone.
struct Classes {
    const Level& l;
    const Array<std::uint32_t>& id;
    [[nodiscard]] std::uint32_t of(Spot k) const noexcept {
        return id[k / static_cast<Spot>(l.on.pitch) * l.cols + k % static_cast<Spot>(l.on.pitch)];
    }
};

/// Fills in what lies across a seam from a sample with one copy. @return false where that is not clear
bool sew(const Level& l, const Classes& c, Spot copy, Around& near) noexcept {
    const auto pitch = static_cast<Spot>(l.on.pitch);
    const Around other = around(l, copy / pitch, copy % pitch);
    constexpr int kWays[4][2] = {{2, 1}, {0, 1}, {1, 2}, {1, 0}};
    int across[2] = {-1, -1}, found = 0;
    bool on_seam[4] = {};
    for (const auto& w : kWays) {  // which neighbours of the copy are not on the seam
        const Spot q = other.at[w[0]][w[1]];
        if (q == kNone) continue;
        bool shared = false;
        for (int k = 0; k < 4; ++k) {
            const Spot p = near.at[kWays[k][0]][kWays[k][1]];
            if (p == kNone || c.of(p) == kNone || c.of(p) != c.of(q)) continue;
            on_seam[k] = shared = true;
        }
        if (shared) continue;
        across[0] = w[0];
        across[1] = w[1];
        ++found;
    }
    if (found != 1 || !(on_seam[0] || on_seam[1] || on_seam[2] || on_seam[3])) return false;
    const bool along_u = on_seam[0] || on_seam[1];
    if (along_u && (on_seam[2] || on_seam[3])) return false;
    const int axis = along_u ? 2 : 0;  // of kWays: the ways that leave the seam
    const bool first = near.at[kWays[axis][0]][kWays[axis][1]] == kNone;
    if (first == (near.at[kWays[axis + 1][0]][kWays[axis + 1][1]] == kNone)) return false;
    const auto& missing = kWays[first ? axis : axis + 1];
    near.at[missing[0]][missing[1]] = other.at[across[0]][across[1]];
    return true;
}

void put_stencil(Level& l, Spot k, const Bends& b, double bending) noexcept {
    Sheet& on = l.on;
    float* to[6] = {on.u_up, on.u_down, on.u_side, on.v_up, on.v_down, on.v_side};
    const double from[6] = {b.u.up, b.u.down, b.u.side, b.v.up, b.v.down, b.v.side}, root = std::sqrt(bending);
    for (int c = 0; c < 6; ++c) to[c][k] = static_cast<float>(root * from[c]);
    if (on.u_curved == nullptr) return;
    on.u_curved[k] = static_cast<float>(root * b.u.curved);
    on.v_curved[k] = static_cast<float>(root * b.v.curved);
}

/// Stencils of bending, at seams listed apart. @return false: no memory
bool measure_bending(Level& l, const Array<std::uint32_t>& id, const Fabric& f, const Allocator& a) noexcept {
    const auto n = static_cast<Spot>(l.on.pitch);
    const Classes classes{l, id};
    std::size_t seams = 0;
    for (int round = 0; round < 2; ++round) {
        if (round == 1 && !l.seams.allocate(a, seams)) return false;
        seams = 0;
        for (std::uint32_t i = 0; i < l.rows; ++i)
            for (std::uint32_t j = 0; j < l.cols; ++j) {
                const Spot k = i * n + j;
                Around near = around(l, i, j);
                // Bending stiffness times area: mass is density times area, over the whole class.
                const double by = double{f.bending} / double{f.density};
                if (classes.of(k) == kNone) {
                    const Bends b = bend_at(l, near);
                    if (round == 1 && b.any) put_stencil(l, k, b, b.part * by * double{l.on.mass[k]});
                    continue;
                }
                Spot copy = kNone;
                std::uint32_t copies = 0;
                for (std::size_t g = 0; g < l.groups.size(); g += l.groups[g] + 1) {
                    if (classes.of(l.groups[g + 1]) != classes.of(k)) continue;
                    if (l.groups[g] == 2 && l.groups[g + 1] == k) copy = l.groups[g + 2];
                    copies = l.groups[g];
                }
                if (copies < 2) {
                    const Bends b = bend_at(l, near);
                    if (round == 1 && b.any) put_stencil(l, k, b, b.part * by * double{l.on.mass[k]});
                    continue;
                }
                if (copy == kNone || !sew(l, classes, copy, near)) continue;
                const Bends b = bend_at(l, near);
                if (!b.any) continue;
                if (round == 1) {
                    SeamStencil& s = l.seams[seams];
                    constexpr int kOrder[5][2] = {{1, 1}, {2, 1}, {0, 1}, {1, 2}, {1, 0}};
                    for (int w = 0; w < 5; ++w) {
                        const Spot p = near.at[kOrder[w][0]][kOrder[w][1]];
                        s.spot[w] = p == kNone ? k : p;
                    }
                    const double along[8] = {b.u.up,   b.u.down,  b.u.side, -b.u.side,
                                             b.v.side, -b.v.side, b.v.up,   b.v.down};
                    for (int w = 0; w < 8; ++w) s.weight[w / 4][w % 4] = static_cast<float>(along[w]);
                    s.bending = static_cast<float>(b.part * by * (double{l.on.mass[k]} + double{l.on.mass[copy]}));
                    s.curved[0] = static_cast<float>(b.u.curved);
                    s.curved[1] = static_cast<float>(b.v.curved);
                }
                ++seams;
            }
    }
    return true;
}

/// Lists the classes that a level has more than one sample of. @return false: no memory
bool make_groups(Level& l, const Array<std::uint32_t>& id, std::uint32_t classes, const Allocator& a) noexcept {
    if (classes == 0) return true;
    Array<std::uint32_t> count, start;
    if (!count.allocate(a, classes) || !start.allocate(a, classes)) return false;
    for (const std::uint32_t k : id)
        if (k != kNone) ++count[k];
    std::uint32_t size = 0;
    for (std::uint32_t k = 0; k < classes; ++k) {
        start[k] = size;
        if (count[k] > 1) size += count[k] + 1;
    }
    if (!l.groups.allocate(a, size)) return false;
    for (std::uint32_t s = 0; s < l.rows * l.cols; ++s) {
        const std::uint32_t k = id[s];
        if (k == kNone || count[k] < 2) continue;
        std::uint32_t& filled = l.groups[start[k]];
        l.own[s / l.cols * static_cast<Spot>(l.on.pitch) + s % l.cols] = filled == 0 ? 1.0f : 0.0f;
        l.groups[start[k] + 1 + filled++] = s / l.cols * static_cast<Spot>(l.on.pitch) + s % l.cols;
    }
    return true;
}

/// Every second row or column, and the last one.
bool halve(std::uint32_t fine, Array<std::uint32_t>& of, const Allocator& a) noexcept {
    const std::uint32_t step = fine < 3 ? 1 : 2;
    if (!of.allocate(a, (fine - 1 + step - 1) / step + 1)) return false;
    for (std::uint32_t k = 0; k < of.size(); ++k) of[k] = std::min(step * k, fine - 1);
    return true;
}

/// Cubic interpolation of what lies between two coarse rows, quadratic beside a border: what is smooth stays so, as
/// plates need [Hemker 1990]. Linear ones would bend at each coarse row. `back` is the transpose.
bool make_taps(std::uint32_t fine, const Array<std::uint32_t>& of, Array<Taps>& to, Array<Taps>& back,
               const Allocator& a) noexcept {
    const auto n = static_cast<std::uint32_t>(of.size());
    if (!to.allocate(a, fine) || !back.allocate(a, n)) return false;
    const auto even = [&](std::uint32_t k) { return k + 1 < n && of[k + 1] - of[k] == 2; };
    for (std::uint32_t i = 0, k = 0; i < fine; ++i) {
        if (k + 1 < n && of[k + 1] <= i) ++k;
        Taps& t = to[i];
        if (of[k] == i) {
            t.add(k, 1);
        } else if (k > 0 && even(k - 1) && even(k + 1)) {
            t.add(k - 1, -0.0625f);
            t.add(k, 0.5625f);
            t.add(k + 1, 0.5625f);
            t.add(k + 2, -0.0625f);
        } else if (k > 0 && even(k - 1)) {
            t.add(k - 1, -0.125f);
            t.add(k, 0.75f);
            t.add(k + 1, 0.375f);
        } else if (even(k + 1)) {
            t.add(k, 0.375f);
            t.add(k + 1, 0.75f);
            t.add(k + 2, -0.125f);
        } else {
            t.add(k, 0.5f);
            t.add(k + 1, 0.5f);
        }
        for (std::uint32_t w = 0; w < t.count; ++w) back[t.at[w]].add(i, t.weight[w]);
    }
    return true;
}

bool is_curved(const StateImpl& s) noexcept {
    // Flat: all samples lie in one plane but for rounding; else the rest curvature is carried along.
    const Double3 a = widen(StateImpl::at(s.rest, 0)), b = widen(StateImpl::at(s.rest, s.tables.cols - 1)),
                  c = widen(StateImpl::at(s.rest, (s.tables.rows - 1) * s.tables.cols));
    const Double3 n = cross(b - a, c - a);
    const double size = length(n);
    if (!(size > 0)) return true;
    for (std::uint32_t k = 0; k < s.total(); ++k)
        if (std::fabs(dot(n, widen(StateImpl::at(s.rest, k)) - a)) > 1e-6 * size * std::sqrt(size)) return true;
    return false;
}

/// Painted stiffness of a quad, and masses that are not 0.
void finish_level(Level& l, const Array<float>& stiffness, double smallest) noexcept {
    const auto n = static_cast<Spot>(l.on.pitch);
    for (std::uint32_t i = 0; i < l.rows; ++i)
        for (std::uint32_t j = 0; j < l.cols; ++j) {
            const Spot k = i * n + j;
            l.on.mass[k] = std::max(l.on.mass[k], static_cast<float>(smallest));
            if (stiffness.empty() || i + 1 == l.rows || j + 1 == l.cols) continue;
            const std::uint32_t s = i * l.cols + j;
            const float mean =
                0.25f * ((stiffness[s] + stiffness[s + 1]) + (stiffness[s + l.cols] + stiffness[s + l.cols + 1]));
            l.on.area[k] *= std::max(mean, 1e-3f);
        }
}

bool make_coarse(ClothImpl& c, std::uint32_t at) noexcept {
    Level &l = c.level[at], &fine = c.level[at - 1];
    if (!halve(fine.rows, l.row_of, c.allocator) || !halve(fine.cols, l.column_of, c.allocator)) return false;
    l.rows = static_cast<std::uint32_t>(l.row_of.size());
    l.cols = static_cast<std::uint32_t>(l.column_of.size());
    while (l.even < l.cols && l.column_of[l.even] == 2 * l.even) ++l.even;
    if (!make_taps(fine.rows, l.row_of, l.to_row, l.from_rows, c.allocator)) return false;
    if (!make_taps(fine.cols, l.column_of, l.to_column, l.from_columns, c.allocator)) return false;
    if (!make_planes(l, c.allocator, fine.on.u_curved != nullptr)) return false;
    for (std::uint32_t i = 0; i < l.rows; ++i)
        for (std::uint32_t j = 0; j < l.cols; ++j) {
            const auto to = static_cast<Spot>(i * l.on.pitch + j);
            const auto from = static_cast<Spot>(l.row_of[i] * fine.on.pitch + l.column_of[j]);
            for (int d = 0; d < 3; ++d) l.at[d][to] = fine.at[d][from];
            l.free[to] = fine.free[from];
            l.own[to] = 1;
        }
    return true;
}

/// Values by sample of a level from those of the level before.
template <class T>
bool thin_out(const ClothImpl& c, std::uint32_t at, const Array<T>& from, Array<T>& to) noexcept {
    const Level &l = c.level[at], &fine = c.level[at - 1];
    if (from.empty()) return true;
    if (!to.allocate(c.allocator, std::uint64_t{l.rows} * l.cols)) return false;
    for (std::uint32_t i = 0; i < l.rows; ++i)
        for (std::uint32_t j = 0; j < l.cols; ++j) to[i * l.cols + j] = from[l.row_of[i] * fine.cols + l.column_of[j]];
    return true;
}

/// Copies of a class that has lost samples on the way to a level are alone there.
bool measure_level(ClothImpl& c, std::uint32_t at, std::uint32_t classes, const Array<std::uint32_t>& id,
                   const Array<float>& stiffness) noexcept {
    Level& l = c.level[at];
    const Fabric& f = c.options.fabric;
    const bool loose = at == 0 && l.on.u_curved != nullptr;
    const float uneven = (loose ? kUneven : 1) / 12;
    if (loose) c.highest = c.first_bound = kHighest;
    l.on.moduli = {f.warp, f.weft, f.cross, f.shear, uneven * f.warp, uneven * f.weft};
    l.on.plate = f.bending;
    const double area = measure_quads(l, f.density);
    finish_level(l, stiffness, 1e-6 * double{f.density} * area / static_cast<double>(std::size_t{l.rows} * l.cols));
    return make_groups(l, id, classes, c.allocator) && measure_bending(l, id, f, c.allocator);
}

bool make_fine(ClothImpl& c, const StateImpl& s) noexcept {
    Level& l = c.fine();
    l.rows = c.rows;
    l.cols = c.cols;
    if (!make_planes(l, c.allocator, is_curved(s))) return false;
    const std::size_t margin = static_cast<std::size_t>(l.on.pitch) + 2 * kBlock, plane = l.count + 2 * margin;
    float** one[] = {&c.fall, &c.pressed, &c.mobile, &c.weight, &c.firm};
    Field* three[] = {&c.velocity, &c.inertial, &c.correction, &c.way, &c.image, &c.before};
    if (!c.planes.allocate(c.allocator, (std::size(one) + 3 * std::size(three)) * plane)) return false;
    if (!c.places.allocate(c.allocator, 3 * plane)) return false;
    float* next = c.planes.data() + margin;
    for (float** p : one) *p = std::exchange(next, next + plane);
    for (Field* t : three)
        for (float*& p : t->p) p = std::exchange(next, next + plane);
    c.gradient = l.right;
    for (std::size_t d = 0; d < 3; ++d) { c.was[d] = c.places.data() + margin + d * plane; }
    const float* rest[3] = {s.rest.x, s.rest.y, s.rest.z};
    for (std::uint32_t k = 0; k < c.total; ++k) {
        const Spot to = c.spot_of(k);
        for (int d = 0; d < 3; ++d) l.at[d][to] = c.scale * double{rest[d][k]};
        c.mobile[to] = mobility_of(s, k) > 0 ? 1.0f : 0.0f;
        l.free[to] = c.mobile[to];
        l.own[to] = s.representative(k) == k ? 1.0f : 0.0f;
    }
    return true;
}

bool make_copies(ClothImpl& c, const StateImpl& s, Array<std::uint32_t>& id) noexcept {
    if (!c.next_copy.allocate(c.allocator, c.total) || !c.pinned.allocate(c.allocator, c.total)) return false;
    if (!c.was_pinned.allocate(c.allocator, c.total)) return false;
    if (!id.allocate(c.allocator, c.total, kNone)) return false;
    for (std::uint32_t k = 0; k < c.total; ++k) c.next_copy[k] = k;
    for (std::uint32_t k = 0; k < c.total; ++k) {
        id[k] = s.class_id(k);
        const std::uint32_t first = s.representative(k);
        if (first == k) continue;
        c.next_copy[k] = c.next_copy[first];
        c.next_copy[first] = k;
    }
    return true;
}

/// Mass of whole classes, and a stiffness for contacts that is like what bending holds a sample with.
void weigh(ClothImpl& c) noexcept {
    const double bends = 16 * double{c.options.fabric.bending} / (c.mean_step * c.mean_step);
    for (std::uint32_t k = 0; k < c.total; ++k) {
        double mass = 0;
        each_copy(c, k, [&](std::uint32_t s) { mass += double{c.fine().on.mass[c.spot_of(s)]}; });
        c.weight[c.spot_of(k)] = static_cast<float>(mass);
        c.firm[c.spot_of(k)] = static_cast<float>(bends);
    }
}
}  // namespace

Result<void> build_model(ClothImpl& c, const StateImpl& s) noexcept {
    Array<std::uint32_t> id[2];
    Array<float> stiffness[2];
    const Allocator& a = c.allocator;
    if (!make_copies(c, s, id[0]) || !make_fine(c, s)) return kNoMemory;
    if (!s.stiffness.empty()) {
        if (!stiffness[0].allocate(a, c.total)) return kNoMemory;
        std::copy_n(s.stiffness.begin(), c.total, stiffness[0].begin());
    }
    if (!measure_level(c, 0, s.class_count, id[0], stiffness[0])) return kNoMemory;
    c.levels = 1;
    for (std::uint32_t k = 1; k < kMostLevels; ++k) {
        const Level& fine = c.level[k - 1];
        if (fine.rows < 5 && fine.cols < 5) break;
        Array<std::uint32_t>&from = id[(k - 1) % 2], &to = id[k % 2];
        Array<float>&hard = stiffness[(k - 1) % 2], &soft = stiffness[k % 2];
        to = Array<std::uint32_t>();
        soft = Array<float>();
        if (!make_coarse(c, k) || !thin_out(c, k, from, to) || !thin_out(c, k, hard, soft)) return kNoMemory;
        if (!measure_level(c, k, s.class_count, to, soft)) return kNoMemory;
        ++c.levels;
    }
    weigh(c);
    for (std::size_t k = 0; k < c.fine().count; ++k) c.stiff += double{c.fine().on.area[k]};
    c.stiff *= double{std::max(c.options.fabric.warp, c.options.fabric.weft)};
    if (!c.contacts.allocate(a, c.total) || !c.held.allocate(a, c.total) || !c.rubs.allocate(a, c.total))
        return kNoMemory;
    constexpr std::uint64_t kSurfaces = 4;  // further ones are searched from their roots
    c.tile_count = std::size_t{(c.rows + kTile - 1) / kTile} * ((c.cols + kTile - 1) / kTile);
    if (!c.seen.allocate(a, c.total) || !c.near_tiles.allocate(a, kSurfaces) ||
        !c.tiles_seen.allocate(a, kSurfaces * c.tile_count) || !c.tiles_met.allocate(a, c.tile_count))
        return kNoMemory;
    if (!c.options.self_contact) return {};
    if (!c.meetings.allocate(a, 8 * std::uint64_t{c.total}) || !c.edges.allocate(a, 2 * std::uint64_t{kMostEdges}) ||
        !c.cones.allocate(a, std::uint64_t{s.now_boxes.rows[0]} * s.now_boxes.cols[0]))
        return kNoMemory;
    return {};
}

}  // namespace dgm::detail::cloth
