// SPDX-License-Identifier: MIT
// libdgm/src/file/validate.cpp
#include <dgm/validate.h>

#include <cmath>
#include <cstring>

#include <dgm/limits.h>

#include "base/memory.h"
#include "file/chart_tables.h"
#include "file/validate_impl.h"

namespace dgm {
namespace detail {
namespace {

Result<void> check_flags(const std::uint8_t* values, std::size_t count, std::uint64_t offset,
                         const char* message) noexcept {
    for (std::size_t k = 0; k < count; ++k)
        if (values[k] > 1) return Error{ErrorCode::BadValue, offset + k, message};
    return {};
}

Result<void> check_faces(const ChartTables& t) noexcept {
    for (std::size_t f = 0; f + 2 < t.faces.size(); f += 3) {
        std::uint32_t v[3];
        for (std::size_t k = 0; k < 3; ++k) v[k] = load_once(t.faces.data() + f + k);
        for (std::size_t k = 0; k < 3; ++k)
            if (v[k] >= t.total || !t.on_surface(v[k]))
                return Error{ErrorCode::BadValue, t.faces_offset + 4 * (f + k),
                             "a border face names no sample of the surface"};
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
            return Error{ErrorCode::BadValue, t.faces_offset + 4 * f, "a border face has two equal corners"};
    }
    return {};
}

/// Tools look for seams where the border is: on the grid's in a square, among the border samples in a free domain.
bool may_have_class(const ChartTables& t, std::uint32_t sample) noexcept {
    if (sample >= t.total || !t.on_surface(sample)) return false;
    if (t.free_domain) return sample >= t.grid;
    const std::uint32_t i = sample / t.cols, j = sample % t.cols;
    return i == 0 || j == 0 || i + 1 == t.rows || j + 1 == t.cols;
}

/// Numbers are checked again: the file may have been overwritten since `weld` was made of it.
Result<void> check_copies(const ChartTables& t, const Array<std::uint32_t>& weld) noexcept {
    for (std::size_t k = 0; k + 1 < t.seams.size(); k += 2) {
        const std::uint32_t representative = load_once(t.seams.data() + k), copy = load_once(t.seams.data() + k + 1);
        if (representative >= t.total || copy >= t.total || weld[representative] != representative)
            return Error{ErrorCode::BadSeamTable, t.seams_offset + 4 * k, "a representative is a copy itself"};
        const Vec3 a = t.position(representative), b = t.position(copy);
        // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): the same bits, as the format has it
        if (std::memcmp(&a, &b, sizeof a) != 0)
            return Error{ErrorCode::SeamGap, t.position_offset(copy), "copies of a weld class differ"};
    }
    return {};
}

Result<void> check_seams(const ChartTables& t, const Allocator& allocator) noexcept {
    Array<std::uint32_t> weld;  // representative of each sample
    if (t.seams.empty()) return {};
    if (!weld.allocate(allocator, t.total))
        return Error{ErrorCode::OutOfMemory, kNoOffset, "no memory for the weld classes"};
    for (std::uint32_t s = 0; s < t.total; ++s) weld[s] = s;
    for (std::size_t k = 0; k + 1 < t.seams.size(); k += 2) {
        const std::uint32_t representative = load_once(t.seams.data() + k), copy = load_once(t.seams.data() + k + 1);
        const std::uint64_t at = t.seams_offset + 4 * k;
        if (!may_have_class(t, representative) || !may_have_class(t, copy))
            return Error{ErrorCode::BadSeamTable, at, "a seam pair names no sample of the border"};
        if (representative >= copy)
            return Error{ErrorCode::BadSeamTable, at, "the representative is not the lowest of its class"};
        if (weld[copy] != copy) return Error{ErrorCode::BadSeamTable, at, "a sample is a copy twice"};
        weld[copy] = representative;
    }
    return check_copies(t, weld);
}

Result<void> check_positions(const ChartTables& t) noexcept {
    for (std::uint32_t s = 0; s < t.total; ++s) {
        if (!t.on_surface(s)) continue;
        const Vec3 p = t.position(s);
        const float largest = std::fmax(std::fmax(std::fabs(p.x), std::fabs(p.y)), std::fabs(p.z));
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            return Error{ErrorCode::NotFinite, t.position_offset(s), "a position is not finite"};
        if (!(largest <= kMaxCoordinate))
            return Error{ErrorCode::BadValue, t.position_offset(s), "a coordinate is beyond 1e18"};
    }
    return {};
}

/// E, F, G, stiffness and mobility of samples on the surface.
Result<void> check_behaviour(const ChartTables& t) noexcept {
    for (std::uint32_t s = 0; s < t.grid; ++s) {
        if (!t.on_surface(s)) continue;
        for (std::size_t e = 0; t.deformation != nullptr && e < 4; ++e)
            if (!is_behaviour(e, load_once(t.deformation + 4 * std::size_t{s} + e)))
                return Error{ErrorCode::BadValue, t.deformation_offset + 4 * (4 * std::uint64_t{s} + e),
                             e == 3 ? "stiffness is not in 0..1" : "the first fundamental form is out of range"};
        if (t.contact != nullptr && !is_behaviour(3, load_once(t.contact + 2 * std::size_t{s} + 1)))
            return Error{ErrorCode::BadValue, t.contact_offset + 4 * (2 * std::uint64_t{s} + 1),
                         "mobility is not in 0..1"};
    }
    return {};
}
}  // namespace

bool is_behaviour(std::size_t element, float v) noexcept {
    if (element == 3) return v >= 0 && v <= 1;
    return element == 1 ? std::fabs(v) <= kMaxForm : v >= 0 && v <= kMaxForm;
}

Result<void> check_values(const ChartTables& t, const Allocator& allocator) noexcept {
    const auto grid = std::size_t{t.grid};
    if (t.mask != nullptr)
        if (auto r = check_flags(t.mask, grid, t.mask_offset, "the mask is neither 0 nor 1"); !r) return r;
    if (t.diagonals != nullptr)
        if (auto r = check_flags(t.diagonals, std::size_t{t.rows - 1} * (t.cols - 1), t.diagonals_offset,
                                 "a diagonal is neither 0 nor 1");
            !r)
            return r;
    if (auto r = check_positions(t); !r) return r;
    for (std::size_t k = 0; k < 2 * std::size_t{t.total - t.grid}; ++k)
        if (!(t.border_uv[k] >= 0.0f && t.border_uv[k] <= 1.0f))
            return Error{ErrorCode::BadValue, t.border_uv_offset + 4 * k,
                         "a border sample lies outside the unit square"};
    if (auto r = check_faces(t); !r) return r;
    if (auto r = check_behaviour(t); !r) return r;
    for (std::size_t k = 0; k < t.material.size(); ++k) {
        const float v = t.material[k];
        if (!(v >= kMaterialLow[k] && v <= kMaterialHigh[k]))
            return Error{ErrorCode::BadValue, t.material_offset + 4 * k, "a number of the material is out of range"};
    }
    return check_seams(t, allocator);
}

}  // namespace detail

Result<void> validate_chart(const Chart& chart, const Allocator& allocator) noexcept {
    if (!detail::is_valid(allocator)) return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    auto tables = detail::read_tables(chart);
    if (!tables) return tables.error();
    return detail::check_values(tables.value(), allocator);
}

}  // namespace dgm
