// SPDX-License-Identifier: MIT
// libdgm/src/c_api/c_api_tools.cpp
// dgm.h: kernels, touches, search, ticks, forces.
#include <limits>

#include <dgm/collide.h>
#include <dgm/deform.h>
#include <dgm/force.h>
#include <dgm/tick.h>

#include "c_api/c_api_impl.h"

namespace {
using dgm::ErrorCode;
using dgm::kNoOffset;
using dgm::Result;
using namespace dgm::c_api;

static_assert(same(DGM_KERNEL_SHAPE_CIRCULAR, dgm::KernelShape::Circular));
static_assert(same(DGM_KERNEL_SHAPE_ELLIPTIC, dgm::KernelShape::Elliptic));
static_assert(same(DGM_KERNEL_SHAPE_USER, dgm::KernelShape::User));
static_assert(same(DGM_KERNEL_END_PRINTED, dgm::KernelEnd::Printed));
static_assert(same(DGM_KERNEL_END_COMPACT, dgm::KernelEnd::Compact));
static_assert(same(DGM_FOOTPRINT_SURFACE, dgm::Footprint::Surface));
static_assert(same(DGM_FOOTPRINT_METRIC, dgm::Footprint::Metric));
static_assert(same(DGM_FOOTPRINT_GEODESIC, dgm::Footprint::Geodesic));
static_assert(same(DGM_FOOTPRINT_GRID, dgm::Footprint::Grid));
static_assert(same(DGM_DEFORM_MODE_ELASTIC, dgm::DeformMode::Elastic));
static_assert(same(DGM_DEFORM_MODE_PLASTIC, dgm::DeformMode::Plastic));
static_assert(same(DGM_TOOL_KIND_TOUCH, dgm::ToolKind::Touch));
static_assert(same(DGM_TOOL_KIND_POKE, dgm::ToolKind::Poke));
static_assert(same(DGM_TOOL_KIND_GRASP, dgm::ToolKind::Grasp));
static_assert(same(DGM_CONTACT_RULE_SMOOTH, dgm::ContactRule::Smooth));
static_assert(same(DGM_CONTACT_RULE_PRINTED, dgm::ContactRule::Printed));

dgm_code give_nearest(const Result<dgm::Nearest>& found, std::uint32_t* sample, float* distance,
                      dgm_error* error) noexcept {
    if (!found) return finish(found.error(), error);
    if (sample != nullptr) *sample = found.value().sample;
    if (distance != nullptr) *distance = found.value().distance;
    return finish({}, error);
}

/// Zeros are the defaults.
Result<dgm::TickOptions> tick_options(const dgm_tick_options* from) noexcept {
    dgm_tick_options o;
    if (auto r = get(from, o); !r) return r.error();
    const float at_once = std::numeric_limits<float>::infinity();
    dgm::TickOptions options;
    options.d_max = o.d_max;
    options.f_max = o.f_max;
    if (o.dt != 0) options.dt = o.dt;
    if (o.relax_rate != 0) options.relax_rate = o.relax_rate < 0 ? 0 : o.relax_rate;
    if (o.relax_rate == 0) options.relax_rate = at_once;
    if (o.settle_time != 0) options.settle_time = o.settle_time < 0 ? 0 : o.settle_time;
    options.grasp_distance = o.grasp_distance;
    options.rule = static_cast<dgm::ContactRule>(o.rule);
    options.footprint = static_cast<dgm::Footprint>(o.footprint);
    options.mode = static_cast<dgm::DeformMode>(o.mode);
    options.step = o.step;
    options.normals = o.skip_normals == 0;
    return options;
}
}  // namespace

extern "C" {

dgm_code dgm_table_create(const dgm_kernel_options* options, const dgm_allocator* allocator, dgm_table** table,
                          dgm_error* error) {
    if (table == nullptr || options == nullptr) return finish(kNull, error);
    *table = nullptr;
    dgm_kernel_options o;
    auto a = get(options, o, allocator);
    if (!a) return finish(a.error(), error);
    if (o.values == nullptr && o.value_count != 0) return finish(kNull, error);
    dgm::KernelOptions kernel;
    kernel.shape = static_cast<dgm::KernelShape>(o.shape);
    kernel.end = static_cast<dgm::KernelEnd>(o.end);
    kernel.sigma = o.sigma;
    kernel.reach = o.reach;
    kernel.radius_a = o.radius_a;
    kernel.radius_b = o.radius_b;
    kernel.angle = o.angle;
    kernel.values = {o.values, o.value_count};
    return hand_out(dgm::DeformTable::create(kernel, a.value()), a.value(), table, error);
}

void dgm_table_destroy(dgm_table* table) {
    dgm::detail::destroy(table);
}
float dgm_table_weight(const dgm_table* table, float di, float dj) {
    return table == nullptr ? 0.0f : table->value.weight(di, dj);
}

float dgm_table_profile(const dgm_table* table, float distance) {
    return table == nullptr ? 0.0f : table->value.profile(distance);
}

dgm_code dgm_deform(dgm_state* state, const dgm_table* table, const dgm_touch* touch, dgm_deform_report* report,
                    dgm_error* error) {
    if (state == nullptr || table == nullptr || touch == nullptr) return finish(kNull, error);
    dgm_touch t;
    if (auto r = get(touch, t); !r) return finish(r.error(), error);
    const dgm::Touch wish{t.sample,
                          vec(t.displacement),
                          t.d_max,
                          static_cast<dgm::Footprint>(t.footprint),
                          static_cast<dgm::DeformMode>(t.mode),
                          t.step};
    auto done = dgm::deform(state->value, table->value, wish);
    if (!done) return finish(done.error(), error);
    dgm_deform_report out{};
    out.samples = done.value().samples;
    store(done.value().displacement, out.displacement);
    out.crossed_seam = done.value().crossed_seam ? 1 : 0;
    out.truncated = done.value().truncated ? 1 : 0;
    put(report, out);
    return finish({}, error);
}

dgm_code dgm_nearest_sample(dgm_state* state, const float tool[3], uint32_t* sample, float* distance,
                            dgm_error* error) {
    if (state == nullptr || tool == nullptr) return finish(kNull, error);
    return give_nearest(dgm::nearest_sample(state->value, vec(tool)), sample, distance, error);
}

dgm_code dgm_track_sample(dgm_state* state, const float tool[3], uint32_t last, uint32_t a, uint32_t* sample,
                          float* distance, dgm_error* error) {
    if (state == nullptr || tool == nullptr) return finish(kNull, error);
    return give_nearest(dgm::track_sample(state->value, vec(tool), last, a), sample, distance, error);
}

dgm_code dgm_track_nearest(dgm_state* state, const float tool[3], uint32_t last, uint32_t a, uint32_t* sample,
                           float* distance, uint32_t* lost, dgm_error* error) {
    if (state == nullptr || tool == nullptr) return finish(kNull, error);
    const auto found = dgm::track_nearest(state->value, vec(tool), last, a);
    if (!found) return finish(found.error(), error);
    if (lost != nullptr) *lost = found.value().lost ? 1 : 0;
    return give_nearest(dgm::Nearest{found.value().sample, found.value().distance}, sample, distance, error);
}

dgm_code dgm_tick(dgm_state* state, const dgm_table* table, const dgm_tick_options* options,
                  const dgm_tool_input* tools, size_t tool_count, dgm_tool_output* outputs, dgm_tick_report* report,
                  dgm_error* error) {
    if (state == nullptr || table == nullptr || options == nullptr || (tools == nullptr && tool_count != 0))
        return finish(kNull, error);
    constexpr std::size_t kMaxTools = 64;  // of StateOptions::max_tools
    if (tool_count > kMaxTools)
        return finish({ErrorCode::BadArgument, kNoOffset, "the state was made for fewer tools"}, error);
    auto o = tick_options(options);
    if (!o) return finish(o.error(), error);
    dgm::ToolInput in[kMaxTools];
    dgm::ToolOutput out[kMaxTools];
    const auto read = get_each(tools, tool_count, [&](std::size_t k, const dgm_tool_input& t) {
        in[k] = {t.tool, static_cast<dgm::ToolKind>(t.kind), vec(t.position), t.lifted == 0};
    });
    if (!read) return finish(read.error(), error);
    auto done = dgm::tick(state->value, table->value, o.value(), {in, tool_count}, {out, tool_count});
    if (!done) return finish(done.error(), error);
    for (std::size_t k = 0; outputs != nullptr && k < tool_count; ++k) {
        dgm_tool_output t{};
        t.sample = out[k].sample;
        t.distance = out[k].distance;
        t.hit = out[k].hit ? 1 : 0;
        t.lost = out[k].lost ? 1 : 0;
        t.holding = out[k].holding ? 1 : 0;
        t.contact = out[k].contact;
        store(out[k].displacement, t.displacement);
        store(out[k].force, t.force);
        put(element(outputs, k), t);
    }
    dgm_tick_report r{};
    r.contacts = done.value().contacts;
    r.samples = done.value().samples;
    r.crossed_seam = done.value().crossed_seam ? 1 : 0;
    r.truncated = done.value().truncated ? 1 : 0;
    put(report, r);
    return finish({}, error);
}

dgm_code dgm_hit_test(const float tool_vector[3], const float normal[3], uint32_t* hit, dgm_error* error) {
    if (tool_vector == nullptr || normal == nullptr || hit == nullptr) return finish(kNull, error);
    auto r = dgm::hit_test(vec(tool_vector), vec(normal));
    if (!r) return finish(r.error(), error);
    *hit = r.value() ? 1 : 0;
    return finish({}, error);
}

dgm_code dgm_contact_force(const float d[3], float d_max, float f_max, float force[3], dgm_error* error) {
    if (d == nullptr || force == nullptr) return finish(kNull, error);
    auto r = dgm::contact_force(vec(d), d_max, f_max);
    if (!r) return finish(r.error(), error);
    store(r.value(), force);
    return finish({}, error);
}

}  // extern "C"
