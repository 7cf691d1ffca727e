// SPDX-License-Identifier: MIT
// libdgm/src/touch/patch.cpp
// Patches: cells and their neighbours, and which of them are kept.
#include "touch/patch.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "touch/state_impl.h"
#include "touch/table_impl.h"

namespace dgm::detail {
namespace {

constexpr std::uint64_t kColumn0 = 0x0101010101010101ull, kColumn7 = kColumn0 << 7;
constexpr std::uint64_t kRow0 = 0xFF, kRow7 = kRow0 << 56;

/// Bits to the left and right as well.
std::uint64_t widened(std::uint64_t b) noexcept {
    return b | (b << 1 & ~kColumn0) | (b >> 1 & ~kColumn7);
}
std::uint64_t thickened(std::uint64_t b) noexcept {
    return b | b << 8 | b >> 8;
}

std::uint64_t whole_cell(const PatchCell& c) noexcept {
    const std::uint64_t columns = kColumn0 * ((1u << c.width) - 1);
    return c.height == 8 ? columns : columns & ((std::uint64_t{1} << (8 * c.height)) - 1);
}

/// Touches samples beside those in reach, also across the edges of cells.
void touch_neighbours(StateImpl& s, Patch& p) noexcept {
    const PatchScratch& grid = s.patch_scratch;
    const std::uint32_t count = p.count;
    for (std::uint32_t k = 0; k < count; ++k) {
        const PatchCell c = p.cells[k];
        if (c.reach == 0 || c.cell >= grid.grid_cells()) continue;
        const std::uint64_t rows = widened(c.reach), all = thickened(rows), tall = thickened(c.reach);
        p.cells[k].touched |= all & whole_cell(c);
        const std::uint32_t ci = c.cell / grid.cols, cj = c.cell % grid.cols;
        const auto spill = [&](bool there, std::uint32_t cell, std::uint64_t bits) {
            if (!there || bits == 0) return;
            PatchCell& to = p.cells[add_cell(s, p, cell)];
            to.touched |= bits & whole_cell(to);
        };
        const bool up = ci > 0, down = ci + 1 < grid.rows, left = cj > 0, right = cj + 1 < grid.cols;
        spill(left, c.cell - 1, (tall & kColumn0) << 7);
        spill(right, c.cell + 1, (tall & kColumn7) >> 7);
        spill(up, c.cell - grid.cols, (rows & kRow0) << 56);
        spill(down, c.cell + grid.cols, (rows & kRow7) >> 56);
        spill(up && left, c.cell - grid.cols - 1, (c.reach & 1) << 63);
        spill(up && right, c.cell - grid.cols + 1, (c.reach >> 7 & 1) << 56);
        spill(down && left, c.cell + grid.cols - 1, (c.reach >> 56 & 1) << 7);
        spill(down && right, c.cell + grid.cols + 1, c.reach >> 63);
    }
}

void touch_sample(StateImpl& s, Patch& p, std::uint32_t sample) noexcept {
    PatchCell& c = p.cells[add_cell(s, p, cell_of(s, sample))];
    c.touched |= std::uint64_t{1} << place_in_cell(s, sample);
}

/// Corners of the strip's faces that have one in reach.
void touch_strip(StateImpl& s, Patch& p) noexcept {
    if (s.face_start.empty()) return;
    const std::uint32_t count = p.count;
    for (std::uint32_t k = 0; k < count; ++k)
        each_bit(p.cells[k].reach, [&](std::uint32_t place) {
            const std::uint32_t sample = sample_in(p.cells[k], place, s.tables.cols);
            for (std::uint32_t f = s.face_start[sample]; f < s.face_start[sample + 1]; ++f)
                for (std::size_t e = 0; e < 3; ++e) touch_sample(s, p, s.faces[3 * std::size_t{s.face_of[f]} + e]);
        });
}

/// All copies of a seam sample have one normal, so they are touched together.
void touch_copies(StateImpl& s, Patch& p) noexcept {
    if (s.class_count == 0) return;
    for (std::uint32_t k = 0; k < p.count; ++k) {
        if (p.cells[k].cell < s.patch_scratch.grid_cells() &&
            (s.patch_scratch.flags[p.cells[k].cell] & kCellSeams) == 0)
            continue;
        each_bit(p.cells[k].touched, [&](std::uint32_t place) {
            const std::uint32_t id = s.class_id(sample_in(p.cells[k], place, s.tables.cols));
            if (id == kNone || s.footprint.class_seen[id] != 0) return;
            s.footprint.class_seen[id] = 1;
            s.footprint.classes[s.footprint.class_count++] = id;
            for (const std::uint32_t copy : s.members(id)) touch_sample(s, p, copy);
            p.crossed_seam = p.crossed_seam || (p.cells[k].reach >> place & 1) != 0;
        });
    }
    for (std::uint32_t k = 0; k < s.footprint.class_count; ++k) s.footprint.class_seen[s.footprint.classes[k]] = 0;
    s.footprint.class_count = 0;
}

/// Keeps the touched rows of a cell. Their weights move up, which never overwrites those still to come.
void keep_rows(const StateImpl& s, Patch& p, std::uint32_t k, PatchCell& c) noexcept {
    c.row = p.row_count;
    for (std::uint32_t row = 0; row < c.height; ++row) {
        std::uint32_t told = c.touched >> (8 * row) & 255;
        if (told == 0) continue;
        const std::uint32_t first = c.first + row * s.tables.cols;
        if ((s.patch_scratch.flags[c.cell] & kCellFree) != 0)
            each_bit(told, [&](std::uint32_t at) { told &= ~(s.usable(first + at) ? 0u : 1u << at); });
        p.rows[p.row_count] = {first, c.width, static_cast<std::uint8_t>(~told)};
        std::memmove(p.weight.data() + std::size_t{8} * p.row_count, p.weights(k) + 8 * row, 8 * sizeof(float));
        ++p.row_count;
    }
}

void add_bounds(const StateImpl& s, const PatchCell& c, std::uint64_t bits, RectList& list) noexcept {
    if (bits == 0) return;
    const auto lowest = [](std::uint64_t b) { return static_cast<std::uint32_t>(__builtin_ctzll(b)); };
    const auto highest = [](std::uint64_t b) { return static_cast<std::uint32_t>(63 - __builtin_clzll(b)); };
    if (c.cell >= s.patch_scratch.grid_cells()) {
        list.add_border(c.first + lowest(bits));
        list.add_border(c.first + highest(bits));
        return;
    }
    std::uint64_t columns = bits | bits >> 32;
    columns |= columns >> 16;
    columns = (columns | columns >> 8) & kRow0;
    const std::uint32_t i = c.first / s.tables.cols, j = c.first % s.tables.cols;
    list.add_near({i + lowest(bits) / 8, i + highest(bits) / 8, j + lowest(columns), j + highest(columns)});
}

/// Cells that nothing touches leave; then rows, and rectangles around groups of cells side by side.
void finish(StateImpl& s, Patch& p) noexcept {
    std::uint32_t kept = 0;
    p.samples = p.row_count = 0;
    p.moved.clear();
    p.touched.clear();
    for (std::uint32_t k = 0; k < p.count; ++k) {
        PatchCell c = p.cells[k];
        s.patch_scratch.slot_of[c.cell] = kNone;
        if (c.touched == 0) continue;
        keep_rows(s, p, k, c);
        p.cells[kept++] = c;
        p.samples += static_cast<std::uint32_t>(__builtin_popcountll(c.reach));
        add_bounds(s, c, c.reach, p.moved);
        add_bounds(s, c, c.touched, p.touched);
    }
    p.count = kept;
    p.moved.join();
    p.touched.join();
}

void weigh_mobility(const StateImpl& s, Patch& p) noexcept {
    if (s.mobility.empty()) return;
    for (std::uint32_t k = 0; k < p.count; ++k)
        each_bit(p.cells[k].reach, [&](std::uint32_t place) {
            const std::uint32_t sample = sample_in(p.cells[k], place, s.tables.cols);
            if (sample < s.tables.grid) p.weights(k)[place] = p.weights(k)[place] * s.mobility[sample];
        });
}
}  // namespace

bool make_patches(StateImpl& s, bool press) noexcept {
    PatchScratch& g = s.patch_scratch;
    g.rows = (s.tables.rows + 7) / 8;
    g.cols = (s.tables.cols + 7) / 8;
    const std::uint64_t cells = std::uint64_t{g.grid_cells()} + (s.total() - s.tables.grid + 7) / 8;
    const Allocator& a = s.allocator;
    if (!g.slot_of.allocate(a, cells, kNone) || !g.flags.allocate(a, cells)) return false;
    for (std::uint32_t k = 0; k < s.patch_count; ++k)
        if (Patch& p = s.patches[k]; !p.cells.allocate(a, cells) || !p.rows.allocate(a, 8 * cells) ||
                                     !p.weight.allocate(a, cells * kCellSamples))
            return false;
    for (std::uint32_t k = 0; k < s.total(); ++k) {
        std::uint8_t& flags = g.flags[cell_of(s, k)];
        if (s.class_id(k) != kNone) flags |= kCellSeams;
        if (k >= s.tables.grid || !s.tables.on_surface(k)) flags |= kCellFree;
        if (k < s.tables.grid && (s.ring[k] & kRingRim) != 0) flags |= kCellRim;
        if (k >= s.tables.grid || (s.ring[k] & kRingIrregular) != 0) flags |= kCellIrregular;
    }
    for (const std::uint32_t k : s.faces) g.flags[cell_of(s, k)] |= kCellFree;
    if (!press) return true;
    const std::uint64_t side = press_cells(s.max_reach);
    s.press.capacity = static_cast<std::uint32_t>(8 * std::min(cells, side * side));
    return s.press.plane.allocate(a, std::uint64_t{s.total()} + s.tables.cols + 2 * PatchPress::kPad) &&
           s.press.forms.allocate(a, std::uint64_t{kFormFloats} * s.press.capacity) &&
           s.press.saved.allocate(a, std::uint64_t{kSavedFloats} * s.press.capacity);
}

std::uint32_t cell_of(const StateImpl& s, std::uint32_t sample) noexcept {
    const PatchScratch& g = s.patch_scratch;
    if (sample >= s.tables.grid) return g.grid_cells() + (sample - s.tables.grid) / 8;
    return sample / s.tables.cols / 8 * g.cols + sample % s.tables.cols / 8;
}

std::uint32_t place_in_cell(const StateImpl& s, std::uint32_t sample) noexcept {
    if (sample >= s.tables.grid) return (sample - s.tables.grid) % 8;
    return sample / s.tables.cols % 8 * 8 + sample % s.tables.cols % 8;
}

std::uint32_t add_cell(StateImpl& s, Patch& p, std::uint32_t cell) noexcept {
    PatchScratch& g = s.patch_scratch;
    std::uint32_t& slot = g.slot_of[cell];
    if (slot != kNone) return slot;
    slot = p.count++;
    PatchCell& c = p.cells[slot];
    if (cell >= g.grid_cells()) {
        c.first = s.tables.grid + 8 * (cell - g.grid_cells());
        c.width = static_cast<std::uint8_t>(std::min(8u, s.total() - c.first));
        c.height = 1;
    } else {
        const std::uint32_t i = cell / g.cols * 8, j = cell % g.cols * 8;
        c.first = i * s.tables.cols + j;
        c.width = static_cast<std::uint8_t>(std::min(8u, s.tables.cols - j));
        c.height = static_cast<std::uint8_t>(std::min(8u, s.tables.rows - i));
    }
    c.cell = cell;
    c.reach = c.touched = 0;
    std::fill_n(p.weights(slot), kCellSamples, 0.0f);
    return slot;
}

Patch& patch_of(StateImpl& s, const TableImpl& t, const Contact& c) noexcept {
    const PatchKey key{s.representative(c.sample), c.step, c.footprint == Footprint::Geodesic, {t.hash[0], t.hash[1]}};
    Patch* oldest = s.patches;
    ++s.patch_clock;
    for (std::uint32_t k = 0; k < s.patch_count; ++k) {
        Patch& p = s.patches[k];
        if (p.key == key) {
            p.used = s.patch_clock;
            return p;
        }
        if (p.used < oldest->used) oldest = &p;
    }
    Patch& p = *oldest;
    p.key = key;
    p.used = s.patch_clock;
    p.count = 0;
    p.crossed_seam = false;
    if (s.press.patch == &p) s.press.patch = nullptr;
    Contact first = c;
    first.sample = key.sample;  // the same patch for every copy
    if (!fill_by_chords(s, t, first, p)) fill_by_front(s, t, first, p);
    weigh_mobility(s, p);
    touch_neighbours(s, p);
    touch_strip(s, p);
    touch_copies(s, p);
    finish(s, p);
    return p;
}

}  // namespace dgm::detail
