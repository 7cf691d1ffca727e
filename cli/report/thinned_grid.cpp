// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/thinned_grid.cpp
#include "report/thinned_grid.h"

#include <dgm/grid.h>

#include <algorithm>
#include <cstddef>

namespace dgm::report {
namespace {
using model::Face;

class Thinner {
 public:
    Thinner(const model::Chart& chart, const bake::Reconstruction& full, std::uint32_t stride)
        : m_(chart.rows), n_(chart.cols), stride_(stride), full_(full) {
        down_ = (m_ - 2) / stride_ + 1;
        across_ = (n_ - 2) / stride_ + 1;
    }

    std::vector<Face> run() {
        const std::vector<std::uint32_t> quads = quads_of_faces();
        std::vector<std::uint8_t> triangles(std::size_t{m_ - 1} * (n_ - 1), 0);
        for (const std::uint32_t q : quads)
            if (q != kNone) ++triangles[q];
        whole_.assign(std::size_t{down_} * across_, true);
        for (std::uint32_t i = 0; i + 1 < m_; ++i)
            for (std::uint32_t j = 0; j + 1 < n_; ++j)
                if (triangles[std::size_t{i} * (n_ - 1) + j] != 2) whole_[block_of(i, j)] = false;
        for (std::uint32_t bi = 0; bi < down_; ++bi)
            for (std::uint32_t bj = 0; bj < across_; ++bj) {
                // A block one quad thick has no sample in its middle.
                const bool thin = end_row(bi) - bi * stride_ < 2 || end_col(bj) - bj * stride_ < 2;
                if (thin) whole_[std::size_t{bi} * across_ + bj] = false;
            }
        std::vector<Face> out;
        for (std::size_t f = 0; f < quads.size(); ++f)
            if (quads[f] == kNone || !whole_[block_of(quads[f] / (n_ - 1), quads[f] % (n_ - 1))])
                out.push_back(full_.mesh.faces[f]);
        for (std::uint32_t bi = 0; bi < down_; ++bi)
            for (std::uint32_t bj = 0; bj < across_; ++bj)
                if (whole_[std::size_t{bi} * across_ + bj]) add_block(bi, bj, out);
        return out;
    }

 private:
    static constexpr std::uint32_t kNone = 0xffffffffU;

    [[nodiscard]] std::size_t block_of(std::uint32_t i, std::uint32_t j) const {
        return std::size_t{i / stride_} * across_ + j / stride_;
    }
    [[nodiscard]] std::uint32_t end_row(std::uint32_t bi) const { return std::min((bi + 1) * stride_, m_ - 1); }
    [[nodiscard]] std::uint32_t end_col(std::uint32_t bj) const { return std::min((bj + 1) * stride_, n_ - 1); }

    /// The quad each face is half of, or kNone for the strip along a free border.
    [[nodiscard]] std::vector<std::uint32_t> quads_of_faces() const {
        std::vector<std::uint32_t> out;
        for (const Face& f : full_.mesh.faces) {
            const auto [low, high] = std::minmax({f[0], f[1], f[2]});
            std::uint32_t quad = kNone;
            if (high < std::size_t{m_} * n_) {
                std::uint32_t i0 = m_, i1 = 0, j0 = n_, j1 = 0;
                for (const std::uint32_t v : f) {
                    i0 = std::min(i0, v / n_);
                    i1 = std::max(i1, v / n_);
                    j0 = std::min(j0, v % n_);
                    j1 = std::max(j1, v % n_);
                }
                if (i1 == i0 + 1 && j1 == j0 + 1) quad = i0 * (n_ - 1) + j0;
            }
            out.push_back(quad);
        }
        return out;
    }

    [[nodiscard]] bool is_whole(std::int64_t bi, std::int64_t bj) const {
        return bi >= 0 && bj >= 0 && bi < down_ && bj < across_ &&
               whole_[static_cast<std::size_t>(bi) * across_ + static_cast<std::size_t>(bj)];
    }

    void add_block(std::uint32_t bi, std::uint32_t bj, std::vector<Face>& out) const {
        const std::uint32_t i0 = bi * stride_, i1 = end_row(bi), j0 = bj * stride_, j1 = end_col(bj);
        std::vector<std::uint32_t> ring;  // counter-clockwise in (u, v), as quad_triangles
        const auto at = [&](std::uint32_t i, std::uint32_t j) {
            return static_cast<std::uint32_t>(sample_index(i, j, n_));
        };
        const bool left = !is_whole(bi, std::int64_t{bj} - 1), low = !is_whole(std::int64_t{bi} + 1, bj);
        const bool right = !is_whole(bi, std::int64_t{bj} + 1), high = !is_whole(std::int64_t{bi} - 1, bj);
        for (std::uint32_t i = i0; i < i1; i += left ? 1 : i1 - i0) ring.push_back(at(i, j0));
        for (std::uint32_t j = j0; j < j1; j += low ? 1 : j1 - j0) ring.push_back(at(i1, j));
        for (std::uint32_t i = i1; i > i0; i -= right ? 1 : i1 - i0) ring.push_back(at(i, j1));
        for (std::uint32_t j = j1; j > j0; j -= high ? 1 : j1 - j0) ring.push_back(at(i0, j));
        if (ring.size() == 4) {
            const auto& p = full_.mesh.positions;
            if (length(p[ring[0]] - p[ring[2]]) <= length(p[ring[1]] - p[ring[3]])) {
                out.push_back({ring[0], ring[1], ring[2]});
                out.push_back({ring[0], ring[2], ring[3]});
            } else {
                out.push_back({ring[0], ring[1], ring[3]});
                out.push_back({ring[1], ring[2], ring[3]});
            }
            return;
        }
        const std::uint32_t middle = at((i0 + i1) / 2, (j0 + j1) / 2);
        for (std::size_t k = 0; k < ring.size(); ++k) out.push_back({middle, ring[k], ring[(k + 1) % ring.size()]});
    }

    std::uint32_t m_, n_, stride_, down_ = 1, across_ = 1;
    const bake::Reconstruction& full_;
    std::vector<bool> whole_;  // per block: made of whole quads, and coarse in the result
};
}  // namespace

std::vector<Face> thinned_faces(const model::Chart& chart, const bake::Reconstruction& full, std::uint32_t stride) {
    if (stride <= 1) return full.mesh.faces;
    return Thinner(chart, full, stride).run();
}

}  // namespace dgm::report
