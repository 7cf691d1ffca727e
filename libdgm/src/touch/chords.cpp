// SPDX-License-Identifier: MIT
// libdgm/src/touch/chords.cpp
// Distances by straight lines where they are certain (patch.h has the reason).
//
// Cells around the contact are visited as long as samples at their edges are in reach, across seams from copy to copy:
// a sample's chord does not depend on the chart around it, so all copies get the same bits.
#include <cmath>

#include "touch/patch.h"
#include "touch/state_impl.h"
#include "touch/table_impl.h"

namespace dgm::detail {
namespace {

class Chords {
 public:
    Chords(StateImpl& s, const TableImpl& t, const Contact& c, Patch& p) noexcept
        : s_(s), p_(p), at_(StateImpl::at(s.rest, c.sample)) {
        const TableImpl::Tolerance& tolerance = t.tolerance[c.footprint == Footprint::Geodesic ? 0 : 1];
        const float reach = static_cast<float>(t.options.reach) * c.step, quiet = tolerance.quiet * c.step;
        quiet2_ = quiet * quiet;
        job_.cols = s.tables.cols;
        job_.at = StateImpl::fixed(s.rest);
        job_.normal = StateImpl::fixed(s.rest_normal);
        job_.rough = s.rough;
        job_.reach2 = reach * reach;
        job_.slant2 = tolerance.slant2;
        job_.sharp = s.rough[c.sample] > kSharp;
        const Vec3 n = StateImpl::at(s.rest_normal, c.sample);
        const float centre[6] = {at_.x, at_.y, at_.z, n.x, n.y, n.z};
        for (int k = 0; k < 3; ++k) {
            job_.centre[k] = centre[k];
            job_.axis[k] = centre[3 + k];
        }
    }

    /// Squared distances into the patch's weights.
    [[nodiscard]] bool run(std::uint32_t sample) noexcept {
        if (!(job_.slant2 > 0)) return false;
        visit(cell_of(s_, sample));
        for (std::uint32_t k = 0; k < p_.count; ++k)
            if (!look_at(k)) return false;
        return true;
    }

 private:
    void visit(std::uint32_t cell) noexcept { static_cast<void>(add_cell(s_, p_, cell)); }

    /// @return false if a chord is uncertain.
    bool look_at(std::uint32_t k) noexcept {
        PatchCell& c = p_.cells[k];
        const std::uint8_t flags = s_.patch_scratch.flags[c.cell];
        if ((flags & kCellFree) != 0) return false;
        job_.cell = c;
        const ChordResult found = s_.rows_of->chords(job_, p_.weights(k));
        if (found.steep || found.doubtful < quiet2_) return false;
        c.reach = found.reach;
        if (c.reach == 0) return true;
        if ((flags & kCellRim) != 0 && !rim_is_clear(c)) return false;
        if ((flags & kCellSeams) != 0) cross_seams(c);
        spread(c.cell, c.reach);
        return true;
    }

    void spread(std::uint32_t cell, std::uint64_t reach) noexcept {
        const PatchScratch& g = s_.patch_scratch;
        const std::uint32_t ci = cell / g.cols, cj = cell % g.cols;
        const bool up = ci > 0, down = ci + 1 < g.rows, left = cj > 0, right = cj + 1 < g.cols;
        constexpr std::uint64_t kLeft = 0x0101010101010101ull;
        const auto go = [&](bool there, std::uint32_t to, std::uint64_t edge) {
            if (there && (reach & edge) != 0) visit(to);
        };
        go(left, cell - 1, kLeft);
        go(right, cell + 1, kLeft << 7);
        go(up, cell - g.cols, 0xFF);
        go(down, cell + g.cols, std::uint64_t{0xFF} << 56);
        go(up && left, cell - g.cols - 1, 1);
        go(up && right, cell - g.cols + 1, 1u << 7);
        go(down && left, cell + g.cols - 1, std::uint64_t{1} << 56);
        go(down && right, cell + g.cols + 1, std::uint64_t{1} << 63);
    }

    void cross_seams(const PatchCell c) noexcept {
        each_bit(c.reach, [&](std::uint32_t place) {
            const std::uint32_t sample = sample_in(c, place, s_.tables.cols), id = s_.class_id(sample);
            if (id == kNone || s_.members(id)[0] != sample) {
                // The first copy in reach leads to all others: they have its bits, so that they are in reach too.
                if (id != kNone) visit(cell_of(s_, s_.members(id)[0]));
                return;
            }
            for (const std::uint32_t copy : s_.members(id).subspan(1)) visit(cell_of(s_, copy));
        });
    }

    /// A way downhill must not run off an open border: nowhere does the line to the contact point outwards.
    [[nodiscard]] bool rim_is_clear(const PatchCell c) const noexcept {
        bool clear = true;
        each_bit(c.reach, [&](std::uint32_t place) {
            const std::uint32_t sample = sample_in(c, place, s_.tables.cols);
            if ((s_.ring[sample] & kRingRim) == 0) return;
            if (s_.class_id(sample) != kNone) {  // a seam ends at the border: ways bend there or run past it
                if ((s_.geodesic.corners[s_.representative(sample)] & kCornerBends) != 0) clear = false;
                return;
            }
            const Vec3 way = at_ - StateImpl::at(s_.rest, sample), out = outwards(sample);
            const float slant = dot(way, out), way2 = dot(way, way);
            if (slant <= 0) return;
            const float limit = slant * slant / dot(out, out);
            if (limit > kSteep * kSteep * way2 || (limit > job_.slant2 * way2 && way2 < quiet2_)) clear = false;
        });
        return clear;
    }

    /// From a border sample of the grid, square to the border, tangent to the surface.
    [[nodiscard]] Vec3 outwards(std::uint32_t sample) const noexcept {
        const std::uint32_t n = s_.tables.cols, m = s_.tables.rows, i = sample / n, j = sample % n;
        const bool row = i == 0 || i + 1 == m;
        const std::uint32_t inner = row ? (i == 0 ? sample + n : sample - n) : (j == 0 ? sample + 1 : sample - 1);
        const std::uint32_t step = row ? 1 : n, place = row ? j : i, last = row ? n - 1 : m - 1;
        const Vec3 along = StateImpl::at(s_.rest, place < last ? sample + step : sample) -
                           StateImpl::at(s_.rest, place > 0 ? sample - step : sample);
        const Vec3 out = StateImpl::at(s_.rest, sample) - StateImpl::at(s_.rest, inner);
        const float length2 = dot(along, along);
        return length2 > 0 ? out - (dot(out, along) / length2) * along : out;
    }

    StateImpl& s_;
    Patch& p_;
    const Vec3 at_;
    float quiet2_;
    ChordJob job_{};
};
}  // namespace

bool fill_by_chords(StateImpl& s, const TableImpl& t, const Contact& c, Patch& p) noexcept {
    if (c.sample >= s.tables.grid || !Chords(s, t, c, p).run(c.sample)) {
        for (std::uint32_t k = 0; k < p.count; ++k) s.patch_scratch.slot_of[p.cells[k].cell] = kNone;
        p.count = 0;
        return false;
    }
    const Weigher weigher(s, t, c);
    const float reach = static_cast<float>(t.options.reach), per_step = 1 / c.step;
    if (weigher.even()) {
        ProfileJob job{0,        t.entries.data(), static_cast<std::uint32_t>(t.entries.size() - 1),
                       per_step, t.spacing,        reach};
        for (std::uint32_t k = 0; k < p.count; ++k) {
            job.reach = p.cells[k].reach;
            s.rows_of->profile(job, p.weights(k));
        }
        return true;
    }
    for (std::uint32_t k = 0; k < p.count; ++k) {
        float* values = p.weights(k);
        for (std::uint32_t place = 0; place < kCellSamples; ++place)
            values[place] =
                (p.cells[k].reach >> place & 1) == 0
                    ? 0
                    : weigher.at(sample_in(p.cells[k], place, s.tables.cols), std::sqrt(values[place]) * per_step);
    }
    return true;
}

}  // namespace dgm::detail
