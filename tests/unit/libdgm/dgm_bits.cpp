// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/dgm_bits.cpp
// dgm_bits [--quick] [--few]: runs the runtime over charts of every kind and prints a hash of what came out after each
// step, a line a step. scripts/platforms and the tests libdgm.bits_* compare the lines of all targets. Plain loops,
// which promise equal bits everywhere; with --quick the processor's own, which two compilers for one processor should
// give alike. With --few a third of the work, for emulated processors: each step, not on all charts and for as long.
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include <dgm/asset.h>
#include <dgm/cloth.h>
#include <dgm/collide.h>
#include <dgm/compliance.h>
#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/physics.h>
#include <dgm/reconstruct.h>
#include <dgm/state.h>
#include <dgm/tick.h>

#include "base/portable_math.h"
#include "exact_shapes.h"

namespace dgm::test {
namespace {

struct NamedFootprint {
    const char* name;
    Footprint footprint;
};
constexpr NamedFootprint kFootprints[] = {
    {"grid", Footprint::Grid},
    {"metric", Footprint::Metric},
    {"geodesic", Footprint::Geodesic},
};

bool plain = true, few = false;
bool sound = true;  // every call gave a value

template <class T>
T good(Result<T>&& result, const char* what) {
    if (!result) {
        std::printf("%s failed: %s\n", what, result.error().message);
        std::fflush(stdout);
    }
    return std::move(result).value();
}

/// Values in the order they came, hashed field by field: padding has no bits to compare.
class Digest {
 public:
    template <class... T>
    void add(const T&... values) {
        (append(&values, sizeof values), ...);
    }
    void add(Vec3 v) { add(v.x, v.y, v.z); }
    void append(const void* data, std::size_t bytes) {
        const auto* from = static_cast<const std::byte*>(data);
        bytes_.insert(bytes_.end(), from, from + bytes);
    }
    [[nodiscard]] unsigned long long hash() const { return XXH3_64bits(bytes_.data(), bytes_.size()); }

 private:
    Bytes bytes_;
};

struct Map {
    std::string name;
    Image image;
    Asset asset;
    std::uint32_t rows, cols;
    Map(std::string n, const ChartSpec& chart)
        : name(std::move(n)),
          image(build({chart})),
          asset(good(Asset::open_memory(image.bytes), "open")),
          rows(chart.rows),
          cols(chart.cols) {}
    [[nodiscard]] State state() const {
        StateOptions options;
        options.plain_loops = plain;
        options.metric = true;
        return good(State::create(good(asset.chart(0), "chart"), options), "state");
    }
    /// Inside, at a seam or border, in a corner, and the last: a border sample of a free domain.
    [[nodiscard]] std::vector<std::uint32_t> contacts(const State& state) const {
        std::vector<std::uint32_t> samples;
        for (const std::uint32_t k : {rows / 2 * cols + cols / 2, rows / 3 * cols + 1, rows / 2 * cols,
                                      (rows - 2) * cols + 1, 0u, state.sample_count() - 1})
            if (state.on_surface(k)) samples.push_back(k);
        return samples;
    }
};

void print(const std::string& step, const State& state, const Digest& reports) {
    Digest positions, normals;
    const PointView p = state.positions(), n = state.normals();
    for (std::size_t k = 0; k < p.count; ++k) positions.add(p[k]);
    for (std::size_t k = 0; k < n.count; ++k) normals.add(n[k]);
    std::printf("%-52s %016llx %016llx %016llx\n", step.c_str(), positions.hash(), normals.hash(), reports.hash());
}

struct NamedKernel {
    const char* name;
    KernelOptions options;
};
std::vector<NamedKernel> kernels() {
    static const float kWeights[] = {1, 0.875f, 0.9f, 0.3f, -0.125f, 0};
    KernelOptions printed, compact, wide, ellipse, far_turned, user;
    printed.sigma = 13.7f;
    compact = printed;
    compact.end = KernelEnd::Compact;
    wide = compact;
    wide.sigma = 5000;
    wide.reach = 9;
    ellipse.shape = KernelShape::Elliptic;
    ellipse.radius_a = 5.5f;
    ellipse.radius_b = 2.25f;
    ellipse.angle = 0.7f;
    far_turned = ellipse;
    far_turned.end = KernelEnd::Compact;
    far_turned.angle = -3.5e12f;
    user.shape = KernelShape::User;
    user.values = kWeights;
    return {{"printed", printed}, {"compact", compact},       {"wide", wide},
            {"ellipse", ellipse}, {"far_turned", far_turned}, {"user", user}};
}

void deform_all(const Map& map) {
    State state = map.state();
    for (const NamedKernel& kernel : kernels()) {
        const DeformTable table = good(DeformTable::create(kernel.options), "table");
        for (const NamedFootprint& f : kFootprints) {
            state.reset();
            Digest reports;
            int turn = 0;
            for (const std::uint32_t sample : map.contacts(state)) {
                Touch touch;
                touch.sample = sample;
                touch.displacement = {0.3f, -0.2f * static_cast<float>(turn), 1.1f};
                touch.d_max = 1;
                touch.footprint = f.footprint;
                touch.mode = ++turn % 2 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
                const DeformReport r = good(deform(state, table, touch), "deform");
                reports.add(r.samples, r.crossed_seam, r.truncated);
                reports.add(r.displacement);
            }
            for (const float at : {0.0f, 0.5f, 1.25f, 7.75f, 20.0f})
                reports.add(table.weight(at, -0.5f * at), table.profile(at));
            state.update_normals();
            print(map.name + " deform " + kernel.name + " " + f.name, state, reports);
        }
    }
}

/// Tools circle over the middle of the surface, press and lift.
Vec3 tool_at(const State& rest, const Map& map, std::uint32_t tool, int k) {
    const Turn a = turn(0.01 * k + 0.3 * tool), b = turn(0.037 * k);
    const auto i = static_cast<std::uint32_t>(map.rows * (0.5 + 0.3 * a.cosine));
    const auto j = static_cast<std::uint32_t>(map.cols * (0.5 + 0.45 * a.sine));
    const std::uint32_t sample = i * map.cols + j;
    const auto depth = static_cast<float>(0.6 * b.sine - 0.3);
    return rest.rest_positions()[sample] + depth * rest.normal(sample);
}

void tick_all(const Map& map) {
    const DeformTable table = good(DeformTable::create({}), "table");
    const State rest = map.state();
    for (const NamedFootprint& f : kFootprints)
        for (const bool fading : {false, true})
            for (const ContactRule rule : {ContactRule::Smooth, ContactRule::Printed}) {
                State state = map.state();
                TickOptions options;
                options.footprint = f.footprint;
                options.relax_rate = fading ? 35.0f : options.relax_rate;
                options.rule = rule;
                options.d_max = 1.5f;
                Digest reports;
                const int ticks = few ? 80 : 160;
                for (int k = 0; k < ticks; ++k) {
                    ToolInput in[3];
                    ToolOutput out[3];
                    for (std::uint32_t t = 0; t < 3; ++t) {
                        in[t].tool = t;
                        in[t].kind = static_cast<ToolKind>(t);
                        in[t].position = tool_at(rest, map, t, k);
                        in[t].engaged = k % 80 < 70;
                    }
                    options.mode = k > ticks * 3 / 4 ? DeformMode::Plastic : DeformMode::Elastic;
                    const TickReport r = good(tick(state, table, options, in, out), "tick");
                    reports.add(r.contacts, r.samples, r.crossed_seam, r.truncated);
                    for (const ToolOutput& o : out) {
                        reports.add(o.sample, o.distance, o.hit, o.lost, o.holding, o.contact);
                        reports.add(o.displacement);
                        reports.add(o.force);
                    }
                    if (k % 80 == 79 || k == 40)
                        print(map.name + " tick " + f.name + (fading ? " fading " : " at once ") +
                                  (rule == ContactRule::Smooth ? "smooth " : "printed ") + std::to_string(k),
                              state, reports);
                }
                if (fading && !state.relax(0.01f, 20)) sound = false;
                state.release();
                print(map.name + " tick " + f.name + " released", state, reports);
            }
}

struct NamedObstacle {
    const char* name;
    Obstacle obstacle;
};
/// Each a little way into the surface at its middle sample, from outside.
std::vector<NamedObstacle> obstacles(const Map& map, const State& state, State& other) {
    const std::uint32_t middle = map.rows / 2 * map.cols + map.cols / 2;
    const Vec3 p = state.positions()[middle], n = state.normal(middle);
    std::vector<NamedObstacle> all(5, NamedObstacle{"", {}});
    const char* const names[] = {"plane", "sphere", "capsule", "box", "surface"};
    for (std::uint32_t k = 0; k < 5; ++k) {
        all[k].name = names[k];
        Obstacle& o = all[k].obstacle;
        o.kind = static_cast<ObstacleKind>(k);
        o.radius = 3;
        o.normal = -1.0f * n;
        o.point = p - 0.4f * n;
        o.half = {2, 1.5f, 3};
    }
    // A quarter turn by 3-4-5, and not more exactly orthogonal than it can be.
    const float turned[9] = {0.6f, -0.8f, 0, 0.8f, 0.6f, 0, 0, 0, 1};
    std::memcpy(all[3].obstacle.rotation, turned, sizeof turned);
    all[1].obstacle.point = all[2].obstacle.point = p + 2.5f * n;
    all[2].obstacle.end = all[2].obstacle.point + Vec3{1, 2, 0.5f};
    all[3].obstacle.point = p + 1.25f * n;
    all[4].obstacle.surface = &other;
    // The lowest sample of the other surface goes into this one.
    const PointView q = other.positions();
    std::size_t lowest = 0;
    for (std::size_t k = 0; k < q.count; ++k)
        if (other.on_surface(static_cast<std::uint32_t>(k)) && dot(q[k], n) < dot(q[lowest], n)) lowest = k;
    all[4].obstacle.point = p - 0.4f * n - q[lowest];
    return all;
}

void contact_all(const Map& map, const Map& other_map) {
    State state = map.state(), other = other_map.state();
    const ContactSolver solver = good(ContactSolver::create(state), "solver");
    Digest volume;
    volume.add(solver.closed(), solver.volume(state));
    print(map.name + " volume", state, volume);
    for (const NamedObstacle& o : obstacles(map, state, other))
        for (const Bulge bulge : {Bulge::Exact, Bulge::Paper, Bulge::None}) {
            state.reset();
            ContactOptions options;
            options.bulge = bulge;
            options.mode = bulge == Bulge::Paper ? DeformMode::Plastic : DeformMode::Elastic;
            const ContactReport r = good(resolve_contact(state, solver, o.obstacle, options), "contact");
            Digest report;
            report.add(r.status, r.volume_kept, r.sunk, r.samples, r.deepest, r.total, r.ring, r.ring_reach,
                       r.ring_sigma, r.beta, r.passes, r.removed, r.volume_error, r.first_order_error, r.paper_error);
            state.update_normals();
            print(map.name + " contact " + o.name + " " + std::to_string(static_cast<int>(bulge)) + " moved " +
                      std::to_string(r.samples),
                  state, report);
        }
}

void reconstruct_all(const Map& map) {
    State state = map.state();
    const DeformTable table = good(DeformTable::create({}), "table");
    Touch touch;
    touch.sample = map.contacts(state)[0];
    touch.displacement = {0, 1, 2};
    touch.d_max = 3;
    good(deform(state, table, touch), "deform");
    state.update_normals();
    for (const VertexFormat format : {VertexFormat::F32, VertexFormat::F16, VertexFormat::U16})
        for (const std::uint32_t stride : {1u, 3u}) {
            ReconstructOptions options;
            options.lod_stride = stride;
            options.topology = stride == 1 ? IndexTopology::Triangles : IndexTopology::Strips;
            const MeshCounts counts = good(mesh_counts(state, options), "counts");
            VertexTarget target;
            Bytes memory(counts.vertices * std::size_t{32});
            target.memory = memory;
            target.stride = 32;
            target.normal_offset = 12;
            target.uv_offset = 24;
            target.position_format = target.normal_format = target.uv_format = format;
            target.origin = {-12, -12, -12};
            target.step = {0.001f, 0.001f, 0.001f};
            std::vector<std::uint32_t> indices(counts.indices);
            good(reconstruct(state, target, indices, options), "reconstruct");
            Digest out;
            out.append(memory.data(), memory.size());
            out.append(indices.data(), indices.size() * sizeof indices[0]);
            print(map.name + " reconstruct format " + std::to_string(static_cast<int>(format)) + " stride " +
                      std::to_string(stride),
                  state, out);
        }
}

void collide_all(const Map& map) {
    State state = map.state();
    Digest found;
    std::uint32_t last = map.contacts(state)[0];
    for (int k = 0; k < 200; ++k) {
        const Turn a = turn(0.013 * k), b = turn(0.05 * k);
        const Vec3 tool{static_cast<float>(9 * a.cosine), static_cast<float>(9 * a.sine),
                        static_cast<float>(8 * b.sine)};
        const Nearest nearest = good(nearest_sample(state, tool), "nearest");
        const Tracked tracked = good(track_nearest(state, tool, last, 4), "track");
        last = tracked.sample;
        found.add(nearest.sample, nearest.distance, tracked.sample, tracked.distance, tracked.lost);
    }
    print(map.name + " collide", state, found);
}

/// A ball goes in, one sample is pinned, another is pulled, all under gravity: contacts, grasps, pressure, viscosity.
void physics_all(const Map& map, Solver solver) {
    State state = map.state();
    PhysicsOptions options;
    options.metres_per_unit = 5e-3;
    options.material = Material{};
    options.material->viscosity = 1e-3f;
    options.plain_loops = plain;
    options.solver = solver;
    const std::string name = map.name + (solver == Solver::Factors ? " factored physics" : " physics");
    auto made = Physics::create(state, options);
    if (!made) {
        Digest refused;
        refused.add(made.error().code);
        return print(name + " refused", state, refused);
    }
    Physics physics = std::move(made).value();
    ComplianceOptions two;
    two.tools = 2;
    Compliance compliance = good(Compliance::create(state, physics, two), "compliance");
    ComplianceReader reader = good(ComplianceReader::create(compliance), "reader");
    const Vec3 top = state.rest_positions()[map.contacts(state)[0]];
    const Pin pin{map.rows * map.cols / 3, state.rest_positions()[map.rows * map.cols / 3]};
    StepOptions how;
    how.tool_radius = 2;
    how.gravity = {0, 0, -9.75f};
    if (solver == Solver::Multigrid) how.pins = {&pin, 1};
    for (int k = 0; k < 24; ++k) {
        if (k == 12 && !physics.set_dt(1.0f / 64)) sound = false;
        ToolInput tools[2];
        tools[0].position = top + Vec3{0, 0, 2 - 0.0625f * static_cast<float>(k)};
        tools[1].tool = 1;
        tools[1].kind = ToolKind::Grasp;
        tools[1].position = pin.position + Vec3{1, 0.125f * static_cast<float>(k), 0};
        StepTool answers[2];
        const StepReport r = good(step(state, physics, how, tools, answers), "step");
        Digest report;
        report.add(r.volume_error, r.pressure, r.residual, r.kinetic, r.elastic, r.contacts, r.cycles, r.clamped,
                   answers[0].contacts, answers[1].contacts);
        report.add(answers[0].force);
        report.add(answers[1].force);
        if (k % 4 != 3) continue;
        const ComplianceReport p = good(compliance.publish(state, physics, how, tools), "publish");
        for (ToolInput& t : tools) t.position = t.position + Vec3{0, 0.0625f, -0.0625f};
        ComplianceAnswer felt[2];
        if (!compliance_tick(reader, tools, felt)) sound = false;
        report.add(p.columns, p.samples, felt[0].contacts, felt[1].contacts);
        report.add(felt[0].force);
        report.add(felt[1].force);
        state.update_normals();
        print(name + " step " + std::to_string(k + 1), state, report);
    }
}

/// Falls on a ball, one sample pinned, another pulled, rubbing on the ball and on itself.
void cloth_all(const Map& map) {
    State state = map.state();
    ClothOptions options;
    options.metres_per_unit = 5e-3;
    options.self_contact = true;
    options.plain_loops = plain;
    auto made = Cloth::create(state, options);
    if (!made) {
        Digest refused;
        refused.add(made.error().code);
        return print(map.name + " cloth refused", state, refused);
    }
    Cloth cloth = std::move(made).value();
    const PointView rest = state.rest_positions();
    const std::uint32_t pulled = map.contacts(state)[0], held = map.rows * map.cols / 3;
    const Pin pin{held, rest[held]};
    Obstacle ball;
    ball.kind = ObstacleKind::Sphere;
    ball.point = rest[map.rows * map.cols / 2] + Vec3{0, 0, -3.25f};
    ball.radius = 3;
    ClothStep how;
    how.gravity = {0, 0, -9.75f};
    how.tool_radius = 1;
    how.obstacles = {&ball, 1};
    how.pins = {&pin, 1};
    for (int k = 0; k < 12; ++k) {
        how.cycles = k < 6 ? 1 : 3;
        ToolInput tool;
        tool.kind = ToolKind::Grasp;
        tool.position = rest[pulled] + Vec3{0.25f * static_cast<float>(k), 0, 0.125f};
        StepTool answer;
        const ClothReport r = good(step(state, cloth, how, {&tool, 1}, {&answer, 1}), "cloth");
        Digest report;
        report.add(r.kinetic, r.elastic, r.potential, r.residual, r.contacts, r.touches, r.clamped, answer.contacts);
        report.add(answer.force);
        state.update_normals();
        print(map.name + " cloth frame " + std::to_string(k + 1), state, report);
    }
}

void print_math() {
    Digest values;
    for (int k = -40000; k <= 40000; ++k) {
        const double x = k / 55.0, e = detail::portable_exp(x);
        const detail::SineCosine a = detail::portable_sine(static_cast<float>(e * x));
        values.add(e, detail::portable_log(e), detail::portable_pow(1 + x * x, 0.3 * x), a.sine, a.cosine);
    }
    std::printf("%-52s %016llx\n", "exp, log, pow, sine", values.hash());
}

int run() {
    ChartSpec sheet_chart = grid_chart(33, 37, bent_sheet);
    ChartSpec tube = grid_chart(29, 41, bent_tube(41), tube_seams(29, 41));
    ChartSpec painted = tube;
    add_mixed_diagonals(painted);
    add_paint(painted);
    ChartSpec closed = grid_chart(33, 33, ball(33), octahedral_seams(33));
    ChartSpec mixed_closed = closed;
    add_mixed_diagonals(mixed_closed);
    const Map maps[] = {{"sheet", sheet_chart},    {"tube", tube},
                        {"painted_tube", painted}, {"free", free_chart(23, 29, bent_sheet)},
                        {"ball", closed},          {"mixed_ball", mixed_closed}};
    std::printf("loops %s\n", maps[0].state().loops());
    print_math();
    for (const Map& map : maps) {
        if (few && (map.name == "tube" || map.name == "ball")) continue;  // painted_tube and mixed_ball do more
        print(map.name + " rest", map.state(), {});
        deform_all(map);
        tick_all(map);
        contact_all(map, maps[4]);
        reconstruct_all(map);
        collide_all(map);
        physics_all(map, Solver::Multigrid);
        if (!few || map.name == "mixed_ball") physics_all(map, Solver::Factors);
        cloth_all(map);
    }
    return sound ? 0 : 1;
}

}  // namespace
}  // namespace dgm::test

int main(int argc, char** argv) {
    for (int k = 1; k < argc; ++k) {
        if (std::strcmp(argv[k], "--quick") == 0) dgm::test::plain = false;
        if (std::strcmp(argv[k], "--few") == 0) dgm::test::few = true;
    }
    return dgm::test::run();
}
