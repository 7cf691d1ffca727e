// SPDX-License-Identifier: MIT
// libdgm/src/c_api/c_api.cpp
// dgm.h on top of the C++ interface, and nothing else: assets, charts, states.
#include <dgm/dgm.h>

#include <algorithm>
#include <cstring>
#include <type_traits>

#include <dgm/reconstruct.h>
#include <dgm/validate.h>

#include "c_api/c_api_impl.h"

namespace {
using dgm::ErrorCode;
using dgm::kNoOffset;
using dgm::Result;
using namespace dgm::c_api;

// dgm.h and the C++ interface number every choice alike.
static_assert(same(DGM_OK, ErrorCode::Ok));
static_assert(same(DGM_BAD_ARGUMENT, ErrorCode::BadArgument));
static_assert(same(DGM_OUT_OF_MEMORY, ErrorCode::OutOfMemory));
static_assert(same(DGM_FILE_MISSING, ErrorCode::FileMissing));
static_assert(same(DGM_READ_FAILED, ErrorCode::ReadFailed));
static_assert(same(DGM_NOT_DGM, ErrorCode::NotDgm));
static_assert(same(DGM_BAD_VERSION, ErrorCode::BadVersion));
static_assert(same(DGM_TRUNCATED, ErrorCode::Truncated));
static_assert(same(DGM_HASH_MISMATCH, ErrorCode::HashMismatch));
static_assert(same(DGM_BAD_INDEX, ErrorCode::BadIndex));
static_assert(same(DGM_BAD_LAYER, ErrorCode::BadLayer));
static_assert(same(DGM_BAD_VALUE, ErrorCode::BadValue));
static_assert(same(DGM_BAD_SEAM_TABLE, ErrorCode::BadSeamTable));
static_assert(same(DGM_SEAM_GAP, ErrorCode::SeamGap));
static_assert(same(DGM_NOT_FINITE, ErrorCode::NotFinite));
static_assert(same(DGM_MISSING_LAYER, ErrorCode::MissingLayer));
static_assert(same(DGM_UNKNOWN_LAYER, ErrorCode::UnknownLayer));
static_assert(same(DGM_LIMIT_EXCEEDED, ErrorCode::LimitExceeded));
static_assert(same(DGM_BUFFER_TOO_SMALL, ErrorCode::BufferTooSmall));
static_assert(same(DGM_NOT_FOUND, ErrorCode::NotFound));
static_assert(same(DGM_UNSUPPORTED, ErrorCode::Unsupported));
static_assert(same(DGM_BUSY, ErrorCode::Busy));
static_assert(same(DGM_DOMAIN_SQUARE, dgm::layout::Domain::kSquare));
static_assert(same(DGM_DOMAIN_FREE, dgm::layout::Domain::kFree));
static_assert(same(DGM_ELEMENT_TYPE_U8, dgm::layout::ElementType::kU8));
static_assert(same(DGM_ELEMENT_TYPE_U16, dgm::layout::ElementType::kU16));
static_assert(same(DGM_ELEMENT_TYPE_U32, dgm::layout::ElementType::kU32));
static_assert(same(DGM_ELEMENT_TYPE_I16, dgm::layout::ElementType::kI16));
static_assert(same(DGM_ELEMENT_TYPE_F16, dgm::layout::ElementType::kF16));
static_assert(same(DGM_ELEMENT_TYPE_F32, dgm::layout::ElementType::kF32));
static_assert(same(DGM_VERTEX_FORMAT_F32, dgm::VertexFormat::F32));
static_assert(same(DGM_VERTEX_FORMAT_F16, dgm::VertexFormat::F16));
static_assert(same(DGM_VERTEX_FORMAT_U16, dgm::VertexFormat::U16));
static_assert(same(DGM_TOPOLOGY_TRIANGLES, dgm::IndexTopology::Triangles));
static_assert(same(DGM_TOPOLOGY_STRIPS, dgm::IndexTopology::Strips));
static_assert(DGM_NONE == dgm::kNone && DGM_NO_OFFSET == kNoOffset);
static_assert(DGM_RESTART == dgm::kRestart && DGM_NO_ATTRIBUTE == dgm::kNoAttribute);

Result<dgm::OpenOptions> open_options(const dgm_open_options* from, const dgm_allocator* allocator) noexcept {
    dgm_open_options o;
    if (auto r = get(from, o); !r) return r.error();
    if (o.required_layers == nullptr && o.required_layer_count != 0) return kNull;
    for (std::size_t k = 0; k < o.required_layer_count; ++k)
        if (o.required_layers[k] == nullptr) return kNull;
    auto a = allocator_of(allocator);
    if (!a) return a.error();
    dgm::OpenOptions options;
    if (o.layers == nullptr && o.layer_count != 0) return kNull;
    options.required_layers = {o.required_layers, o.required_layer_count};
    options.layers = {o.layers, o.layer_count};
    options.verify_hashes = o.verify_hashes != 0;
    if (o.max_file_bytes != 0) options.max_file_bytes = o.max_file_bytes;
    if (o.max_charts != 0) options.max_charts = o.max_charts;
    if (o.max_layers != 0) options.max_layers = o.max_layers;
    if (o.max_samples != 0) options.max_samples = o.max_samples;
    options.allocator = a.value();
    return options;
}

Result<dgm::Chart> chart_of(const dgm_asset* asset, std::uint32_t chart) noexcept {
    if (asset == nullptr) return kNull;
    return asset->value.chart(chart);
}

dgm_code give_layer(Result<dgm::LayerView>&& layer, dgm_layer_view* view, dgm_error* error) noexcept {
    if (!layer) return finish(layer.error(), error);
    const dgm::LayerView& l = layer.value();
    put(view, dgm_layer_view{0,
                             static_cast<std::uint32_t>(l.type),
                             l.rank,
                             l.known ? 1u : 0u,
                             {l.shape[0], l.shape[1], l.shape[2], l.shape[3]},
                             l.file_offset,
                             l.name,
                             l.data,
                             l.bytes});
    return finish({}, error);
}

dgm_code give_counts(const Result<dgm::MeshCounts>& made, dgm_mesh_counts* counts, dgm_error* error) noexcept {
    if (!made) return finish(made.error(), error);
    put(counts, dgm_mesh_counts{0, made.value().vertices, made.value().indices});
    return finish({}, error);
}

dgm::ReconstructOptions mesh_options(std::uint32_t stride, std::uint32_t strips) noexcept {
    return {stride == 0 ? 1u : stride, strips != 0 ? dgm::IndexTopology::Strips : dgm::IndexTopology::Triangles};
}

template <class Surface>
dgm_code reconstruct_into(const Surface& surface, const dgm_vertex_target* vertices, std::uint32_t* indices,
                          std::size_t index_count, dgm_mesh_counts* counts, dgm_error* error) noexcept {
    dgm_vertex_target v;
    if (auto r = get(vertices, v); !r) return finish(r.error(), error);
    dgm::VertexTarget target;
    if (v.data != nullptr)
        target = {{static_cast<std::byte*>(v.data), v.bytes},
                  v.stride,
                  v.position_offset,
                  v.normal_offset,
                  v.uv_offset,
                  static_cast<dgm::VertexFormat>(v.position_format),
                  static_cast<dgm::VertexFormat>(v.normal_format),
                  static_cast<dgm::VertexFormat>(v.uv_format),
                  vec(v.origin),
                  vec(v.step)};
    if (v.data != nullptr && v.bytes == 0)
        return finish({ErrorCode::BufferTooSmall, kNoOffset, "the vertex memory is too small"}, error);
    if (indices != nullptr && index_count == 0)
        return finish({ErrorCode::BufferTooSmall, kNoOffset, "the index memory is too small"}, error);
    const std::span<std::uint32_t> span(indices, indices == nullptr ? 0 : index_count);
    return give_counts(dgm::reconstruct(surface, target, span, mesh_options(v.lod_stride, v.strips)), counts, error);
}

size_t give_planes(const dgm::PointView& view, const float* xyz[3]) noexcept {
    if (xyz != nullptr) {
        xyz[0] = view.x;
        xyz[1] = view.y;
        xyz[2] = view.z;
    }
    return view.count;
}
}  // namespace

extern "C" {

uint32_t dgm_abi_version(void) {
    return DGM_ABI_VERSION;
}
const char* dgm_code_name(uint32_t code) {
    return dgm::error_name(static_cast<ErrorCode>(code));
}

dgm_code dgm_asset_open(const char* path, const dgm_open_options* options, const dgm_allocator* allocator,
                        dgm_asset** asset, dgm_error* error) {
    if (asset == nullptr || path == nullptr) return finish(kNull, error);
    *asset = nullptr;
    auto o = open_options(options, allocator);
    if (!o) return finish(o.error(), error);
    return hand_out(dgm::Asset::open(path, o.value()), o.value().allocator, asset, error);
}

dgm_code dgm_asset_open_memory(const void* data, size_t bytes, const dgm_open_options* options,
                               const dgm_allocator* allocator, dgm_asset** asset, dgm_error* error) {
    if (asset == nullptr || (data == nullptr && bytes != 0)) return finish(kNull, error);
    *asset = nullptr;
    auto o = open_options(options, allocator);
    if (!o) return finish(o.error(), error);
    return hand_out(dgm::Asset::open_memory({static_cast<const std::byte*>(data), bytes}, o.value()),
                    o.value().allocator, asset, error);
}

void dgm_asset_close(dgm_asset* asset) {
    dgm::detail::destroy(asset);
}

dgm_code dgm_asset_verify(const dgm_asset* asset, dgm_error* error) {
    if (asset == nullptr) return finish(kNull, error);
    return finish(asset->value.verify().error(), error);
}

uint32_t dgm_asset_chart_count(const dgm_asset* asset) {
    return asset == nullptr ? 0 : asset->value.chart_count();
}

dgm_code dgm_asset_chart(const dgm_asset* asset, uint32_t chart, dgm_chart_info* info, dgm_error* error) {
    if (info == nullptr) return finish(kNull, error);
    auto found = chart_of(asset, chart);
    if (!found) return finish(found.error(), error);
    const dgm::Chart& c = found.value();
    dgm_chart_info out{};
    out.rows = c.rows();
    out.cols = c.cols();
    out.domain = static_cast<std::uint32_t>(c.domain());
    out.border_samples = c.border_samples();
    out.layer_count = c.layer_count();
    std::copy(c.bbox().begin(), c.bbox().end(), out.bbox);
    std::copy(c.offset().begin(), c.offset().end(), out.offset);
    std::copy(c.scale().begin(), c.scale().end(), out.scale);
    out.method = c.method();
    put(info, out);
    return finish({}, error);
}

dgm_code dgm_asset_layer(const dgm_asset* asset, uint32_t chart, uint32_t layer, dgm_layer_view* view,
                         dgm_error* error) {
    if (view == nullptr) return finish(kNull, error);
    auto found = chart_of(asset, chart);
    if (!found) return finish(found.error(), error);
    return give_layer(found.value().layer(layer), view, error);
}

dgm_code dgm_asset_find_layer(const dgm_asset* asset, uint32_t chart, const char* name, dgm_layer_view* view,
                              dgm_error* error) {
    if (view == nullptr) return finish(kNull, error);
    auto found = chart_of(asset, chart);
    if (!found) return finish(found.error(), error);
    return give_layer(found.value().find(name), view, error);
}

dgm_code dgm_chart_validate(const dgm_asset* asset, uint32_t chart, const dgm_allocator* allocator, dgm_error* error) {
    auto found = chart_of(asset, chart);
    if (!found) return finish(found.error(), error);
    auto a = allocator_of(allocator);
    if (!a) return finish(a.error(), error);
    return finish(dgm::validate_chart(found.value(), a.value()).error(), error);
}

dgm_code dgm_chart_mesh_counts(const dgm_asset* asset, uint32_t chart, dgm_mesh_counts* counts, dgm_error* error) {
    auto found = chart_of(asset, chart);
    if (!found) return finish(found.error(), error);
    return give_counts(dgm::mesh_counts(found.value()), counts, error);
}

dgm_code dgm_chart_reconstruct(const dgm_asset* asset, uint32_t chart, const dgm_vertex_target* vertices,
                               uint32_t* indices, size_t index_count, dgm_mesh_counts* counts, dgm_error* error) {
    auto found = chart_of(asset, chart);
    if (!found) return finish(found.error(), error);
    return reconstruct_into(found.value(), vertices, indices, index_count, counts, error);
}

dgm_code dgm_state_mesh_counts(const dgm_state* state, dgm_mesh_counts* counts, dgm_error* error) {
    if (state == nullptr) return finish(kNull, error);
    return give_counts(dgm::mesh_counts(state->value), counts, error);
}

dgm_code dgm_chart_mesh_counts_at(const dgm_asset* asset, uint32_t chart, uint32_t lod_stride, uint32_t strips,
                                  dgm_mesh_counts* counts, dgm_error* error) {
    auto found = chart_of(asset, chart);
    if (!found) return finish(found.error(), error);
    return give_counts(dgm::mesh_counts(found.value(), mesh_options(lod_stride, strips)), counts, error);
}

dgm_code dgm_state_mesh_counts_at(const dgm_state* state, uint32_t lod_stride, uint32_t strips, dgm_mesh_counts* counts,
                                  dgm_error* error) {
    if (state == nullptr) return finish(kNull, error);
    return give_counts(dgm::mesh_counts(state->value, mesh_options(lod_stride, strips)), counts, error);
}

dgm_code dgm_state_reconstruct(const dgm_state* state, const dgm_vertex_target* vertices, uint32_t* indices,
                               size_t index_count, dgm_mesh_counts* counts, dgm_error* error) {
    if (state == nullptr) return finish(kNull, error);
    return reconstruct_into(state->value, vertices, indices, index_count, counts, error);
}

dgm_code dgm_state_create(const dgm_asset* asset, uint32_t chart, const dgm_state_options* options,
                          const dgm_allocator* allocator, dgm_state** state, dgm_error* error) {
    if (state == nullptr) return finish(kNull, error);
    *state = nullptr;
    auto found = chart_of(asset, chart);
    if (!found) return finish(found.error(), error);
    dgm_state_options o;
    auto a = get(options, o, allocator);
    if (!a) return finish(a.error(), error);
    dgm::StateOptions wishes;
    if (o.max_reach != 0) wishes.max_reach = o.max_reach;
    if (o.max_bytes != 0) wishes.max_bytes = o.max_bytes;
    if (o.max_tools != 0) wishes.max_tools = o.max_tools;
    wishes.plain_loops = o.plain_loops != 0;
    wishes.allocator = a.value();
    return hand_out(dgm::State::create(found.value(), wishes), a.value(), state, error);
}

void dgm_state_destroy(dgm_state* state) {
    dgm::detail::destroy(state);
}
void dgm_state_release(dgm_state* state) {
    if (state != nullptr) state->value.release();
}
void dgm_state_reset(dgm_state* state) {
    if (state != nullptr) state->value.reset();
}
dgm_code dgm_state_relax(dgm_state* state, float dt, float rate, dgm_error* error) {
    if (state == nullptr) return finish(kNull, error);
    return finish(state->value.relax(dt, rate).error(), error);
}
void dgm_state_update_normals(dgm_state* state) {
    if (state != nullptr) state->value.update_normals();
}
size_t dgm_state_positions(const dgm_state* state, const float* xyz[3]) {
    return state == nullptr ? 0 : give_planes(state->value.positions(), xyz);
}
size_t dgm_state_normals(const dgm_state* state, const float* xyz[3]) {
    return state == nullptr ? 0 : give_planes(state->value.normals(), xyz);
}
float dgm_state_mean_step(const dgm_state* state) {
    return state == nullptr ? 0.0f : state->value.mean_step();
}
uint32_t dgm_state_sample_count(const dgm_state* state) {
    return state == nullptr ? 0 : state->value.sample_count();
}

dgm_code dgm_state_position(const dgm_state* state, uint32_t sample, float position[3], dgm_error* error) {
    if (state == nullptr || position == nullptr) return finish(kNull, error);
    if (sample >= state->value.sample_count())
        return finish({ErrorCode::BadArgument, kNoOffset, "the state has no such sample"}, error);
    store(state->value.positions()[sample], position);
    return finish({}, error);
}

dgm_code dgm_state_normal(const dgm_state* state, uint32_t sample, float normal[3], dgm_error* error) {
    if (state == nullptr || normal == nullptr) return finish(kNull, error);
    if (sample >= state->value.sample_count())
        return finish({ErrorCode::BadArgument, kNoOffset, "the state has no such sample"}, error);
    store(state->value.normal(sample), normal);
    return finish({}, error);
}

uint32_t dgm_state_class_of(const dgm_state* state, uint32_t sample) {
    return state == nullptr ? DGM_NONE : state->value.class_of(sample);
}
size_t dgm_state_class_members(const dgm_state* state, uint32_t class_id, const uint32_t** members) {
    const auto found = state == nullptr ? std::span<const std::uint32_t>{} : state->value.class_members(class_id);
    if (members != nullptr) *members = found.data();
    return found.size();
}

}  // extern "C"
