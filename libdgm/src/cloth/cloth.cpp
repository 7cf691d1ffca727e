// SPDX-License-Identifier: MIT
// libdgm/src/cloth/cloth.cpp
// Makes a Cloth and checks the arguments of a step. What is not in every step is cold: built small.
#include <dgm/cloth.h>
#include <dgm/limits.h>

#include <algorithm>
#include <cmath>

#include "cloth/cloth_impl.h"
#include "cloth/frame.h"

namespace dgm {
namespace detail {
namespace {
using namespace cloth;

constexpr Error bad(const char* message) noexcept {
    return {ErrorCode::BadArgument, kNoOffset, message};
}
constexpr Error unsupported(const char* message) noexcept {
    return {ErrorCode::Unsupported, kNoOffset, message};
}
bool within(double v, double low, double high) noexcept {
    return v >= low && v <= high;
}

[[gnu::cold]] Result<void> check_options(const ClothOptions& o) noexcept {
    const Fabric& f = o.fabric;
    if (!is_valid(o.allocator)) return bad("the allocator is half empty");
    if (o.metres_per_unit == 0) return unsupported("the unit is not known: set metres_per_unit or bake with --unit");
    if (!within(o.metres_per_unit, 1e-9, 1e9)) return bad("the unit is not in 1e-9 .. 1e9 m");
    if (!within(double{f.warp}, 0.99e-3, 1e9)) return bad("the warp is not in 1e-3 .. 1e9 N/m");
    if (!within(double{f.weft}, 0.99e-3, 1e9)) return bad("the weft is not in 1e-3 .. 1e9 N/m");
    if (!within(double{f.shear}, 0.99e-6, 1e9)) return bad("the shear is not in 1e-6 .. 1e9 N/m");
    if (!within(double{f.cross}, 0, 0.95 * std::sqrt(double{f.warp} * double{f.weft})))
        return bad("the cross modulus is not in 0 .. 0.95 sqrt(warp weft)");
    if (!within(double{f.bending}, 0, 1e9)) return bad("the bending is not in 0 .. 1e9 N m");
    if (!within(double{f.density}, 0.99e-6, 1e6)) return bad("the density is not in 1e-6 .. 1e6 kg/m^2");
    if (!within(double{f.damping}, 0, 1e6)) return bad("the damping is not in 0 .. 1e6 1/s");
    if (!within(double{o.thickness}, 0, 1e6)) return bad("the thickness is not in 0 .. 1e6 m");
    if (o.self_contact && o.thickness == 0) return bad("contact of the cloth with itself needs a thickness");
    return {};
}

[[gnu::cold]] Result<void> check_map(const StateImpl& s, const ClothOptions& o) noexcept {
    if (s.tables.free_domain) return unsupported("free domains have no cloth; bake it with --domain square");
    if (!s.reversed.empty()) return unsupported("a surface with one side has no cloth");
    if (s.tables.rows < 3 || s.tables.cols < 3) return unsupported("the grid has fewer than 3 x 3 samples");
    for (std::uint32_t k = 0; k < s.total(); ++k)
        if (!s.tables.on_surface(k)) return unsupported("a map with a mask has no cloth");
    const double step = double{s.mean_step} * o.metres_per_unit;
    if (!within(step, 1e-7, 1e5)) return unsupported("the mean grid step is not in 1e-7 .. 1e5 m");
    if (double{o.thickness} > step && o.self_contact)
        return bad("contact of the cloth with itself needs a thickness below the mean grid step");
    return {};
}

/// Upper bound of what build_model() takes, measured on grids of 9 x 9 to 257 x 257.
[[gnu::cold]] std::uint64_t bytes_needed(std::uint32_t rows, std::uint32_t cols, bool self_contact) noexcept {
    const std::uint64_t pitch = (cols + kBlock) / kBlock * kBlock, plane = (rows + 2) * pitch + 2 * kBlock;
    const std::uint64_t fine = plane * (4 * (54 + 27) + 8 * 9), all = fine + fine / 2 + plane * 40;
    return all + std::uint64_t{rows} * cols * (self_contact ? 320 : 240) + 400 * pitch + sizeof(ClothImpl) + 32768;
}

[[gnu::cold]] Result<void> check_tools(const ClothStep& o, std::span<const ToolInput> tools,
                                       std::size_t answers) noexcept {
    if (answers != 0 && answers < tools.size()) return bad("there are fewer answers than tools");
    if (tools.size() + o.obstacles.size() > Scene::kMost)
        return Error{ErrorCode::LimitExceeded, kNoOffset, "there are more than 64 tools and obstacles"};
    if (!tools.empty() && !(o.tool_radius > 0 && o.tool_radius <= kMaxCoordinate))
        return bad("the tools' radius is not a number above 0");
    std::uint64_t named = 0;
    for (const ToolInput& in : tools) {
        if (!is_place(in.position)) return bad("a coordinate of a tool is beyond 1e18");
        if (in.kind > ToolKind::Grasp) return unsupported("the tool kind is not known");
        if (in.tool >= Scene::kMost) return bad("a tool's number is beyond 63");
        if ((named >> in.tool & 1) != 0) return bad("a tool is named twice");
        named |= std::uint64_t{1} << in.tool;
    }
    return {};
}

[[gnu::cold]] Result<void> check_step(const ClothImpl& c, const StateImpl& s, const ClothStep& o) noexcept {
    if (c.rows != s.tables.rows || c.cols != s.tables.cols || c.total != s.total())
        return bad("the cloth was made for a state of another size");
    if (!within(double{o.dt}, 0.99e-5, 10)) return bad("the time step is not in 1e-5 .. 10 s");
    if (o.substeps < 1 || o.substeps > 100) return bad("the number of substeps is not in 1 .. 100");
    if (o.cycles < 1 || o.cycles > 100) return bad("the number of cycles is not in 1 .. 100");
    if (!within(double{o.friction}, 0, 100)) return bad("the friction is not in 0 .. 100");
    if (!is_finite(o.gravity) || !(dot(o.gravity, o.gravity) <= 1e12f)) return bad("gravity is not below 1e6 m/s^2");
    for (const Pin& pin : o.pins) {
        if (pin.sample >= c.total) return bad("a pin names no sample");
        if (!is_place(pin.position)) return bad("a coordinate of a pin is beyond 1e18");
    }
    return {};
}

Result<void> make_scene(ClothImpl& c, const StateImpl& s, const ClothStep& o, std::span<const ToolInput> tools,
                        FrameScene& scene) noexcept {
    scene.count = 0;
    for (std::uint32_t t = 0; t < tools.size(); ++t) {
        const ToolInput& in = tools[t];
        if (in.kind == ToolKind::Grasp || !in.engaged) continue;
        const std::uint32_t k = scene.count;
        add_tool(scene, in, double{o.tool_radius});
        scene.tool[k] = t;
        scene.from[k] = scene.shapes[k];
        if ((c.known >> in.tool & 1) != 0) scene.from[k].point = widen(c.tool_before[in.tool]);
    }
    std::fill(scene.tool + scene.count, scene.tool + scene.count + o.obstacles.size(), kNone);
    return add_obstacles(scene, o.obstacles, s);
}

/// Marks pinned samples. @return false, and nothing is marked: one is pinned twice.
bool mark_pins(ClothImpl& c, std::span<const Pin> pins) noexcept {
    std::size_t count = 0;
    for (; count < pins.size() && c.pinned[pins[count].sample] == 0; ++count)
        each_copy(c, pins[count].sample, [&](std::uint32_t s) { c.pinned[s] = 1; });
    if (count == pins.size()) return true;
    while (count-- > 0) each_copy(c, pins[count].sample, [&](std::uint32_t s) { c.pinned[s] = 0; });
    return false;
}
}  // namespace
}  // namespace detail

[[gnu::cold]] std::optional<Fabric> stored_fabric(const State& state) noexcept {
    const float(&m)[kMaterialValues] = state.impl()->material;  // unit, membrane, Poisson's ratio, bending, ...
    if (!(m[5] > 0)) return std::nullopt;
    const float warp = m[1] / (1 - m[2] * m[2]);
    Fabric f;
    f.warp = f.weft = warp;
    f.cross = m[2] * warp;
    f.shear = 0.5f * (1 - m[2]) * warp;
    f.bending = m[3];
    f.density = m[5];
    return f;
}

[[gnu::cold]] Result<Cloth> Cloth::create(const State& state, const ClothOptions& asked) noexcept {
    ClothOptions options = asked;
    const detail::StateImpl& s = *state.impl();
    if (options.metres_per_unit == 0) options.metres_per_unit = double{s.material[0]};
    if (auto r = detail::check_options(options); !r) return r.error();
    if (auto r = detail::check_map(s, options); !r) return r.error();
    if (detail::bytes_needed(s.tables.rows, s.tables.cols, options.self_contact) > options.max_bytes)
        return detail::over_max_bytes();
    auto* c = detail::create<detail::ClothImpl>(options.allocator, options.allocator);
    if (c == nullptr) return detail::cloth::kNoMemory;
    Cloth made(c);
    c->options = options;
    c->rows = s.tables.rows;
    c->cols = s.tables.cols;
    c->total = s.total();
    c->scale = options.metres_per_unit;
    c->mean_step = double{s.mean_step} * c->scale;
    c->kernels = &detail::cloth::choose_kernels(options.plain_loops);
    if (auto r = detail::cloth::build_model(*c, s); !r) return r.error();
    detail::cloth::place_at(*c, detail::StateImpl::fixed(s.rest));
    return made;
}

Cloth::Cloth(Cloth&& other) noexcept : impl_(std::exchange(other.impl_, nullptr)) {}
Cloth& Cloth::operator=(Cloth&& other) noexcept {
    std::swap(impl_, other.impl_);
    return *this;
}
Cloth::~Cloth() {
    detail::destroy(impl_);
}

[[gnu::cold]] Result<void> Cloth::take_shape(const State& state) noexcept {
    const detail::StateImpl& s = *state.impl();
    const detail::ClothImpl& c = *impl_;
    if (c.rows != s.tables.rows || c.cols != s.tables.cols || c.total != s.total())
        return detail::bad("the cloth was made for a state of another size");
    detail::cloth::place_at(*impl_, detail::StateImpl::fixed(s.now));
    return {};
}

Result<ClothReport> step(State& state, Cloth& cloth, const ClothStep& options, std::span<const ToolInput> tools,
                         std::span<StepTool> answers) noexcept {
    detail::ClothImpl& c = *cloth.impl();
    detail::StateImpl& s = *state.impl();
    if (auto r = detail::check_step(c, s, options); !r) return r.error();
    if (auto r = detail::check_tools(options, tools, answers.size()); !r) return r.error();
    detail::cloth::FrameScene& scene = c.scene;
    if (auto r = detail::make_scene(c, s, options, tools, scene); !r) return r.error();
    if (!detail::mark_pins(c, options.pins)) return detail::bad("a sample or a copy of it is pinned twice");
    state.release();  // touches of tick() end; the boxes stay those of the cloth
    return detail::cloth::run_frame(c, state, options, tools, answers);
}

}  // namespace dgm
