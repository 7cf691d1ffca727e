// SPDX-License-Identifier: MIT
// libdgm/src/cloth/prepare.cpp
// The matrix of a substep on all strides: shapes, contacts, what is held, and the blocks of the smoother.
#include <algorithm>
#include <cmath>

#include "cloth/cloth_impl.h"
#include "cloth/smoother.h"

namespace dgm::detail::cloth {
namespace {

/// What bends across seams, in the diagonal blocks.
void add_seams(const Level& l) noexcept {
    for (const SeamStencil& s : l.seams)
        for (int d = 0; d < 3; ++d)
            for (const auto& weight : s.weight) {
                float middle = 0;
                for (int w = 0; w < 4; ++w) {
                    l.inverse.p[d][s.spot[w + 1]] += s.bending * weight[w] * weight[w];
                    middle += weight[w];
                }
                l.inverse.p[d][s.spot[0]] += s.bending * middle * middle;
            }
}

/// Contacts of a level as those of the next one: normals by stiffness; where they differ, all directions are held.
void take_contacts(const ClothImpl& c, std::uint32_t level) noexcept {
    const Level &fine = c.level[level - 1], &l = c.level[level];
    const bool any = std::any_of(fine.touched.begin(), fine.touched.end(), [](std::uint8_t t) { return t != 0; });
    const Sheet &f = fine.on, &on = l.on;
    std::fill(on.touched, on.touched + l.rows, std::uint8_t{0});
    std::fill(on.press, on.press + l.count, 0.0f);
    std::fill(on.drag, on.drag + l.count, 0.0f);
    if (!any) return;
    // `product` and `way` of the fine level are free now.
    const auto pitch = static_cast<std::size_t>(f.pitch);
    for (int d = 0; d < 3; ++d)
        for (std::size_t i = 0; i < fine.rows; ++i) {
            float* to = fine.product.p[d] + i * pitch;
            if (fine.touched[i] == 0)
                std::fill(to, to + pitch, 0.0f);
            else
                for (std::size_t k = 0; k < pitch; ++k) to[k] = f.press[i * pitch + k] * f.normal.p[d][i * pitch + k];
        }
    restrict_to(c, level - 1, fine.product, on.normal, nullptr);
    restrict_to(c, level - 1, {{f.press, f.drag}}, {{on.press, on.drag}}, nullptr, 2);
    for (std::uint32_t i = 0; i < l.rows; ++i)
        for (std::uint32_t j = 0; j < l.cols; ++j) {
            const auto k = static_cast<Spot>(i * on.pitch + j);
            const Double3 sum = at(on.normal, k);
            const double length = std::sqrt(dot(sum, sum)), whole = std::max(double{on.press[k]}, length);
            on.drag[k] = std::max(on.drag[k], 0.0f);
            if (!(whole > 0)) continue;
            l.on.touched[i] = 1;
            put(on.normal, k, length > 0 ? (1 / length) * sum : Double3{});
            const double lost = std::max(0.0, whole - length) + double{on.drag[k]};
            on.drag[k] = static_cast<float>(lost);
            on.press[k] = static_cast<float>(length + lost);
        }
}

/// The four ways from a sample to its neighbours.
constexpr int kWays[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

/// Which held samples are clamped: held together with a neighbour of the finest level, so that they do not turn either.
void find_clamps(ClothImpl& c, std::uint32_t at) noexcept {
    Level& l = c.level[at];
    for (std::uint32_t i = 0; i < l.rows; ++i)
        for (std::uint32_t j = 0; j < l.cols; ++j) {
            std::uint8_t& bits = l.clamped[i * l.cols + j];
            bits = 0;
            if (l.free[i * l.on.pitch + j] != 0) continue;
            for (int w = 0; w < 4; ++w) {
                const std::uint32_t r = i + static_cast<std::uint32_t>(kWays[w][0]),
                                    s = j + static_cast<std::uint32_t>(kWays[w][1]);
                if (r < l.rows && s < l.cols && l.free[r * l.on.pitch + s] == 0)
                    bits |= static_cast<std::uint8_t>(1 << w);
            }
            if (at > 0) bits |= c.level[at - 1].clamped[l.row_of[i] * c.level[at - 1].cols + l.column_of[j]];
        }
}
/// What is held, on all levels.
void hold(ClothImpl& c) noexcept {
    for (std::uint32_t k = 0; k < c.levels; ++k) {
        Level& l = c.level[k];
        for (std::uint32_t i = 0; k > 0 && i < l.rows; ++i)
            for (std::uint32_t j = 0; j < l.cols; ++j) {
                const Level& fine = c.level[k - 1];
                l.free[i * l.on.pitch + j] = fine.free[l.row_of[i] * fine.on.pitch + l.column_of[j]];
            }
        find_clamps(c, k);
    }
}
/// Beside a clamped sample a coarse level bends as if it were mirrored there.
void add_clamps(Level& l, float density) noexcept {
    const Sheet& on = l.on;
    for (std::uint32_t i = 0; i < l.rows; ++i)
        for (std::uint32_t j = 0; j < l.cols; ++j) {
            const std::uint8_t bits = l.clamped[i * l.cols + j];
            for (int w = 0; bits != 0 && w < 4; ++w) {
                const std::uint32_t r = i + static_cast<std::uint32_t>(kWays[w][0]),
                                    s = j + static_cast<std::uint32_t>(kWays[w][1]);
                if ((bits >> w & 1) == 0 || r >= l.rows || s >= l.cols) continue;
                const auto to = static_cast<Spot>(r * on.pitch + s);
                const std::uint32_t q = std::min({i, r, l.rows - 2}), p = std::min({j, s, l.cols - 2});
                const auto quad = static_cast<Spot>(q * on.pitch + p);
                const float by = w < 2 ? on.q11[quad] : on.q22[quad];
                const float mass = on.mass[i * on.pitch + j] / density;
                const float add = 4 * on.plate * mass * ((by * by) * (by * by));
                on.press[to] += add;
                on.drag[to] += add;
                on.touched[r] = 1;
            }
        }
}
}  // namespace

double prepare(ClothImpl& c, float by_dt2, std::uint32_t levels) noexcept {
    if (c.held_anew) hold(c);
    c.held_anew = false;
    for (std::uint32_t k = 1; k < levels; ++k) {
        const Level &l = c.level[k], &before = c.level[k - 1];
        const Sheet& fine = before.on;
        ThinJob thin{&fine, &l.on, {}, l.even, l.row_of.data(), l.column_of.data(), fine.tension1, fine.tension2};
        if (k == 1) {
            for (int d = 0; d < 3; ++d) thin.at[d] = before.at[d];
            thin.tension1 = fine.s1;
            thin.tension2 = fine.s2;
        }
        c.kernels->thin(thin);
    }
    double whole = 0;
    for (std::uint32_t k = 0; k < levels; ++k) {
        Level& l = c.level[k];
        if (k > 0) {
            c.kernels->stiffen(l.on);
            take_contacts(c, k);
            add_clamps(l, c.options.fabric.density);
        }
        InvertJob invert{l.count, l.inverse, l.free, is_whole(l) ? nullptr : l.own, {}, {}, {}, 0};
        if (k == 0) {
            invert.gradient = c.gradient;
            invert.right = l.right;
            invert.sum = l.sum;
            invert.step = Chebyshev(c).step;
        }
        double square = c.kernels->diagonal({l.on, by_dt2, is_whole(l), invert});
        if (!is_whole(l)) {
            add_seams(l);
            sum_classes(l, l.inverse.p);
            square = c.kernels->invert(invert);
        }
        if (k == 0) whole = square;
    }
    return whole;
}

}  // namespace dgm::detail::cloth
