// SPDX-License-Identifier: MIT
// libdgm/src/query/mesh_indices.cpp
// Level of detail by stride: the grid is cut into blocks of at least `stride` quads a side, each two triangles.
//
// Closed borders: a side of a block on the chart's border, or beside a block that is not whole (free domains), keeps
// all its samples, and the block becomes a fan around a sample of its middle. So seams stay closed whatever strides
// either side has, since both keep the samples that the seam table makes equal. A block that is not whole keeps its
// quads.
//
// Strips: along a row of quads split one way, a0 b0 a1 b1 ... for diagonal 1 and b0 b0 a0 b1 a1 ... for diagonal 0
// (every other triangle of a strip is turned); where the diagonal changes one index is repeated. kRestart ends a strip.
#include "query/mesh_indices.h"

#include <algorithm>

#include <dgm/grid.h>

namespace dgm::detail {
namespace {

class Sink {
 public:
    Sink(std::span<std::uint32_t> out, IndexTopology topology) noexcept
        : out_(out), strips_(topology == IndexTopology::Strips) {}
    /// Corners a (i, j), b (i + 1, j), c (i + 1, j + 1), d (i, j + 1), as quad_triangles() has them.
    void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d, unsigned diagonal) noexcept {
        if (!strips_) {
            const std::uint32_t all[2][6] = {{a, b, c, a, c, d}, {a, b, d, b, c, d}};
            for (const std::uint32_t v : all[diagonal]) put(v);
            return;
        }
        if (!open_ || a != a_ || b != b_) {
            end();
            if (diagonal == 0) put(b);
            put(diagonal == 0 ? b : a);
            put(diagonal == 0 ? a : b);
        } else if (diagonal != diagonal_) {
            put(diagonal == 0 ? a : b);
        }
        put(diagonal == 0 ? c : d);
        put(diagonal == 0 ? d : c);
        open_ = true;
        a_ = d;
        b_ = c;
        diagonal_ = diagonal;
    }
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) noexcept {
        end();
        put(a);
        put(b);
        put(c);
        open_ = strips_;
        a_ = b_ = 0xFFFFFFFFu;
    }
    void end() noexcept {
        if (open_) put(kRestart);
        open_ = false;
    }
    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

 private:
    void put(std::uint32_t v) noexcept {
        if (count_ < out_.size()) out_[static_cast<std::size_t>(count_)] = v;
        ++count_;
    }
    std::span<std::uint32_t> out_;
    bool strips_, open_ = false;
    std::uint32_t a_ = 0, b_ = 0;
    unsigned diagonal_ = 0;
    std::uint64_t count_ = 0;
};

class Builder {
 public:
    Builder(const ChartTables& t, std::uint32_t stride, Sink& sink) noexcept : t_(t), sink_(sink) {
        const std::uint32_t rows = t.rows - 1, cols = t.cols - 1;
        const bool coarse = stride > 1 && rows >= 2 && cols >= 2;
        down_ = coarse ? std::max(rows / stride, 1u) : rows;
        across_ = coarse ? std::max(cols / stride, 1u) : cols;
    }
    void run() noexcept {
        for (std::uint32_t a = 0; a < down_; ++a)
            for (std::uint32_t b = 0; b < across_; ++b) block(a, b);
        sink_.end();
    }

 private:
    [[nodiscard]] std::uint32_t row(std::uint32_t a) const noexcept { return share(a, t_.rows - 1, down_); }
    [[nodiscard]] std::uint32_t col(std::uint32_t b) const noexcept { return share(b, t_.cols - 1, across_); }
    [[nodiscard]] static std::uint32_t share(std::uint32_t k, std::uint32_t quads, std::uint32_t blocks) noexcept {
        return static_cast<std::uint32_t>(std::uint64_t{k} * quads / blocks);
    }
    [[nodiscard]] bool fine() const noexcept { return down_ == t_.rows - 1; }
    [[nodiscard]] bool whole(std::int64_t a, std::int64_t b) const noexcept {
        if (a < 0 || b < 0 || a >= down_ || b >= across_) return false;
        if (t_.mask == nullptr) return true;
        const auto ua = static_cast<std::uint32_t>(a), ub = static_cast<std::uint32_t>(b);
        for (std::uint32_t i = row(ua); i < row(ua + 1); ++i)
            for (std::uint32_t j = col(ub); j < col(ub + 1); ++j)
                if (!t_.has_quad(i, j)) return false;
        return true;
    }
    void plain(std::uint32_t i, std::uint32_t j) noexcept {
        if (!t_.has_quad(i, j)) return;
        const std::uint32_t a = i * t_.cols + j, b = a + t_.cols;
        sink_.quad(a, b, b + 1, a + 1, t_.diagonal(i, j));
    }
    void block(std::uint32_t a, std::uint32_t b) noexcept {
        if (fine()) return plain(a, b);
        const std::uint32_t i0 = row(a), i1 = row(a + 1), j0 = col(b), j1 = col(b + 1);
        if (!whole(a, b)) {
            for (std::uint32_t i = i0; i < i1; ++i)
                for (std::uint32_t j = j0; j < j1; ++j) plain(i, j);
            return;
        }
        const auto at = [this](std::uint32_t i, std::uint32_t j) { return i * t_.cols + j; };
        // Sides counter-clockwise in (u, v): j = j0 along +i, i = i1 along +j, back along j = j1, i = i0.
        const std::int64_t sa = a, sb = b;
        const bool kept[4] = {!whole(sa, sb - 1), !whole(sa + 1, sb), !whole(sa, sb + 1), !whole(sa - 1, sb)};
        const std::uint32_t mi = (i0 + i1) / 2, mj = (j0 + j1) / 2;
        if (!kept[0] && !kept[1] && !kept[2] && !kept[3])
            return sink_.quad(at(i0, j0), at(i1, j0), at(i1, j1), at(i0, j1), t_.diagonal(mi, mj));
        const std::uint32_t centre = at(mi, mj);
        const auto side = [&](std::uint32_t from, std::uint32_t to, std::int64_t step, bool keep) {
            if (!keep) return sink_.triangle(centre, from, to);
            for (std::int64_t k = from; k != to; k += step)
                sink_.triangle(centre, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(k + step));
        };
        const std::int64_t n = t_.cols;
        side(at(i0, j0), at(i1, j0), n, kept[0]);
        side(at(i1, j0), at(i1, j1), 1, kept[1]);
        side(at(i1, j1), at(i0, j1), -n, kept[2]);
        side(at(i0, j1), at(i0, j0), -1, kept[3]);
    }

    const ChartTables& t_;
    Sink& sink_;
    std::uint32_t down_ = 0, across_ = 0;
};

Result<void> check_tables(const ChartTables& t) noexcept {
    if (t.diagonals != nullptr)
        for (std::uint32_t i = 0; i + 1 < t.rows; ++i)
            for (std::uint32_t j = 0; j + 1 < t.cols; ++j)
                if (t.diagonals[std::size_t{i} * (t.cols - 1) + j] > 1 && t.has_quad(i, j))
                    return Error{ErrorCode::BadValue, t.diagonals_offset + std::uint64_t{i} * (t.cols - 1) + j,
                                 "a diagonal is neither 0 nor 1"};
    for (std::size_t k = 0; k < t.faces.size() / 3 * 3; ++k)
        if (t.faces[k] >= t.total)
            return Error{ErrorCode::BadValue, t.faces_offset + 4 * k, "a border face names no sample"};
    return {};
}
}  // namespace

// Checked values may have been overwritten since: the file is mapped.
std::uint32_t corner_of_face(const ChartTables& t, std::size_t place) noexcept {
    const std::uint32_t v = load_once(t.faces.data() + place);
    return v < t.total ? v : 0;
}

Result<std::uint64_t> make_indices(const ChartTables& t, const ReconstructOptions& options,
                                   std::span<std::uint32_t> out) noexcept {
    if (auto r = check_tables(t); !r) return r.error();
    Sink sink(out, options.topology);
    Builder(t, options.lod_stride, sink).run();
    for (std::size_t k = 0; k + 2 < t.faces.size(); k += 3)
        sink.triangle(corner_of_face(t, k), corner_of_face(t, k + 1), corner_of_face(t, k + 2));
    sink.end();
    return sink.count();
}

}  // namespace dgm::detail
