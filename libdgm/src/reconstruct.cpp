// SPDX-License-Identifier: MIT
// libdgm/src/reconstruct.cpp
// Paper section 4.3: implicit connectivity to vertices and triangles.
#include <dgm/reconstruct.h>

#include <cmath>
#include <cstring>

#include <dgm/octahedral.h>

#include "half.h"
#include "mesh_indices.h"
#include "state_impl.h"

namespace dgm {
namespace detail {
namespace {

Result<void> check_options(const ReconstructOptions& options) noexcept {
    if (options.lod_stride == 0) return Error{ErrorCode::BadArgument, kNoOffset, "the stride is 0"};
    if (options.topology > IndexTopology::Strips)
        return Error{ErrorCode::Unsupported, kNoOffset, "the topology is not supported"};
    return {};
}

Result<MeshCounts> count_mesh(const ChartTables& t, const ReconstructOptions& options) noexcept {
    if (options.lod_stride != 1 || options.topology != IndexTopology::Triangles) {
        auto indices = make_indices(t, options, {});
        if (!indices) return indices.error();
        return MeshCounts{t.total, indices.value()};
    }
    std::uint64_t quads = std::uint64_t{t.rows - 1} * (t.cols - 1);
    if (t.mask != nullptr) {
        quads = 0;
        for (std::uint32_t i = 0; i + 1 < t.rows; ++i)
            for (std::uint32_t j = 0; j + 1 < t.cols; ++j) quads += t.has_quad(i, j);
    }
    return MeshCounts{t.total, 6 * quads + t.faces.size() / 3 * 3};
}

std::size_t format_bytes(VertexFormat format) noexcept {
    return format == VertexFormat::F32 ? 4 : 2;
}
std::uint16_t to_unit(float v) noexcept {
    return static_cast<std::uint16_t>(v > 0 ? (v < 1 ? v * 65535.0f + 0.5f : 65535.0f) : 0.0f);
}

/// Checked places in the caller's vertices.
class VertexWriter {
 public:
    [[nodiscard]] static Result<VertexWriter> make(const VertexTarget& target, std::uint32_t vertices) noexcept {
        for (const auto& [offset, numbers, format] : {Attribute{target.position_offset, 3, target.position_format},
                                                      Attribute{target.normal_offset, 3, target.normal_format},
                                                      Attribute{target.uv_offset, 2, target.uv_format}}) {
            if (offset == kNoAttribute) continue;
            if (format > VertexFormat::U16)
                return Error{ErrorCode::Unsupported, kNoOffset, "a vertex format is not supported"};
            const std::size_t bytes = numbers * format_bytes(format);
            if (bytes > target.stride || offset > target.stride - bytes)
                return Error{ErrorCode::BadArgument, kNoOffset, "a vertex attribute does not fit into the stride"};
        }
        if (target.position_offset != kNoAttribute && target.position_format == VertexFormat::U16 &&
            (!is_finite(target.origin) || !is_finite(target.step) ||
             !(target.step.x > 0 && target.step.y > 0 && target.step.z > 0)))
            return Error{ErrorCode::BadArgument, kNoOffset, "u16 positions need a finite origin and steps above 0"};
        std::size_t needed = 0;
        if (__builtin_mul_overflow(std::size_t{vertices}, target.stride, &needed) || needed > target.memory.size())
            return Error{ErrorCode::BufferTooSmall, kNoOffset, "the vertex memory is too small"};
        return VertexWriter(target);
    }
    [[nodiscard]] bool wants_position() const noexcept { return target_.position_offset != kNoAttribute; }
    [[nodiscard]] bool wants_normal() const noexcept { return target_.normal_offset != kNoAttribute; }
    [[nodiscard]] bool wants_uv() const noexcept { return target_.uv_offset != kNoAttribute; }
    void position(std::uint32_t k, Vec3 p) const noexcept {
        if (target_.position_format == VertexFormat::F32) return store(k, target_.position_offset, &p, sizeof p);
        const Vec3 o = target_.origin, s = target_.step;
        if (target_.position_format == VertexFormat::F16)
            return shorts(k, target_.position_offset, to_half(p.x), to_half(p.y), to_half(p.z));
        const auto place = [](float v, float from, float step) {
            return to_unit(static_cast<float>((double{v} - from) / step / 65535));
        };
        shorts(k, target_.position_offset, place(p.x, o.x, s.x), place(p.y, o.y, s.y), place(p.z, o.z, s.z));
    }
    void normal(std::uint32_t k, Vec3 n) const noexcept {
        if (target_.normal_format == VertexFormat::F32) return store(k, target_.normal_offset, &n, sizeof n);
        const bool half = target_.normal_format == VertexFormat::F16;
        const auto code = [half](float v) { return half ? to_half(v) : to_unit(0.5f * v + 0.5f); };
        shorts(k, target_.normal_offset, code(n.x), code(n.y), code(n.z));
    }
    void uv(std::uint32_t k, float x, float y) const noexcept {
        const float uv[2] = {x, y};
        if (target_.uv_format == VertexFormat::F32) return store(k, target_.uv_offset, uv, sizeof uv);
        const bool half = target_.uv_format == VertexFormat::F16;
        const std::uint16_t code[2] = {half ? to_half(x) : to_unit(x), half ? to_half(y) : to_unit(y)};
        store(k, target_.uv_offset, code, sizeof code);
    }

 private:
    struct Attribute {
        std::size_t offset, numbers;
        VertexFormat format;
    };
    void shorts(std::uint32_t k, std::size_t offset, std::uint16_t a, std::uint16_t b, std::uint16_t c) const noexcept {
        const std::uint16_t code[3] = {a, b, c};
        store(k, offset, code, sizeof code);
    }
    explicit VertexWriter(const VertexTarget& target) noexcept : target_(target) {}
    void store(std::uint32_t k, std::size_t offset, const void* value, std::size_t bytes) const noexcept {
        std::memcpy(target_.memory.data() + k * target_.stride + offset, value, bytes);
    }
    VertexTarget target_;
};

void write_uvs(const ChartTables& t, const VertexWriter& out) noexcept {
    const auto part = [](std::uint32_t k, std::uint32_t count) {
        return static_cast<float>(static_cast<double>(k) / static_cast<double>(count - 1));
    };
    for (std::uint32_t i = 0; i < t.rows; ++i)
        for (std::uint32_t j = 0; j < t.cols; ++j) out.uv(i * t.cols + j, part(j, t.cols), part(i, t.rows));
    for (std::uint32_t b = 0; b < t.total - t.grid; ++b)
        out.uv(t.grid + b, t.border_uv[2 * std::size_t{b} + 1], t.border_uv[2 * std::size_t{b}]);
}

Result<void> write_stored_positions(const ChartTables& t, const VertexWriter& out) noexcept {
    for (std::uint32_t k = 0; k < t.total; ++k) {
        Vec3 p = t.position(k);
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
            if (t.on_surface(k)) return Error{ErrorCode::NotFinite, t.position_offset(k), "a position is not finite"};
            p = {};
        }
        out.position(k, p);
    }
    return {};
}

Result<void> write_stored_normals(const ChartTables& t, const VertexWriter& out) noexcept {
    if (t.normal == nullptr || (t.total > t.grid && t.border_normal == nullptr))
        return Error{ErrorCode::MissingLayer, kNoOffset, "the chart has no normals"};
    for (std::uint32_t k = 0; k < t.total; ++k) {
        const std::int16_t* code =
            k < t.grid ? t.normal + 2 * std::size_t{k} : t.border_normal + 2 * std::size_t{k - t.grid};
        const auto n = decode_octahedral(code[0], code[1]);
        out.normal(k, {n[0], n[1], n[2]});
    }
    return {};
}

/// Counts, sizes and indices: what baked and deformed surfaces share. `write` fills the vertices.
template <class Write>
Result<MeshCounts> write_mesh(const ChartTables& t, const VertexTarget& vertices, std::span<std::uint32_t> indices,
                              const ReconstructOptions& options, Write write) noexcept {
    if (auto r = check_options(options); !r) return r.error();
    const auto counted = count_mesh(t, options);
    if (!counted) return counted.error();
    const MeshCounts counts = counted.value();
    if (!indices.empty()) {
        if (indices.size() < counts.indices)
            return Error{ErrorCode::BufferTooSmall, kNoOffset, "the index memory is too small"};
        if (auto r = make_indices(t, options, indices); !r) return r.error();
    }
    if (!vertices.memory.empty()) {
        auto out = VertexWriter::make(vertices, counts.vertices);
        if (!out) return out.error();
        if (out.value().wants_uv()) write_uvs(t, out.value());
        if (Result<void> r = write(out.value()); !r) return r.error();
    }
    return counts;
}
}  // namespace
}  // namespace detail

Result<MeshCounts> mesh_counts(const Chart& chart, const ReconstructOptions& options) noexcept {
    if (auto r = detail::check_options(options); !r) return r.error();
    auto tables = detail::read_tables(chart);
    if (!tables) return tables.error();
    return detail::count_mesh(tables.value(), options);
}

Result<MeshCounts> mesh_counts(const State& state, const ReconstructOptions& options) noexcept {
    if (auto r = detail::check_options(options); !r) return r.error();
    return detail::count_mesh(state.impl()->tables, options);
}

Result<MeshCounts> reconstruct(const Chart& chart, const VertexTarget& vertices, std::span<std::uint32_t> indices,
                               const ReconstructOptions& options) noexcept {
    auto tables = detail::read_tables(chart);
    if (!tables) return tables.error();
    const detail::ChartTables& t = tables.value();
    return detail::write_mesh(t, vertices, indices, options, [&](const detail::VertexWriter& out) -> Result<void> {
        if (out.wants_normal())
            if (auto r = detail::write_stored_normals(t, out); !r) return r;
        return out.wants_position() ? detail::write_stored_positions(t, out) : Result<void>{};
    });
}

Result<MeshCounts> reconstruct(const State& state, const VertexTarget& vertices, std::span<std::uint32_t> indices,
                               const ReconstructOptions& options) noexcept {
    const detail::StateImpl& s = *state.impl();
    return detail::write_mesh(s.tables, vertices, indices, options,
                              [&](const detail::VertexWriter& out) -> Result<void> {
                                  for (std::uint32_t k = 0; k < s.total(); ++k) {
                                      if (out.wants_position()) out.position(k, s.point(k));
                                      if (out.wants_normal())
                                          out.normal(k, detail::sample_normal(s, detail::StateImpl::fixed(s.now), k));
                                  }
                                  return {};
                              });
}

}  // namespace dgm
