// SPDX-License-Identifier: MIT
// libdgm/src/touch/press.cpp
// The quick way of a tick: a tool that stays at a sample changes the displacement of a patch and nothing else.
#include <algorithm>
#include <cstring>

#include "touch/patch.h"
#include "touch/state_impl.h"
#include "touch/table_impl.h"

namespace dgm::detail {
namespace {

/// Eight floats, or the `width` that there are.
void copy_row(float* to, const float* from, std::uint32_t width) noexcept {
    if (width == 8)
        std::memcpy(to, from, 8 * sizeof(float));
    else
        for (std::uint32_t k = 0; k < width; ++k) to[k] = from[k];
}

/// Borders, seams and strips: sums over all triangles, once for all copies.
class Irregular {
 public:
    Irregular(StateImpl& s, Patch& p) noexcept : s_(s), p_(p) {}

    void put() noexcept {
        for (std::uint32_t k = 0; k < p_.count; ++k) s_.patch_scratch.slot_of[p_.cells[k].cell] = k;
        for (std::uint32_t k = 0; k < p_.count; ++k)
            if ((s_.patch_scratch.flags[p_.cells[k].cell] & kCellIrregular) != 0) put_cell(p_.cells[k]);
        for (std::uint32_t k = 0; k < p_.count; ++k) s_.patch_scratch.slot_of[p_.cells[k].cell] = kNone;
    }

 private:
    void put_cell(const PatchCell& c) noexcept {
        for (std::uint32_t place = 0; place < 8u * c.height; ++place) {
            if ((c.touched >> place & 1) == 0 || keeps(c, place)) continue;
            const std::uint32_t sample = sample_in(c, place, s_.tables.cols);
            if (sample < s_.tables.grid && (s_.ring[sample] & kRingIrregular) == 0) continue;
            const std::uint32_t id = s_.class_id(sample);
            if (id != kNone && s_.members(id)[0] != sample) continue;
            const RingForm form =
                ring_form(s_, StateImpl::fixed(s_.base), s_.press.plane.data() + PatchPress::kPad, sample);
            if (id == kNone)
                put_form(sample, form);
            else
                for (const std::uint32_t copy : s_.members(id)) put_form(copy, form);
        }
    }
    void put_form(std::uint32_t sample, const RingForm& form) noexcept {
        const std::uint32_t place = place_in_cell(s_, sample);
        const PatchCell& c = p_.cells[s_.patch_scratch.slot_of[cell_of(s_, sample)]];
        float* to = s_.press.forms.data() + std::size_t{kFormFloats} * row_of(c, place / 8) + place % 8;
        const double scale = s_.is_reversed(sample) ? -double{s_.normal_scale} : double{s_.normal_scale};
        for (int k = 0; k < 6; ++k) to[8 * k] = static_cast<float>(form.sum[k] * scale);
    }
    [[nodiscard]] bool keeps(const PatchCell& c, std::uint32_t place) const noexcept {
        return (p_.rows[row_of(c, place / 8)].keep >> place % 8 & 1) != 0;
    }

    StateImpl& s_;
    Patch& p_;
};

/// Area vectors of the base shape around the patch, and how they grow with the displacement.
void prepare(StateImpl& s, Patch& p) noexcept {
    float* plane = s.press.plane.data() + PatchPress::kPad;
    const std::uint32_t cols = s.tables.cols;
    for (std::uint32_t r = 0; r < p.row_count; ++r) {
        const PatchRow& row = p.rows[r];
        copy_row(plane + row.first, p.weight.data() + std::size_t{8} * r, row.width);
        float* saved = s.press.saved.data() + std::size_t{kSavedFloats} * r;
        copy_row(saved, s.normal.x + row.first, row.width);
        copy_row(saved + 8, s.normal.y + row.first, row.width);
        copy_row(saved + 16, s.normal.z + row.first, row.width);
    }
    s.rows_of->rings({p.rows.data(), p.row_count, cols, s.tables.grid - cols, cols, StateImpl::fixed(s.base), plane,
                      s.ring.data(), s.normal_scale, s.press.forms.data()});
    Irregular(s, p).put();
    constexpr float kZero[8] = {};
    for (std::uint32_t r = 0; r < p.row_count; ++r) copy_row(plane + p.rows[r].first, kZero, p.rows[r].width);
}

/// Back to the base shape and its normals.
void lift(StateImpl& s, const Patch& p) noexcept {
    for (std::uint32_t r = 0; r < p.row_count; ++r) {
        const std::uint32_t at = p.rows[r].first, width = p.rows[r].width;
        copy_row(s.now.x + at, s.base.x + at, width);
        copy_row(s.now.y + at, s.base.y + at, width);
        copy_row(s.now.z + at, s.base.z + at, width);
        const float* saved = s.press.saved.data() + std::size_t{kSavedFloats} * r;
        copy_row(s.normal.x + at, saved, width);
        copy_row(s.normal.y + at, saved + 8, width);
        copy_row(s.normal.z + at, saved + 16, width);
    }
}

void start(StateImpl& s, Patch& p) noexcept {
    prepare(s, p);
    s.elastic.clear();
    s.elastic.add(p.moved);
    s.press.active = true;
    s.press.patch = &p;
    s.press.key = p.key;
}
}  // namespace

bool press_patch(StateImpl& s, const TableImpl& t, const Contact& c, DeformReport& report) noexcept {
    if (c.footprint == Footprint::Grid || c.plastic || s.press.capacity == 0 || !s.fading.empty()) return false;
    PatchPress& press = s.press;
    Patch& p = patch_of(s, t, c);
    if (p.row_count > press.capacity) return false;
    const bool ours = press.active && press.moved == s.moved && press.patch != nullptr && s.normal_dirty.empty();
    if (ours && press.key == p.key && press.d == c.d) {  // nothing changes, so nothing is marked
        report.samples = p.samples;
        report.crossed_seam = p.crossed_seam;
        return true;
    }
    press.d = c.d;
    if (!ours) {
        release_elastic(s);
        update_normals(s);
        start(s, p);
    } else if (!(press.key == p.key)) {
        lift(s, *press.patch);
        s.now_boxes.dirty.add(press.patch->moved);
        s.changes.note(press.patch->touched);
        start(s, p);
    }
    const PatchJob move{p.rows.data(), p.row_count,     StateImpl::fixed(s.base),
                        s.now,         p.weight.data(), {c.d.x, c.d.y, c.d.z}};
    const bool sure = s.rows_of->press({move, s.normal, press.forms.data(), press.saved.data()});
    s.now_boxes.dirty.add(p.moved);
    s.changes.note(p.touched);
    press.moved = ++s.moved;
    if (!sure) {
        s.normal_dirty.add(p.moved);
        update_normals(s);
    }
    report.samples = p.samples;
    report.crossed_seam = p.crossed_seam;
    return true;
}

}  // namespace dgm::detail
