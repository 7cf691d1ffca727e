// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_calls_c.cpp
// Any calls of dgm.h: structs of older versions (shorter) and newer ones (longer), null where null is allowed and where
// it is not. The promises are those of fuzz_calls_program.cpp, as far as C can see them.
#include <dgm/dgm.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include <dgm/limits.h>

#include "call_checks.h"
#include "fuzz_calls.h"

namespace dgm::test {
namespace {

using Floats = std::vector<float>;

class CProgram {
 public:
    CProgram(Dice& dice, std::span<const std::byte> bytes) : dice_(dice) {
        if (dgm_asset_open_memory(bytes.data(), bytes.size(), nullptr, nullptr, &asset_, error()) != DGM_OK) return;
        promise(dgm_asset_verify(asset_, error()) == DGM_OK, "a file that was made right is not verified");
        for (dgm_state** state : {&state_, &other_}) {
            const std::uint32_t chart = dice_.below(dgm_asset_chart_count(asset_) + (dice_.one_in(20) ? 1 : 0));
            dgm_state_options o{};
            o.struct_size = size_of(o);
            o.max_reach = dice_.one_in(3) ? dice_.below(70) : 0;
            o.metric = dice_.below(2);
            o.max_tools = dice_.one_in(9) ? dice_.below(70) : 0;
            o.plain_loops = dice_.below(2);
            static_cast<void>(dgm_state_create(asset_, chart, optional(o), nullptr, state, error()));
            look_at(chart);
        }
        if (state_ == nullptr) return;
        static_cast<void>(dgm_contact_solver_create(state_, nullptr, &solver_, error()));
        dgm_snapshot_options s{};
        s.struct_size = size_of(s);
        s.slots = dice_.below(5);
        s.no_normals = dice_.below(2);
        static_cast<void>(dgm_snapshots_create(state_, optional(s), nullptr, &snapshots_, error()));
        make_table();
    }
    CProgram(const CProgram&) = delete;
    CProgram& operator=(const CProgram&) = delete;
    ~CProgram() {
        dgm_asset_close(asset_);  // states outlive it
        dgm_state_release(state_);
        dgm_state_destroy(state_);
        dgm_state_destroy(other_);
        dgm_table_destroy(table_);
        dgm_contact_solver_destroy(solver_);
        dgm_snapshots_destroy(snapshots_);
    }

    void run() {
        if (state_ == nullptr || table_ == nullptr) return;
        for (std::uint32_t k = dice_.between(4, 24); k > 0; --k) {
            const Floats before = positions();
            const dgm_code code = step();
            if (code != DGM_OK && code != DGM_LIMIT_EXCEEDED)
                promise(before == positions(), "a call that failed changed the shape");
            check();
        }
    }

 private:
    /// Mostly this version's; those of older versions, and none, too. No version ends amid a pointer.
    template <class T>
    std::uint32_t size_of(const T&) {
        if (dice_.one_in(12)) return dice_.below(static_cast<std::uint32_t>(sizeof(T)) / 8 + 1) * 8 % (sizeof(T) + 1);
        return sizeof(T);
    }
    template <class T>
    T* optional(T& value) {
        return dice_.one_in(10) ? nullptr : &value;
    }
    dgm_error* error() {
        error_.struct_size = size_of(error_);
        return optional(error_);
    }
    [[nodiscard]] Floats positions() const {
        const float* xyz[3];
        const std::size_t count = dgm_state_positions(state_, xyz);
        Floats all;
        for (const float* plane : xyz) all.insert(all.end(), plane, plane + count);
        return all;
    }
    void check() const {
        const float* xyz[3];
        const std::size_t count = dgm_state_positions(state_, xyz);
        for (const float* plane : xyz)
            for (std::size_t k = 0; k < count; ++k) promise(std::isfinite(plane[k]), "a position is not finite");
        const std::uint32_t* members = nullptr;
        for (std::uint32_t id = 0;; ++id) {
            const std::size_t size = dgm_state_class_members(state_, id, &members);
            if (size == 0) break;
            for (std::size_t k = 1; k < size; ++k)
                for (const float* plane : xyz)
                    promise(std::memcmp(plane + members[0], plane + members[k], 4) == 0, "copies of a class are apart");
        }
    }

    void place(float to[3]) {
        const float* xyz[3];
        const std::size_t count = dgm_state_positions(state_, xyz);
        const std::uint32_t k = dice_.below(static_cast<std::uint32_t>(count));
        const float step = dgm_state_mean_step(state_);
        for (int d = 0; d < 3; ++d) to[d] = xyz[d][k] + step * dice_.real(-2, 2);
        if (dice_.one_in(5)) to[dice_.below(3)] = dice_.size(-kMaxCoordinate, kMaxCoordinate);
        if (dice_.one_in(60)) to[dice_.below(3)] = dice_.absurd();
    }
    void make_table() {
        Floats values;
        const KernelOptions from = random_kernel(dice_, values);
        dgm_kernel_options o{};
        o.struct_size = size_of(o);
        o.shape = static_cast<std::uint32_t>(from.shape);
        o.end = static_cast<std::uint32_t>(from.end);
        o.reach = from.reach;
        o.sigma = from.sigma;
        o.radius_a = from.radius_a;
        o.radius_b = from.radius_b;
        o.angle = from.angle;
        o.values = values.data();
        o.value_count = values.size();
        if (dgm_table_create(&o, nullptr, &table_, error()) != DGM_OK) return;
        promise(std::fabs(dgm_table_weight(table_, dice_.real(-9, 9), dice_.absurd())) <= 1, "a weight is beyond 1");
        promise(std::fabs(dgm_table_profile(table_, dice_.absurd())) <= 1, "a profile is beyond 1");
    }
    /// Calls that need no state.
    void look_at(std::uint32_t chart) {
        dgm_chart_info info{};
        info.struct_size = size_of(info);
        dgm_layer_view view{};
        view.struct_size = size_of(view);
        static_cast<void>(dgm_asset_chart(asset_, chart, &info, error()));
        static_cast<void>(dgm_asset_layer(asset_, chart, dice_.below(12), &view, error()));
        static_cast<void>(dgm_asset_find_layer(
            asset_, chart, dice_.of({"seams", "", static_cast<const char*>(nullptr)}), &view, error()));
        static_cast<void>(dgm_chart_validate(asset_, chart, nullptr, error()));
    }

    dgm_code step() {
        switch (dice_.below(10)) {
            case 0:
            case 1:
                return touch();
            case 2:
            case 3:
            case 4:
                return turn();
            case 5:
            case 6:
                return contact();
            case 7:
                return search();
            case 8:
                return others();
            default:
                return mesh();
        }
    }
    dgm_code touch() {
        dgm_touch t{};
        t.struct_size = size_of(t);
        t.sample = dice_.below(dgm_state_sample_count(state_) + 1);
        place(t.displacement);
        t.d_max = dice_.size(1e-38f, 3e38f);
        t.footprint = dice_.below(5);
        t.mode = dice_.below(3);
        t.step = dice_.one_in(3) ? dice_.size(kMinStep, kMaxStep) : 0;
        DGM_SAY("C: deform sample %u d %g %g %g d_max %g footprint %u mode %u step %g\n", t.sample, t.displacement[0],
                t.displacement[1], t.displacement[2], t.d_max, t.footprint, t.mode, t.step);
        dgm_deform_report r{};
        r.struct_size = size_of(r);
        return dgm_deform(state_, table_, &t, optional(r), error());
    }
    dgm_code turn() {
        dgm_tool_input tools[3]{};
        dgm_tool_output out[3]{};
        const std::uint32_t in_size = size_of(tools[0]), out_size = size_of(out[0]);
        // Elements stand struct_size apart: fill them where the library will look.
        for (std::uint32_t k = 0; k < 3; ++k) {
            dgm_tool_input t{};
            t.struct_size = in_size;
            t.tool = k;
            t.kind = dice_.below(dice_.one_in(30) ? 5 : 3);
            t.lifted = dice_.below(2);
            place(t.position);
            if (in_size >= 4) std::memcpy(reinterpret_cast<char*>(tools) + std::size_t{k} * in_size, &t, in_size);
        }
        for (std::uint32_t k = 0; k < 3 && out_size >= 4; ++k)
            std::memcpy(reinterpret_cast<char*>(out) + std::size_t{k} * out_size, &out_size, 4);
        dgm_tick_options o{};
        o.struct_size = size_of(o);
        o.footprint = dice_.below(4);
        o.mode = dice_.below(2);
        o.rule = dice_.below(2);
        o.skip_normals = dice_.below(2);
        o.dt = dice_.one_in(3) ? dice_.size(0, 1e30f) : 0;
        o.d_max = dice_.size(1e-38f, 3e38f);
        o.f_max = dice_.size(0, 1e38f);
        o.relax_rate = dice_.of({0.0f, -1.0f, 5.0f, 3e38f});
        o.settle_time = dice_.of({0.0f, -1.0f, 1e-30f, 1e30f});
        o.grasp_distance = dice_.of({0.0f, 1e30f, INFINITY});
        DGM_SAY(
            "C: tick d_max %g relax %g settle %g dt %g rule %u footprint %u mode %u, tool 0 kind %u lifted %u at %g %g "
            "%g, "
            "middle %g\n",
            o.d_max, o.relax_rate, o.settle_time, o.dt, o.rule, o.footprint, o.mode, tools[0].kind, tools[0].lifted,
            tools[0].position[0], tools[0].position[1], tools[0].position[2], dgm_table_profile(table_, 0));
        dgm_tick_report r{};
        r.struct_size = size_of(r);
        const std::uint32_t count = dice_.below(4);
        const dgm_code code = dgm_tick(state_, table_, &o, tools, count, optional(out[0]), optional(r), error());
        return code;
    }
    dgm_code contact() {
        dgm_obstacle o{};
        o.struct_size = size_of(o);
        o.kind = dice_.below(6);
        place(o.point);
        place(o.end);
        o.normal[dice_.below(3)] = dice_.of({1.0f, -1.0f, 1e-38f});
        o.radius = dice_.one_in(3) ? dice_.size(1e-30f, kMaxCoordinate) : 2 * dgm_state_mean_step(state_);
        for (float& h : o.half) h = dice_.one_in(3) ? dice_.size(1e-30f, kMaxCoordinate) : dgm_state_mean_step(state_);
        o.surface = other_;
        float point[3], distance = 0, nearest[3] = {};
        place(point);
        if (dgm_obstacle_distance(&o, point, &distance, nearest, error()) == DGM_OK)
            promise(std::isfinite(distance) && std::isfinite(nearest[0]), "an obstacle's distance is not finite");
        dgm_ring_size rings[2]{};
        for (dgm_ring_size& ring : rings)
            ring = {sizeof ring, dice_.size(0, 1e30f), dice_.size(1e-15f, 1e18f), dice_.size(1e-30f, 1e36f)};
        dgm_contact_options w{};
        w.struct_size = size_of(w);
        w.bulge = dice_.below(4);
        w.mode = dice_.below(2);
        w.smoothing = dice_.below(66);
        w.no_smoothing = dice_.below(2);
        w.max_depth = dice_.one_in(3) ? dice_.size(0, 1e30f) : 0;
        w.rings = rings;
        w.ring_count = dice_.below(3);
        dgm_contact_report r{};
        r.struct_size = size_of(r);
        DGM_SAY("C: obstacle %u point %g %g %g normal %g %g %g radius %g half %g %g %g bulge %u\n", o.kind, o.point[0],
                o.point[1], o.point[2], o.normal[0], o.normal[1], o.normal[2], o.radius, o.half[0], o.half[1],
                o.half[2], w.bulge);
        return dgm_resolve_contact(state_, solver_, &o, optional(w), optional(r), error());
    }
    dgm_code search() {
        float tool[3], distance = 0, normal[3];
        place(tool);
        std::uint32_t sample = 0, lost = 0;
        const std::uint32_t last = dice_.below(dgm_state_sample_count(state_) + 1),
                            count = dgm_state_sample_count(state_);
        if (dgm_nearest_sample(state_, tool, &sample, &distance, error()) == DGM_OK)
            promise(sample < count && std::isfinite(distance), "the nearest sample is none");
        static_cast<void>(dgm_track_sample(state_, tool, last, dice_.below(9), &sample, nullptr, error()));
        static_cast<void>(dgm_state_normal(state_, last, normal, error()));
        static_cast<void>(dgm_state_position(state_, last, tool, error()));
        return dgm_track_nearest(state_, tool, last, dice_.below(9), &sample, &distance, &lost, error());
    }
    dgm_code others() {
        switch (dice_.below(5)) {
            case 0:
                dgm_state_release(state_);
                return DGM_OK;
            case 1:
                dgm_state_reset(state_);
                return DGM_OK;
            case 2:
                return dgm_state_relax(state_, dice_.size(0, 1e38f), dice_.of({0.0f, 1.0f, INFINITY, -1.0f}), error());
            case 3:
                dgm_state_update_normals(state_);
                return DGM_OK;
            default: {
                Floats all(3 * std::size_t{dgm_state_sample_count(state_)});
                dgm_snapshot_info info{};
                info.struct_size = size_of(info);
                static_cast<void>(dgm_snapshots_publish(snapshots_, state_, 3, nullptr, error()));
                return dgm_snapshots_read(snapshots_, all.data(), nullptr, all.size() / dice_.between(1, 2),
                                          optional(info), error());
            }
        }
    }
    dgm_code mesh() {
        dgm_vertex_target v{};
        v.struct_size = size_of(v);
        v.lod_stride = dice_.below(9);
        v.strips = dice_.below(2);
        v.stride = dice_.of({std::size_t{32}, std::size_t{12}, std::size_t{0}});
        v.normal_offset = dice_.one_in(2) ? 12 : DGM_NO_ATTRIBUTE;
        v.uv_offset = dice_.one_in(2) ? 24 : DGM_NO_ATTRIBUTE;
        v.position_format = dice_.below(4);
        v.step[0] = v.step[1] = v.step[2] = dice_.size(1e-38f, 1e38f);
        std::vector<std::byte> memory(dgm_state_sample_count(state_) * v.stride);
        v.data = memory.data();
        v.bytes = memory.size();
        dgm_mesh_counts counts{sizeof counts, 0, 0};
        static_cast<void>(
            dgm_state_mesh_counts_at(state_, v.lod_stride == 0 ? 1 : v.lod_stride, v.strips, &counts, error()));
        std::vector<std::uint32_t> indices(static_cast<std::size_t>(counts.indices));
        return dgm_state_reconstruct(state_, &v, indices.data(), indices.size(), &counts, error());
    }

    Dice& dice_;
    dgm_error error_{};
    dgm_asset* asset_ = nullptr;
    dgm_state *state_ = nullptr, *other_ = nullptr;
    dgm_table* table_ = nullptr;
    dgm_contact_solver* solver_ = nullptr;
    dgm_snapshots* snapshots_ = nullptr;
};
}  // namespace

void call_c(Dice& dice, std::span<const std::byte> bytes) {
    CProgram(dice, bytes).run();
}

}  // namespace dgm::test
