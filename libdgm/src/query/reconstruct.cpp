// SPDX-License-Identifier: MIT
// libdgm/src/query/reconstruct.cpp
// Paper section 4.3: implicit connectivity to vertices and triangles.
#include <dgm/reconstruct.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include <dgm/octahedral.h>

#include "base/half.h"
#include "query/mesh_indices.h"
#include "touch/state_impl.h"

// Vectors stay in this file, so the calling convention of a target without SSE does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

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
            // Clamped before the cast: a double beyond float has none.
            return to_unit(static_cast<float>(std::clamp((double{v} - from) / step / 65535, -1.0, 2.0)));
        };
        shorts(k, target_.position_offset, place(p.x, o.x, s.x), place(p.y, o.y, s.y), place(p.z, o.z, s.z));
    }
    void normal(std::uint32_t k, Vec3 n) const noexcept {
        if (target_.normal_format == VertexFormat::F32) return store(k, target_.normal_offset, &n, sizeof n);
        const bool half = target_.normal_format == VertexFormat::F16;
        const auto code = [half](float v) { return half ? to_half(v) : to_unit(0.5f * v + 0.5f); };
        shorts(k, target_.normal_offset, code(n.x), code(n.y), code(n.z));
    }
    /// f32 for sample k of [k, k + count), or null: another format.
    [[nodiscard]] std::byte* plain_positions(std::uint32_t k) const noexcept {
        return target_.position_format == VertexFormat::F32 ? at(k, target_.position_offset) : nullptr;
    }
    [[nodiscard]] std::byte* plain_normals(std::uint32_t k) const noexcept {
        return target_.normal_format == VertexFormat::F32 ? at(k, target_.normal_offset) : nullptr;
    }
    /// Both as f32, normals right behind positions.
    [[nodiscard]] bool paired() const noexcept {
        return wants_position() && wants_normal() && target_.position_format == VertexFormat::F32 &&
               target_.normal_format == VertexFormat::F32 &&
               target_.normal_offset == target_.position_offset + 3 * sizeof(float);
    }
    [[nodiscard]] std::size_t stride() const noexcept { return target_.stride; }
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
        std::memcpy(at(k, offset), value, bytes);
    }
    [[nodiscard]] std::byte* at(std::uint32_t k, std::size_t offset) const noexcept {
        return target_.memory.data() + k * target_.stride + offset;
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

/// Vertices side by side from planes.
void interleave(const ConstPlanes& from, std::uint32_t count, std::byte* to, std::size_t stride) noexcept {
    for (std::uint32_t k = 0; k < count; ++k, to += stride) {
        const float v[3] = {from.x[k], from.y[k], from.z[k]};
        std::memcpy(to, v, sizeof v);
    }
}

typedef float Four __attribute__((vector_size(16)));
Four four(const float* p) noexcept {
    Four v;
    std::memcpy(&v, p, sizeof v);
    return v;
}
#if defined(__clang__) || __GNUC__ >= 12
#define DGM_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define DGM_SHUFFLE(a, b, ...) __builtin_shuffle(a, b, (__attribute__((vector_size(16))) int){__VA_ARGS__})
#endif

/// Positions with their normals right behind: four vertices at a time are turned in registers.
void interleave(const ConstPlanes& p, const ConstPlanes& n, std::uint32_t count, std::byte* to,
                std::size_t stride) noexcept {
    std::uint32_t k = 0;
    for (; k + 4 <= count; k += 4) {
        const Four x = four(p.x + k), y = four(p.y + k), z = four(p.z + k), u = four(n.x + k), v = four(n.y + k),
                   w = four(n.z + k);
        const Four xy_low = DGM_SHUFFLE(x, y, 0, 4, 1, 5), xy_high = DGM_SHUFFLE(x, y, 2, 6, 3, 7);
        const Four zu_low = DGM_SHUFFLE(z, u, 0, 4, 1, 5), zu_high = DGM_SHUFFLE(z, u, 2, 6, 3, 7);
        const Four vw[2] = {DGM_SHUFFLE(v, w, 0, 4, 1, 5), DGM_SHUFFLE(v, w, 2, 6, 3, 7)};
        const Four xyzu[4] = {DGM_SHUFFLE(xy_low, zu_low, 0, 1, 4, 5), DGM_SHUFFLE(xy_low, zu_low, 2, 3, 6, 7),
                              DGM_SHUFFLE(xy_high, zu_high, 0, 1, 4, 5), DGM_SHUFFLE(xy_high, zu_high, 2, 3, 6, 7)};
        for (int e = 0; e < 4; ++e, to += stride) {
            std::memcpy(to, &xyzu[e], sizeof(Four));
            std::memcpy(to + sizeof(Four), reinterpret_cast<const std::byte*>(vw) + 8 * e, 8);
        }
    }
    for (; k < count; ++k, to += stride) {
        const float v[6] = {p.x[k], p.y[k], p.z[k], n.x[k], n.y[k], n.z[k]};
        std::memcpy(to, v, sizeof v);
    }
}
#undef DGM_SHUFFLE

void put_normals(const VertexWriter& out, std::uint32_t k, std::uint32_t count, const ConstPlanes& n) noexcept {
    if (std::byte* to = out.plain_normals(k)) return interleave(n, count, to, out.stride());
    for (std::uint32_t e = 0; e < count; ++e) out.normal(k + e, StateImpl::at(n, e));
}

/// Grid samples stored as they are given out. @return false: something else has to be done with them.
bool copy_grid_positions(const ChartTables& t, const VertexWriter& out) noexcept {
    std::byte* to = out.plain_positions(0);
    const float* from = t.geometry.f32;
    if (to == nullptr || from == nullptr || t.scale[0] != 1 || t.scale[1] != 1 || t.scale[2] != 1) return false;
    constexpr std::size_t kSample = 3 * sizeof(float);
    constexpr std::uint32_t kChunk = 512;  // small enough to be still near when it is copied
    for (std::uint32_t k = 0; k < t.grid; k += kChunk) {
        const std::uint32_t count = std::min(kChunk, t.grid - k);
        std::uint32_t carried = 0;  // into the sign: the exponent is all ones, no finite number
        for (std::uint32_t e = 0; e < 3 * count; ++e)
            carried |= (__builtin_bit_cast(std::uint32_t, from[e]) & 0x7FFFFFFFu) + 0x00800000u;
        if ((carried & 0x80000000u) != 0) return false;
        if (out.stride() == kSample) {
            std::memcpy(to, from, count * kSample);
            to += count * kSample;
            from += 3 * std::size_t{count};
        } else {
            for (std::uint32_t e = 0; e < count; ++e, to += out.stride(), from += 3) std::memcpy(to, from, kSample);
        }
    }
    return true;
}

Result<void> write_stored_positions(const ChartTables& t, const VertexWriter& out) noexcept {
    for (std::uint32_t k = copy_grid_positions(t, out) ? t.grid : 0; k < t.total; ++k) {
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
    constexpr std::uint32_t kChunk = 256;
    float memory[3][kChunk];
    for (std::uint32_t k = 0; k < t.total;) {
        const bool inside = k < t.grid;
        const std::int16_t* code =
            inside ? t.normal + 2 * std::size_t{k} : t.border_normal + 2 * std::size_t{k - t.grid};
        const std::uint32_t count = std::min(kChunk, (inside ? t.grid : t.total) - k);
        for (std::uint32_t e = 0; e < count; ++e) {
            const auto n = decode_octahedral(code[2 * e], code[2 * e + 1]);
            memory[0][e] = n[0];
            memory[1][e] = n[1];
            memory[2][e] = n[2];
        }
        put_normals(out, k, count, {memory[0], memory[1], memory[2]});
        k += count;
    }
    return {};
}

/// make_indices() into as much memory as was counted: all of it is written, even if the file has changed since.
Result<void> write_indices(const ChartTables& t, const ReconstructOptions& options,
                           std::span<std::uint32_t> out) noexcept {
    auto made = make_indices(t, options, out);
    if (!made) return made.error();
    const std::uint64_t written = std::min<std::uint64_t>(made.value(), out.size());
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(written), out.end(), 0u);
    return {};
}

/// Triangles of all quads and border faces, as make_indices() has them. `out` is as long as was counted.
Result<void> write_triangles(const ChartTables& tables, std::span<std::uint32_t> out) noexcept {
    const ChartTables t = tables;  // for all the compiler knows, writes could go to the caller's
    unsigned all = 0;
    if (t.diagonals != nullptr)
        for (std::size_t k = 0; k < std::size_t{t.rows - 1} * (t.cols - 1); ++k) all |= t.diagonals[k];
    bool good = all <= 1;
    for (const std::uint32_t v : t.faces) good = good && v < t.total;
    if (!good) return write_indices(t, {}, out);  // off the surface, or an error
    std::uint32_t* to = out.data();
    std::size_t left = out.size();  // the file may change under us
    for (std::uint32_t i = 0; i + 1 < t.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < t.cols; ++j) {
            if (!t.has_quad(i, j) || left < 6) continue;
            const std::uint32_t a = i * t.cols + j, b = a + t.cols;
            const std::uint32_t turned = (t.diagonal(i, j) & 1) * t.cols;  // diagonals cannot be predicted
            to[0] = a;
            to[1] = b;
            to[2] = b + 1 - turned;
            to[3] = a + turned;
            to[4] = b + 1;
            to[5] = a + 1;
            to += 6;
            left -= 6;
        }
    const std::size_t corners = std::min(left, t.faces.size() / 3 * 3);
    for (std::size_t k = 0; k < corners; ++k) to[k] = corner_of_face(t, k);
    std::fill_n(to + corners, left - corners, 0u);  // 0 of them, unless the file has changed since they were counted
    return {};
}

/// Some sample of the run, or a neighbour, has moved since the normals were brought up to date.
bool is_stale(const StateImpl& s, std::uint32_t k, std::uint32_t count) noexcept {
    const std::uint32_t i = k / s.tables.cols, j = k % s.tables.cols;
    const Rect around{i == 0 ? 0 : i - 1, i + 1, j == 0 ? 0 : j - 1, j + count};
    for (std::uint32_t r = 0; r < s.normal_dirty.count; ++r)
        if (s.normal_dirty.rects[r].meets(around)) return true;
    return false;
}

/// Normals of samples k .. k + count - 1 of a row of the grid, as sample_normal() has them. Irregular ones may have
/// neighbours anywhere.
void row_normals(const StateImpl& s, std::uint32_t k, std::uint32_t count, const Planes& to) noexcept {
    const auto inside = [&](std::uint32_t e) { return (s.ring[e] & kRingIrregular) == 0; };
    const ConstPlanes shape = StateImpl::fixed(s.now);
    const auto one = [&](std::uint32_t e) {
        const Vec3 n = sample_normal(s, shape, k + e);
        to.x[e] = n.x;
        to.y[e] = n.y;
        to.z[e] = n.z;
    };
    const bool stale = is_stale(s, k, count);
    for (std::uint32_t e = 0; e < count;) {
        std::uint32_t end = e;
        while (end < count && inside(k + end)) ++end;
        if (!stale) {
            std::copy_n(s.normal.x + k + e, end - e, to.x + e);
            std::copy_n(s.normal.y + k + e, end - e, to.y + e);
            std::copy_n(s.normal.z + k + e, end - e, to.z + e);
        } else if (end != e && !normals_inside(s, shape, k + e, end - e, {to.x + e, to.y + e, to.z + e}))
            for (; e < end; ++e) one(e);
        for (e = end; e < count && !inside(k + e); ++e) one(e);
    }
}

/// Positions too if they go together.
void write_normals(const StateImpl& s, const VertexWriter& out) noexcept {
    constexpr std::uint32_t kChunk = 256;
    float memory[3][kChunk];
    const Planes chunk{memory[0], memory[1], memory[2]};
    const bool kept = s.normal_dirty.empty();
    for (std::uint32_t k = 0; k < s.total();) {
        const std::uint32_t row_end = k < s.tables.grid ? (k / s.tables.cols + 1) * s.tables.cols : s.total();
        const std::uint32_t count = std::min(kChunk, row_end - k);
        ConstPlanes n{s.normal.x + k, s.normal.y + k, s.normal.z + k};
        if (!kept) {
            if (k < s.tables.grid)
                row_normals(s, k, count, chunk);
            else
                for (std::uint32_t e = 0; e < count; ++e) {
                    const Vec3 v = sample_normal(s, StateImpl::fixed(s.now), k + e);
                    chunk.x[e] = v.x;
                    chunk.y[e] = v.y;
                    chunk.z[e] = v.z;
                }
            n = StateImpl::fixed(chunk);
        }
        if (out.paired())
            interleave({s.now.x + k, s.now.y + k, s.now.z + k}, n, count, out.plain_positions(k), out.stride());
        else
            put_normals(out, k, count, n);
        k += count;
    }
}

/// Counts, sizes and indices, which baked and deformed surfaces share. `write` fills the vertices.
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
        const std::span<std::uint32_t> out = indices.first(static_cast<std::size_t>(counts.indices));
        const bool plain = options.lod_stride == 1 && options.topology == IndexTopology::Triangles;
        if (auto r = plain ? write_triangles(t, out) : write_indices(t, options, out); !r) return r.error();
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
                                  if (out.wants_normal()) detail::write_normals(s, out);
                                  if (!out.wants_position() || out.paired()) return {};
                                  if (std::byte* to = out.plain_positions(0))
                                      detail::interleave(detail::StateImpl::fixed(s.now), s.total(), to, out.stride());
                                  else
                                      for (std::uint32_t k = 0; k < s.total(); ++k) out.position(k, s.point(k));
                                  return {};
                              });
}

}  // namespace dgm
