// SPDX-License-Identifier: MIT
// libdgm/web/touch.cpp
// The runtime for a page: functions of plain numbers over the C interface, so that a script writes no structs.
//
// Answers of more than one number stand in touch_answers(), as doubles; texts are zero-terminated. A body is a chart
// with what a page keeps for it. Functions that can fail return 0 or a dgm_code; touch_error_...() tell the rest. The
// script is trusted with pointers, since it could write anywhere in this memory anyway; bytes of files are not.
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include <dgm/dgm.h>

#include "touch_shared.h"

using namespace touch;

namespace {
constexpr std::uint32_t kMostRanges = 21, kMostTicks = 1000;
}  // namespace

struct Body {
    dgm_state* state = nullptr;
    dgm_contact_solver* solver = nullptr;
    std::uint32_t* indices = nullptr;
    std::uint64_t cursor = 0;
    dgm_changed_range ranges[kMostRanges];
};

namespace touch {
double answers[64];
dgm_error error = {sizeof(dgm_error), DGM_OK, DGM_NO_OFFSET, ""};
dgm_tool_input tools[kMostTools];
// Positions of a batch of ticks, tool by tool within a tick.
float places[kMostTicks * kMostTools * 3];

dgm_obstacle obstacle_of(std::uint32_t kind, const float (&p)[3], const float (&q)[3], float radius) {
    auto out = sized<dgm_obstacle>();
    out.kind = kind;
    for (int k = 0; k < 3; ++k) {
        out.point[k] = p[k];
        if (kind == DGM_OBSTACLE_KIND_PLANE) out.normal[k] = q[k];
        if (kind == DGM_OBSTACLE_KIND_CAPSULE) out.end[k] = q[k];
    }
    if (kind != DGM_OBSTACLE_KIND_PLANE) out.radius = radius;
    return out;
}
}  // namespace touch

dgm_state* state_of(const Body* body) {
    return body->state;
}

namespace {
const char* text = "";
dgm_tick_options ticking = sized<dgm_tick_options>();
float forces[kMostTicks * kMostTools * 3];  // that answer the places

void* taken(std::size_t bytes) {
    void* out = std::malloc(bytes > 0 ? bytes : 1);
    if (out == nullptr)
        error.code = DGM_OUT_OF_MEMORY, error.message = "no memory is left", error.byte_offset = DGM_NO_OFFSET;
    return out;
}

void copy3(double* to, const float* from) {
    for (int k = 0; k < 3; ++k) to[k] = static_cast<double>(from[k]);
}
double pointer(const void* p) {
    return static_cast<double>(reinterpret_cast<std::uintptr_t>(p));
}
}  // namespace

TOUCH_API double* touch_answers() {
    return answers;
}
TOUCH_API const char* touch_text() {
    return text;
}
TOUCH_API std::uint32_t touch_error_code() {
    return error.code;
}
TOUCH_API const char* touch_error_name() {
    return dgm_code_name(error.code);
}
TOUCH_API const char* touch_error_message() {
    return error.message;
}
/// Place in the file, or -1.
TOUCH_API double touch_error_offset() {
    return error.byte_offset == DGM_NO_OFFSET ? -1 : static_cast<double>(error.byte_offset);
}

/// Memory for a file, aligned as dgm_asset_open_memory() wants it. 0: none is left.
TOUCH_API void* touch_memory(std::uint32_t bytes) {
    return std::aligned_alloc(64, (std::size_t{bytes} + 127) / 64 * 64);
}
TOUCH_API void touch_forget(void* memory) {
    std::free(memory);
}

// ---- Assets ----

TOUCH_API dgm_asset* touch_open(const void* data, std::uint32_t bytes) {
    dgm_asset* asset = nullptr;
    dgm_asset_open_memory(data, bytes, nullptr, nullptr, &asset, &error);
    return asset;
}
TOUCH_API void touch_close(dgm_asset* asset) {
    dgm_asset_close(asset);
}
TOUCH_API std::uint32_t touch_verify(const dgm_asset* asset) {
    return dgm_asset_verify(asset, &error);
}
TOUCH_API std::uint32_t touch_check(const dgm_asset* asset, std::uint32_t chart) {
    return dgm_chart_validate(asset, chart, nullptr, &error);
}
TOUCH_API std::uint32_t touch_charts(const dgm_asset* asset) {
    return dgm_asset_chart_count(asset);
}

/// Answers: rows, cols, domain, border samples, layers, bbox (6), offset (3), scale (3). Text: the method.
TOUCH_API std::uint32_t touch_chart(const dgm_asset* asset, std::uint32_t chart) {
    auto info = sized<dgm_chart_info>();
    if (dgm_asset_chart(asset, chart, &info, &error) != DGM_OK) return error.code;
    const double head[] = {static_cast<double>(info.rows), static_cast<double>(info.cols),
                           static_cast<double>(info.domain), static_cast<double>(info.border_samples),
                           static_cast<double>(info.layer_count)};
    for (int k = 0; k < 5; ++k) answers[k] = head[k];
    for (int k = 0; k < 6; ++k) answers[5 + k] = info.bbox[k];
    for (int k = 0; k < 3; ++k) answers[11 + k] = info.offset[k], answers[14 + k] = info.scale[k];
    text = info.method;
    return DGM_OK;
}

/// Answers: type, rank, shape (4), data, bytes, known, place in the file. Text: the name.
TOUCH_API std::uint32_t touch_layer(const dgm_asset* asset, std::uint32_t chart, std::uint32_t layer) {
    auto view = sized<dgm_layer_view>();
    if (dgm_asset_layer(asset, chart, layer, &view, &error) != DGM_OK) return error.code;
    answers[0] = view.type, answers[1] = view.rank;
    for (int k = 0; k < 4; ++k) answers[2 + k] = static_cast<double>(view.shape[k]);
    answers[6] = pointer(view.data), answers[7] = static_cast<double>(view.bytes), answers[8] = view.known;
    answers[9] = static_cast<double>(view.file_offset);
    text = view.name;
    return DGM_OK;
}

// ---- Bodies ----

TOUCH_API void touch_body_free(Body* body) {
    if (body == nullptr) return;
    dgm_contact_solver_destroy(body->solver);
    dgm_state_destroy(body->state);
    std::free(body->indices);
    std::free(body);
}

/// `reach`: of the tables that will be used. 0: see the error.
TOUCH_API Body* touch_body(const dgm_asset* asset, std::uint32_t chart, std::uint32_t reach) {
    auto* body = static_cast<Body*>(taken(sizeof(Body)));
    if (body == nullptr) return nullptr;
    *body = Body{};
    auto options = sized<dgm_state_options>();
    options.max_reach = reach;
    options.max_tools = kMostTools;
    if (dgm_state_create(asset, chart, &options, nullptr, &body->state, &error) == DGM_OK) return body;
    touch_body_free(body);
    return nullptr;
}

/// Answers: samples, mean step; x, y, z of the positions; x, y, z of the normals (pointers to floats).
TOUCH_API void touch_arrays(const Body* body) {
    const float *xyz[3] = {}, *normals[3] = {};
    answers[0] = static_cast<double>(dgm_state_positions(body->state, xyz));
    static_cast<void>(dgm_state_normals(body->state, normals));
    answers[1] = static_cast<double>(dgm_state_mean_step(body->state));
    for (int k = 0; k < 3; ++k) answers[2 + k] = pointer(xyz[k]), answers[5 + k] = pointer(normals[k]);
}

/// Triangles at a level of detail; they live until the next call for this body. Answers: their indices. 0: an error.
TOUCH_API const std::uint32_t* touch_indices(Body* body, std::uint32_t stride) {
    auto counts = sized<dgm_mesh_counts>();
    auto target = sized<dgm_vertex_target>();
    target.lod_stride = stride;
    target.position_offset = target.normal_offset = target.uv_offset = DGM_NO_ATTRIBUTE;
    if (dgm_state_mesh_counts_at(body->state, stride, DGM_TOPOLOGY_TRIANGLES, &counts, &error) != DGM_OK)
        return nullptr;
    std::free(body->indices);
    body->indices = static_cast<std::uint32_t*>(taken(counts.indices * sizeof(std::uint32_t)));
    if (body->indices == nullptr) return nullptr;
    if (dgm_state_reconstruct(body->state, &target, body->indices, counts.indices, &counts, &error) != DGM_OK)
        return nullptr;
    answers[0] = static_cast<double>(counts.indices);
    return body->indices;
}

/// The weld class of a sample, or DGM_NONE.
TOUCH_API std::uint32_t touch_class(const Body* body, std::uint32_t sample) {
    return dgm_state_class_of(body->state, sample);
}

/// Copies of a class: the answer is how many; touch_answers() has the first 64 of them.
TOUCH_API std::uint32_t touch_copies(const Body* body, std::uint32_t sample) {
    const std::uint32_t* members = nullptr;
    const std::size_t count = dgm_state_class_members(body->state, dgm_state_class_of(body->state, sample), &members);
    for (std::size_t k = 0; k < count && k < 64; ++k) answers[k] = members[k];
    return static_cast<std::uint32_t>(count);
}

TOUCH_API void touch_release(Body* body) {
    dgm_state_release(body->state);
}
TOUCH_API void touch_reset(Body* body) {
    dgm_state_reset(body->state);
}
TOUCH_API std::uint32_t touch_relax(Body* body, float dt, float rate) {
    return dgm_state_relax(body->state, dt, rate, &error);
}
TOUCH_API void touch_normals(Body* body) {
    dgm_state_update_normals(body->state);
}

/// Samples that elastic touches may still have moved.
TOUCH_API std::uint32_t touch_active(const Body* body) {
    auto usage = sized<dgm_state_usage>();
    return dgm_state_get_usage(body->state, &usage, &error) == DGM_OK ? usage.active_samples : 0;
}

/// What moved since the last call: the number of ranges, 21 at most. Answers: first sample, columns and rows of each.
TOUCH_API std::uint32_t touch_changed(Body* body) {
    for (dgm_changed_range& range : body->ranges) range = sized<dgm_changed_range>();
    std::size_t count = 0;
    if (dgm_state_changed_rows(body->state, &body->cursor, body->ranges, kMostRanges, &count, &error) != DGM_OK)
        return 0;
    for (std::size_t k = 0; k < count; ++k) {
        answers[3 * k] = body->ranges[k].first;
        answers[3 * k + 1] = body->ranges[k].columns;
        answers[3 * k + 2] = body->ranges[k].rows;
    }
    return static_cast<std::uint32_t>(count);
}

/// 1 if the ray meets a triangle. Answers: sample, row, column, triangle, corners (3), front, weights (3), distance,
/// point (3), normal (3).
TOUCH_API std::uint32_t touch_pick(Body* body, float ox, float oy, float oz, float dx, float dy, float dz) {
    const float origin[3] = {ox, oy, oz}, direction[3] = {dx, dy, dz};
    auto hit = sized<dgm_ray_hit>();
    if (dgm_pick_ray(body->state, origin, direction, nullptr, &hit, &error) != DGM_OK) return 0;
    answers[0] = hit.sample, answers[1] = hit.row, answers[2] = hit.column, answers[3] = hit.triangle;
    for (int k = 0; k < 3; ++k) answers[4 + k] = hit.corners[k];
    answers[7] = hit.front;
    copy3(answers + 8, hit.barycentric);
    answers[11] = static_cast<double>(hit.distance);
    copy3(answers + 12, hit.point);
    copy3(answers + 15, hit.normal);
    return 1;
}

// ---- Ticks ----

/// A round kernel; `end` is a dgm_kernel_end.
TOUCH_API dgm_table* touch_table(std::uint32_t reach, float sigma, std::uint32_t end) {
    auto options = sized<dgm_kernel_options>();
    options.end = end;
    options.reach = reach;
    options.sigma = sigma;
    dgm_table* table = nullptr;
    dgm_table_create(&options, nullptr, &table, &error);
    return table;
}
TOUCH_API void touch_table_free(dgm_table* table) {
    dgm_table_destroy(table);
}

/// Settings of the ticks to come, as dgm_tick_options.
TOUCH_API void touch_ticking(std::uint32_t footprint, std::uint32_t mode, std::uint32_t rule, float dt, float d_max,
                             float f_max, float relax_rate, float settle_time, float grasp_distance, float step) {
    ticking.footprint = footprint, ticking.mode = mode, ticking.rule = rule;
    ticking.dt = dt, ticking.d_max = d_max, ticking.f_max = f_max, ticking.relax_rate = relax_rate;
    ticking.settle_time = settle_time, ticking.grasp_distance = grasp_distance, ticking.step = step;
}

/// Tool number `k` of the ticks to come.
TOUCH_API void touch_tool(std::uint32_t k, std::uint32_t kind, std::uint32_t lifted) {
    tools[k] = sized<dgm_tool_input>();
    tools[k].tool = k, tools[k].kind = kind, tools[k].lifted = lifted;
}
/// Where the script writes x, y, z of each tool of each tick, and where it finds their forces.
TOUCH_API float* touch_places() {
    return places;
}
TOUCH_API float* touch_forces() {
    return forces;
}

/// Runs `count` ticks (1000 at most) of the tools 0 .. tool_count - 1; normals are brought up to date by the last one.
/// Answers: contacts, samples, 1 if a seam was crossed; then of each tool: sample, hit, holding, contact,
/// displacement (3), force (3).
TOUCH_API std::uint32_t touch_ticks(Body* body, const dgm_table* table, std::uint32_t count, std::uint32_t tool_count) {
    dgm_tool_output felt[kMostTools];
    for (dgm_tool_output& output : felt) output = sized<dgm_tool_output>();
    auto report = sized<dgm_tick_report>();
    for (std::uint32_t t = 0; t < count; ++t) {
        for (std::uint32_t k = 0; k < tool_count; ++k)
            for (std::uint32_t c = 0; c < 3; ++c) tools[k].position[c] = places[3 * (t * tool_count + k) + c];
        ticking.skip_normals = t + 1 < count ? 1 : 0;
        if (dgm_tick(body->state, table, &ticking, tools, tool_count, felt, &report, &error) != DGM_OK)
            return error.code;
        for (std::uint32_t k = 0; k < tool_count; ++k)
            for (std::uint32_t c = 0; c < 3; ++c) forces[3 * (t * tool_count + k) + c] = felt[k].force[c];
    }
    answers[0] = report.contacts, answers[1] = report.samples, answers[2] = report.crossed_seam;
    for (std::uint32_t k = 0; k < tool_count; ++k) {
        double* out = answers + 3 + 10 * k;
        out[0] = felt[k].sample, out[1] = felt[k].hit, out[2] = felt[k].holding, out[3] = felt[k].contact;
        copy3(out + 4, felt[k].displacement);
        copy3(out + 7, felt[k].force);
    }
    return DGM_OK;
}

// ---- Obstacles ----

namespace {
/// Takes the memory for contacts, unless it is there. False: an error.
bool can_meet(Body* body) {
    return body->solver != nullptr || dgm_contact_solver_create(body->state, nullptr, &body->solver, &error) == DGM_OK;
}

std::uint32_t resolved(Body* body, const dgm_obstacle& obstacle, std::uint32_t mode, std::uint32_t smoothing) {
    auto options = sized<dgm_contact_options>();
    options.mode = mode;
    options.smoothing = smoothing;
    auto report = sized<dgm_contact_report>();
    if (dgm_resolve_contact(body->state, body->solver, &obstacle, &options, &report, &error) != DGM_OK)
        return error.code;
    answers[0] = report.status, answers[1] = report.samples, answers[2] = report.removed;
    answers[3] = report.volume_error, answers[4] = report.volume_kept, answers[5] = static_cast<double>(report.deepest);
    return DGM_OK;
}
}  // namespace

/// The volume that the present shape encloses; 0 for an open surface.
TOUCH_API double touch_volume(Body* body) {
    return can_meet(body) ? dgm_contact_solver_volume(body->solver, body->state) : 0;
}

/// Presses the body against a plane (a point of it, and its normal), a ball (middle, radius) or a capsule (both ends,
/// radius). `smoothing` as dgm_contact_options. Answers: dgm_contact_status, samples, volume removed, volume error, 1
/// if the volume is kept, deepest.
TOUCH_API std::uint32_t touch_obstacle(Body* body, std::uint32_t kind, std::uint32_t mode, float px, float py, float pz,
                                       float qx, float qy, float qz, float radius, std::uint32_t smoothing) {
    if (!can_meet(body)) return error.code;
    const dgm_obstacle obstacle = obstacle_of(kind, {px, py, pz}, {qx, qy, qz}, radius);
    return resolved(body, obstacle, mode, smoothing);
}

/// Presses the body against another one, whose origin lies at (x, y, z). Answers: as touch_obstacle().
TOUCH_API std::uint32_t touch_other(Body* body, Body* other, std::uint32_t mode, float x, float y, float z,
                                    float reach) {
    if (!can_meet(body)) return error.code;
    auto obstacle = sized<dgm_obstacle>();
    obstacle.kind = DGM_OBSTACLE_KIND_SURFACE;
    obstacle.surface = other->state;
    obstacle.reach = reach;
    obstacle.point[0] = x, obstacle.point[1] = y, obstacle.point[2] = z;
    return resolved(body, obstacle, mode, 0);
}
