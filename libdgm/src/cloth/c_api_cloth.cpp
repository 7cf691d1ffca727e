// SPDX-License-Identifier: MIT
// libdgm/src/cloth/c_api_cloth.cpp
// dgm_cloth.h on top of cloth.h.
#include <dgm/cloth.h>
#include <dgm/dgm_cloth.h>

#include "c_api/c_api_impl.h"

struct dgm_cloth : dgm::c_api::Held<dgm::Cloth> {
    using Held::Held;
};

namespace {
using dgm::ErrorCode;
using dgm::kNoOffset;
using dgm::Result;
using namespace dgm::c_api;

constexpr std::size_t kMaxScene = 64, kMaxPins = 256;

/// 0 is the default, a negative number 0.
float number(float given, float usual) noexcept {
    return given == 0 ? usual : given < 0 ? 0 : given;
}

struct Scene {
    dgm::Obstacle obstacles[kMaxScene];
    dgm::Pin pins[kMaxPins];
};
Result<dgm::ClothStep> step_options(const dgm_cloth_step_options* from, Scene& scene) noexcept {
    dgm_cloth_step_options o;
    if (auto r = get(from, o); !r) return r.error();
    if ((o.obstacles == nullptr && o.obstacle_count != 0) || (o.pins == nullptr && o.pin_count != 0)) return kNull;
    if (o.obstacle_count > kMaxScene || o.pin_count > kMaxPins)
        return dgm::Error{ErrorCode::LimitExceeded, kNoOffset, "there are more than 64 obstacles or 256 pins"};
    for (std::size_t k = 0; k < o.obstacle_count; ++k) {
        if (k > 0 && element(o.obstacles, k)->struct_size != o.obstacles->struct_size) return kBadSize;
        auto one = obstacle_of(element(o.obstacles, k));
        if (!one) return one.error();
        scene.obstacles[k] = one.value();
    }
    const auto read = get_each(o.pins, o.pin_count, [&](std::size_t k, const dgm_pin& pin) {
        scene.pins[k] = {pin.sample, vec(pin.position)};
    });
    if (!read) return read.error();
    dgm::ClothStep options;
    if (o.substeps != 0) options.substeps = o.substeps;
    if (o.cycles != 0) options.cycles = o.cycles;
    if (o.dt != 0) options.dt = o.dt;
    options.gravity = vec(o.gravity);
    options.friction = number(o.friction, options.friction);
    options.tool_radius = o.tool_radius;
    options.obstacles = {scene.obstacles, o.obstacle_count};
    options.pins = {scene.pins, o.pin_count};
    return options;
}
}  // namespace

extern "C" {

dgm_code dgm_cloth_create(const dgm_state* state, const dgm_cloth_options* options, const dgm_allocator* allocator,
                          dgm_cloth** cloth, dgm_error* error) {
    if (state == nullptr || cloth == nullptr) return finish(kNull, error);
    *cloth = nullptr;
    dgm_cloth_options o;
    auto a = get(options, o, allocator);
    if (!a) return finish(a.error(), error);
    dgm::ClothOptions to;
    const dgm::Fabric usual = dgm::stored_fabric(state->value).value_or(dgm::Fabric{});
    to.fabric = {number(o.warp, usual.warp),      number(o.weft, usual.weft),       number(o.cross, usual.cross),
                 number(o.shear, usual.shear),    number(o.bending, usual.bending), number(o.density, usual.density),
                 number(o.damping, usual.damping)};
    to.metres_per_unit = o.metres_per_unit;
    to.thickness = number(o.thickness, to.thickness);
    to.self_contact = o.self_contact != 0;
    if (o.max_bytes != 0) to.max_bytes = o.max_bytes;
    to.plain_loops = o.plain_loops != 0;
    to.allocator = a.value();
    return hand_out(dgm::Cloth::create(state->value, to), a.value(), cloth, error);
}
void dgm_cloth_destroy(dgm_cloth* cloth) {
    dgm::detail::destroy(cloth);
}
dgm_code dgm_cloth_take_shape(dgm_cloth* cloth, const dgm_state* state, dgm_error* error) {
    if (cloth == nullptr || state == nullptr) return finish(kNull, error);
    return finish(cloth->value.take_shape(state->value).error(), error);
}

dgm_code dgm_cloth_step(dgm_state* state, dgm_cloth* cloth, const dgm_cloth_step_options* options,
                        const dgm_tool_input* tools, size_t tool_count, dgm_step_tool* answers,
                        dgm_cloth_report* report, dgm_error* error) {
    if (state == nullptr || cloth == nullptr || (tools == nullptr && tool_count != 0)) return finish(kNull, error);
    if (tool_count > kMaxScene)
        return finish({ErrorCode::LimitExceeded, kNoOffset, "there are more than 64 tools and obstacles"}, error);
    Scene scene;
    auto o = step_options(options, scene);
    if (!o) return finish(o.error(), error);
    dgm::ToolInput in[kMaxScene];
    dgm::StepTool out[kMaxScene];
    const auto read = get_each(tools, tool_count, [&](std::size_t k, const dgm_tool_input& t) {
        in[k] = {t.tool, static_cast<dgm::ToolKind>(t.kind), vec(t.position), t.lifted == 0};
    });
    if (!read) return finish(read.error(), error);
    auto done = dgm::step(state->value, cloth->value, o.value(), {in, tool_count}, {out, tool_count});
    if (!done) return finish(done.error(), error);
    for (std::size_t k = 0; answers != nullptr && k < tool_count; ++k) {
        dgm_step_tool t{};
        t.contacts = out[k].contacts;
        store(out[k].force, t.force);
        put(element(answers, k), t);
    }
    const dgm::ClothReport& r = done.value();
    put(report,
        dgm_cloth_report{0, r.contacts, r.touches, r.clamped ? 1u : 0u, r.kinetic, r.elastic, r.potential, r.residual});
    return finish({}, error);
}

}  // extern "C"
