// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/haptic_bench.cpp
// A hand holds a simulated device against a body, and every part of the loop is in it: the device's mass and friction,
// a position that is quantised and sampled at 1 kHz, a force that is held between samples, and physics in the tick or
// slower. The body is made stiffer and stiffer until the device swings by itself (more than 8 steps of the encoder), or
// the passivity observer [Hannaford, Ryu 2002], which sums up the energy that the body has got, says that it has given
// more than it got (more than 1 % of the most that it had).
//
//   dgm-bench-haptic MAP.dgm...
//   dgm-bench-haptic --path PATH.txt MAP.dgm...     the tool of a recorded path (docs/touch.md), whatever the force
//
// Time is simulated: what is slow on this machine is not slow in the loop. A frame of physics that begins at a sample
// is seen a whole frame later.
#include <dgm/compliance.h>
#include <dgm/encoder.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "path/tool_path.h"
#include "physics_map.h"

namespace dgm::bench {
namespace {

// The device is about that of a Phantom: [Massie, Salisbury 1994], [Diolaiti, Niemeyer, Barbagli, Salisbury 2006].
constexpr double kTick = 1e-3, kMass = 0.08, kFriction = 0.3, kQuantum = 30e-6;
constexpr double kHandSpring = 300, kHandDamper = 2;                           // N/m, N s/m
constexpr int kParts = 50;                                                     // of a tick in which the device moves
constexpr double kDepth = 0.010, kGap = 0.003;                                 // metres that the hand wants
constexpr double kIn = 0.3, kHeld = 0.9, kSlid = 1.2, kOut = 1.4, kEnd = 1.6;  // seconds

struct D3 {
    double v[3] = {};
};

/// How the loop gets its forces.
struct Mode {
    const char* name;
    int ticks;  ///< of a step of physics
    bool compliance;
    float damper;     ///< N s/m
    float layer = 0;  ///< N/m^3, under the ball
    bool tracked = false;
    double quantum = kQuantum;  ///< of the encoder; 0: exact places
};
constexpr Mode kModes[] = {{"physics in the tick", 1, false, 0},
                           {"layer", 1, false, 0, 2e6F},
                           {"layer, tracked", 1, false, 0, 2e6F, true},
                           {"tracked", 1, false, 0, 0, true},
                           {"exact places", 1, false, 0, 0, false, 0},
                           {"layer, exact places", 1, false, 0, 2e6F, false, 0},
                           {"compliance, 200 Hz", 5, true, 0},
                           {"compliance, 100 Hz", 10, true, 0},
                           {"damped, 200 Hz", 5, true, 4},
                           {"damped, 100 Hz", 10, true, 4},
                           {"force held, 100 Hz", 10, false, 0}};

/// How the loop went.
struct Outcome {
    double swing = 0;    ///< metres from peak to peak in the last 0.3 s of the hold
    double ripple = 0;   ///< N, the same of the force
    double lowest = 0;   ///< J, of the observer
    double stored = 0;   ///< J, most that the observer saw
    double jump = 0;     ///< largest change of the force in a tick, over the largest force
    double force = 0;    ///< N, at the end of the hold
    double depth = 0;    ///< metres, there
    double slowest = 0;  ///< seconds of a tick of the haptic side alone
    double usual = 0;    ///< the same, at the median
    [[nodiscard]] bool quiet() const { return swing <= 8 * kQuantum; }
    [[nodiscard]] bool passive() const { return lowest >= -0.01 * stored; }
    [[nodiscard]] double stiffness() const { return depth > 0 ? force / depth : 0; }
};

/// The body with a ball, and what the haptic loop sees of it.
class Body {
 public:
    Body(const PhysicsMap& map, Mode mode, double stiffer) : map_(map), mode_(mode), state_(map.state()) {
        PhysicsOptions o;
        Material m = stored_material(state_).material.value_or(Material{});
        for (float* modulus : {&m.membrane, &m.bending, &m.foundation}) *modulus *= static_cast<float>(stiffer);
        m.viscosity = 2e-3F;
        o.material = m;
        o.metres_per_unit = map.metres();
        o.dt = static_cast<float>(kTick * mode.ticks);
        physics_.emplace(value_of(Physics::create(state_, o)));
        how_.cycles = 5;
        how_.tool_radius = static_cast<float>(0.1 * map.diagonal());
        how_.tool_layer = mode.layer;
        if (!mode.compliance) return;
        compliance_.emplace(value_of(Compliance::create(state_, *physics_)));
        ReaderOptions reading;
        reading.fade = static_cast<std::uint32_t>(mode.ticks);
        reading.damper = mode.damper;
        reader_.emplace(value_of(ComplianceReader::create(*compliance_, reading)));
    }
    [[nodiscard]] Vec3 at(const D3& way) const {  // the ball touches where way is 0
        const Vec3 top = state_.rest_positions()[map_.top()];
        const double by = 1 / map_.metres();
        return {static_cast<float>(double{top.x} + by * way.v[0]), static_cast<float>(double{top.y} + by * way.v[1]),
                static_cast<float>(double{top.z} + double{how_.tool_radius} + by * way.v[2])};
    }
    /// Force on a tool at `place`, local units, in a tick of physics; of one that is away, 0.
    Vec3 force_at(Vec3 place, bool engaged) {
        begun_ = place;
        if (engaged) {
            run_frame();
            return felt_.force;
        }
        (void)value_of(step(state_, *physics_, how_, {}, {}));
        return {};
    }
    /// Force on the device in tick number `tick`, at the place that its encoders tell.
    Vec3 tick(int tick, const D3& seen, double& seconds) {
        ToolInput tool;
        if (mode_.ticks > 1 && tick % mode_.ticks == 0 && tick > 0) run_frame();
        if (tick % mode_.ticks == 0) begun_ = at(seen);
        tool.position = at(seen);
        if (mode_.ticks == 1) run_frame();
        if (!reader_) return felt_.force;
        ComplianceAnswer answer;
        const auto start = std::chrono::steady_clock::now();
        if (!compliance_tick(*reader_, {&tool, 1}, {&answer, 1})) give_up("compliance_tick");
        seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return answer.force;
    }

 private:
    /// Physics of the frame that began at `begun_`.
    void run_frame() {
        ToolInput tool;
        tool.position = begun_;
        (void)value_of(step(state_, *physics_, how_, {&tool, 1}, {&felt_, 1}));
        if (compliance_) (void)value_of(compliance_->publish(state_, *physics_, how_, {&tool, 1}));
    }
    const PhysicsMap& map_;
    Mode mode_;
    State state_;
    std::optional<Physics> physics_;
    std::optional<Compliance> compliance_;
    std::optional<ComplianceReader> reader_;
    StepOptions how_;
    StepTool felt_;
    Vec3 begun_;
};

/// Where the hand wants to be: in, hold, along, out.
D3 wanted_at(double t) {
    const auto share = [&](double from, double to) { return std::clamp((t - from) / (to - from), 0.0, 1.0); };
    return {{0.01 * share(kHeld, kSlid), 0, kGap - (kGap + kDepth) * (share(0, kIn) - share(kSlid, kOut))}};
}

/// What the encoder says.
D3 read(D3 place, const Mode& mode) {
    for (double& x : place.v) x = mode.quantum > 0 ? mode.quantum * std::floor(x / mode.quantum + 0.5) : x;
    return place;
}
Vec3 narrow(const D3& a) {
    return {static_cast<float>(a.v[0]), static_cast<float>(a.v[1]), static_cast<float>(a.v[2])};
}
D3 wide(Vec3 a) {
    return {{double{a.x}, double{a.y}, double{a.z}}};
}

Outcome run_loop(const PhysicsMap& map, Mode mode, double stiffer) {
    Body body(map, mode, stiffer);
    EncoderTrack track(static_cast<float>(mode.quantum));
    Outcome out;
    D3 place = wanted_at(0), speed;
    double low = 1, high = -1, weakest = 1e9, strongest = 0, energy = 0, most = 0, change = 0;
    Vec3 before;
    std::vector<double> times;
    for (int k = 0; k * kTick < kEnd; ++k) {
        const double now = k * kTick;
        D3 seen = read(place, mode);
        if (mode.tracked) seen = wide(track.follow(narrow(seen)));
        double seconds = 0;
        const Vec3 force = body.tick(k, seen, seconds);
        times.push_back(seconds);
        const double f[3] = {force.x, force.y, force.z};
        const D3 start = place;
        for (int part = 0; part < kParts; ++part) {
            const double h = kTick / kParts, t = now + part * h;
            const D3 hand = wanted_at(t), next = wanted_at(t + h);
            for (int c = 0; c < 3; ++c) {
                const double pull =
                    kHandSpring * (hand.v[c] - place.v[c]) + kHandDamper * ((next.v[c] - hand.v[c]) / h - speed.v[c]);
                speed.v[c] += h / kMass * (f[c] + pull - kFriction * speed.v[c]);
                place.v[c] += h * speed.v[c];
            }
        }
        for (int c = 0; c < 3; ++c) energy -= f[c] * (place.v[c] - start.v[c]);
        out.lowest = std::min(out.lowest, energy);
        out.stored = std::max(out.stored, energy);
        most = std::max(most, length(force));
        change = std::max(change, length(force - before));
        before = force;
        if (now > kHeld - 0.3 && now < kHeld) {
            low = std::min(low, place.v[2]);
            high = std::max(high, place.v[2]);
            weakest = std::min(weakest, length(force));
            strongest = std::max(strongest, length(force));
            out.force = length(force);
            out.depth = -place.v[2];
        }
    }
    out.swing = high - low;
    out.ripple = strongest - weakest;
    out.jump = most > 0 ? change / most : 0;
    std::sort(times.begin(), times.end());
    out.usual = times[times.size() / 2];
    out.slowest = times[times.size() * 99 / 100];
    return out;
}

/// The largest change of the force in a tick over the largest force, of a tool that follows a path.
void run_path(const PhysicsMap& map, const formats::ToolPath& path) {
    std::printf("%s\n%-20s %9s %9s %9s %9s\n", map.file().c_str(), "loop", "force, N", "jump, %", "99th, %", "m/s");
    for (const Mode& mode : kModes) {
        if (mode.compliance || mode.ticks != 1) continue;
        Body body(map, mode, 1);
        EncoderTrack track(static_cast<float>(mode.quantum));
        Vec3 before, last;
        double most = 0, fastest = 0;
        std::vector<double> changes;
        path.replay(
            kTick,
            [&](std::span<const formats::Knot> knots, float) {
                const D3 units = wide(knots[0].position);
                D3 metres;
                for (int c = 0; c < 3; ++c) metres.v[c] = units.v[c] * map.metres();
                metres = read(metres, mode);
                if (mode.tracked) metres = wide(track.follow(narrow(metres)));
                for (double& x : metres.v) x /= map.metres();
                const Vec3 force = body.force_at(narrow(metres), knots[0].engaged);
                if (!changes.empty())
                    fastest = std::max(fastest, length(knots[0].position - last) * map.metres() / kTick);
                last = knots[0].position;
                most = std::max(most, length(force));
                changes.push_back(length(force - before));
                before = force;
            },
            [](const std::string&) {});
        std::sort(changes.begin(), changes.end());
        const double share = most > 0 ? 100 / most : 0;
        std::printf("%-20s %9.3f %9.2f %9.2f %9.2f\n", mode.name, most, share * changes.back(),
                    share * changes[changes.size() * 99 / 100], fastest);
    }
}

void run_map(const PhysicsMap& map) {
    const State s = map.state();
    std::printf("%s, %u x %u samples\n", map.file().c_str(), s.rows(), s.cols());
    std::printf("%-20s %8s %10s %9s %9s %9s %10s %8s %9s\n", "loop", "stiffer", "stiffness", "swing", "ripple",
                "energy", "lowest", "jump", "tick p99");
    std::printf("%-20s %8s %10s %9s %9s %9s %10s %8s %9s\n", "", "times", "N/m", "mm", "N", "mJ", "mJ", "%", "us");
    for (const Mode& mode : kModes) {
        double quiet = 0, passive = 0;
        bool is_quiet = true, is_passive = true;
        for (double stiffer = 1; stiffer <= 4096 && (is_quiet || is_passive); stiffer *= 2) {
            const Outcome o = run_loop(map, mode, stiffer);
            is_quiet = is_quiet && o.quiet();
            is_passive = is_passive && o.passive();
            if (is_quiet) quiet = o.stiffness();
            if (is_passive) passive = o.stiffness();
            std::printf("%-20s %8g %10.0f %9.4f %9.4f %9.4f %10.5f %8.2f %9.1f%s%s\n", mode.name, stiffer,
                        o.stiffness(), 1e3 * o.swing, o.ripple, 1e3 * o.stored, 1e3 * o.lowest, 100 * o.jump,
                        1e6 * o.slowest, o.quiet() ? "" : " swings", o.passive() ? "" : " active");
        }
        std::printf("%-20s quiet up to %.0f N/m at the ball, passive up to %.0f\n", mode.name, quiet, passive);
    }
}
}  // namespace
}  // namespace dgm::bench

int main(int argc, char** argv) {
    const bool follows = argc > 3 && std::string(argv[1]) == "--path";
    if (argc < 2 || (argv[1][0] == '-' && !follows)) {
        std::fprintf(stderr, "usage: dgm-bench-haptic [--path PATH.txt] MAP.dgm...\n");
        return 1;
    }
    if (follows) {
        const dgm::formats::ToolPath path{std::filesystem::path(argv[2])};
        for (int k = 3; k < argc; ++k) dgm::bench::run_path(dgm::bench::PhysicsMap(argv[k]), path);
        return 0;
    }
    std::printf("Device %g kg, friction %g N s/m, encoder %g um, 1 kHz; hand %g N/m and %g N s/m.\n", dgm::bench::kMass,
                dgm::bench::kFriction, 1e6 * dgm::bench::kQuantum, dgm::bench::kHandSpring, dgm::bench::kHandDamper);
    std::printf("A spring alone is passive below 2 b / T = %.0f N/m by the device's friction, %.0f with the hand's.\n",
                2 * dgm::bench::kFriction / dgm::bench::kTick,
                2 * (dgm::bench::kFriction + dgm::bench::kHandDamper) / dgm::bench::kTick);
    for (int k = 1; k < argc; ++k) dgm::bench::run_map(dgm::bench::PhysicsMap(argv[k]));
    return 0;
}
