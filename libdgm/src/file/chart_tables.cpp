// SPDX-License-Identifier: MIT
// libdgm/src/file/chart_tables.cpp
#include "file/chart_tables.h"

namespace dgm::detail {
namespace {

template <class T>
const T* elements(const Chart& chart, const char* name, std::uint64_t* offset, std::size_t* count = nullptr) noexcept {
    auto layer = chart.find(name);
    if (!layer) return nullptr;
    auto values = layer.value().as<T>();
    if (!values) return nullptr;
    if (offset != nullptr) *offset = layer.value().file_offset;
    if (count != nullptr) *count = values.value().size();
    return values.value().data();
}

PositionLayer positions(const Chart& chart, const char* name) noexcept {
    PositionLayer out;
    out.f32 = elements<float>(chart, name, &out.file_offset);
    if (out.f32 == nullptr) out.u16 = elements<std::uint16_t>(chart, name, &out.file_offset);
    return out;
}

Vec3 scaled(const double* scale, const PositionLayer& layer, std::size_t k) noexcept {
    const auto one = [&](int axis) {
        const std::size_t e = 3 * k + static_cast<std::size_t>(axis);
        // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): asked only of a layer that is there
        const double stored = layer.u16 != nullptr ? static_cast<double>(layer.u16[e]) : double{layer.f32[e]};
        const double local = scale[axis] * stored;
        // The cast of a double beyond float is undefined; validate_chart looks for infinity.
        return local > 3.4028234663852886e38 || local < -3.4028234663852886e38 ? __builtin_inff()
                                                                               : static_cast<float>(local);
    };
    return {one(0), one(1), one(2)};
}
}  // namespace

Vec3 ChartTables::position(std::uint32_t sample) const noexcept {
    if (sample < grid) return scaled(scale, geometry, sample);
    const std::uint32_t b = sample - grid;
    if (border.f32 != nullptr && geometry.u16 != nullptr)
        return {border.f32[3 * std::size_t{b}], border.f32[3 * std::size_t{b} + 1], border.f32[3 * std::size_t{b} + 2]};
    return scaled(scale, border, b);
}

Result<ChartTables> read_tables(const Chart& chart) noexcept {
    ChartTables t;
    t.rows = chart.rows();
    t.cols = chart.cols();
    t.grid = t.rows * t.cols;
    t.total = chart.sample_count();
    t.free_domain = chart.domain() == layout::Domain::kFree;
    for (std::size_t k = 0; k < 3; ++k) t.scale[k] = chart.scale()[k];
    t.geometry = positions(chart, "geometry");
    if (t.geometry.f32 == nullptr && t.geometry.u16 == nullptr)
        return Error{ErrorCode::MissingLayer, kNoOffset, "the chart has no geometry"};
    t.mask = elements<std::uint8_t>(chart, "mask", &t.mask_offset);
    if (t.free_domain && t.mask == nullptr)
        return Error{ErrorCode::MissingLayer, kNoOffset, "the chart has a free domain but no mask"};
    t.border = positions(chart, "border_geometry");
    t.border_uv = elements<float>(chart, "border_uv", &t.border_uv_offset);
    if (t.total > t.grid && ((t.border.f32 == nullptr && t.border.u16 == nullptr) || t.border_uv == nullptr))
        return Error{ErrorCode::MissingLayer, kNoOffset, "the chart has border samples without geometry or uv"};
    t.diagonals = elements<std::uint8_t>(chart, "diagonals", &t.diagonals_offset);
    t.normal = elements<std::int16_t>(chart, "normal", nullptr);
    t.border_normal = elements<std::int16_t>(chart, "border_normal", nullptr);
    t.deformation = elements<float>(chart, "deformation", &t.deformation_offset);
    t.contact = elements<float>(chart, "contact", &t.contact_offset);
    std::size_t count = 0;
    if (const auto* material = elements<float>(chart, "material", &t.material_offset, &count))
        t.material = {material, count < kMaterialValues ? 1 : kMaterialValues};
    if (const auto* faces = elements<std::uint32_t>(chart, "border_faces", &t.faces_offset, &count))
        t.faces = {faces, count};
    if (const auto* seams = elements<std::uint32_t>(chart, "seams", &t.seams_offset, &count)) t.seams = {seams, count};
    std::uint64_t at = 0;
    t.reversed = elements<std::uint8_t>(chart, "reversed", &at, &count);
    if (t.reversed != nullptr && count != t.seams.size() / 2)
        return Error{ErrorCode::BadSeamTable, at, "`reversed` is not as long as `seams`"};
    return t;
}

}  // namespace dgm::detail
