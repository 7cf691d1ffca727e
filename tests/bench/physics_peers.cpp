// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/physics_peers.cpp
// dgm::physics beside others on the samples of the same map, in one process: a hand holds the top of a body and pulls.
//
//   dgm-bench-physics-peers MAP.dgm [MILLISECONDS A STEP]
//
// What is compared is the way to the converged step: how long a solver takes until a step is within 10 % or 1 % of
// where the same solver takes it by many iterations, over the way that samples go. Models differ: ours has triangles,
// bending and a kept volume; the others have springs of the same stiffness along the edges of the same triangles, and
// no bending. Bullet's times include its housekeeping of bounding volumes, without any collision.
#include <ctime>

#include "physics_peers.h"

namespace dgm::bench {
namespace {

constexpr double kHeld = 0.12;    ///< of the diagonal: radius of the part that the hand holds
constexpr double kSpeed = 0.075;  ///< m/s
constexpr int kMoment = 20;       ///< steps before the second one that is looked at
constexpr int kTimed = 30;        ///< steps whose times are taken

class Ours final : public Solver {
 public:
    Ours(const PhysicsMap& map, const Springs& s, double dt)
        : map_(map), springs_(s), state_(map.state()), physics_(make(map, state_, dt)) {
        for (std::size_t k = 0; k < s.rest.size(); ++k)
            if (s.mass[k] == 0) pins_.push_back({s.sample_of[k], {}});
    }
    void step(const Point& offset, std::uint32_t effort) override {
        const Vec3 by{float(offset[0] / map_.metres()), float(offset[1] / map_.metres()),
                      float(offset[2] / map_.metres())};
        for (Pin& p : pins_) p.position = state_.rest_positions()[p.sample] + by;
        StepOptions o;
        o.cycles = effort;
        o.pins = pins_;
        report_ = value_of(dgm::step(state_, physics_, o));
    }
    [[nodiscard]] Points points() const override {
        Points out;
        for (const std::uint32_t k : springs_.sample_of) {
            const Vec3 p = state_.positions()[k];
            out.push_back({map_.metres() * double{p.x}, map_.metres() * double{p.y}, map_.metres() * double{p.z}});
        }
        return out;
    }
    static Material material(const State& state) {
        Material m = stored_material(state).material.value_or(Material{});
        m.foundation = 0;  // the others have none
        m.viscosity = 0;
        return m;
    }

 private:
    static Physics make(const PhysicsMap& map, const State& state, double dt) {
        PhysicsOptions o;
        o.material = material(state);
        o.metres_per_unit = map.metres();
        o.dt = static_cast<float>(dt);
        return value_of(Physics::create(state, o));
    }
    const PhysicsMap& map_;
    const Springs& springs_;
    State state_;
    Physics physics_;
    std::vector<Pin> pins_;
    StepReport report_;
};
std::unique_ptr<Solver> make_ours(const PhysicsMap& map, const Springs& s, double dt) {
    return std::make_unique<Ours>(map, s, dt);
}

struct Peer {
    const char* name;
    Make make;
    std::vector<std::uint32_t> efforts;
    std::uint32_t usual;  ///< in the steps before the one that is looked at
    std::uint32_t converged;
};

double distance(const Springs& s, const Points& a, const Points& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c)
            if (s.mass[k] > 0) sum += (a[k][c] - b[k][c]) * (a[k][c] - b[k][c]);
    return std::sqrt(sum);
}

/// The hand pulls along x and up.
Point hand_at(int step, double dt) {
    const double far = kSpeed * dt * step;
    return {0.6 * far, 0, 0.8 * far};
}

/// Where the step after `before` steps of `usual` iterations leads by `effort` of them.
std::pair<Points, Points> look(const PhysicsMap& map, const Springs& s, const Peer& peer, double dt, int before,
                               std::uint32_t usual, std::uint32_t effort) {
    const std::unique_ptr<Solver> solver = peer.make(map, s, dt);
    for (int k = 1; k <= before; ++k) solver->step(hand_at(k, dt), usual);
    Points start = solver->points();
    solver->step(hand_at(before + 1, dt), effort);
    return {std::move(start), solver->points()};
}

double processor_seconds() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Lower tenth of the processor's time of a step.
double seconds_of(const PhysicsMap& map, const Springs& s, const Peer& peer, double dt, std::uint32_t effort) {
    const std::unique_ptr<Solver> solver = peer.make(map, s, dt);
    std::vector<double> times;
    const int timed = effort > 300 ? 5 : kTimed;
    for (int k = 1; k <= timed; ++k) {
        const double start = processor_seconds();
        solver->step(hand_at(k, dt), effort);
        times.push_back(processor_seconds() - start);
    }
    std::sort(times.begin(), times.end());
    return times[times.size() / 10];
}

/// Seconds at which a falling line of (seconds, error) crosses `wanted`, by its logarithms; 0: it does not.
double reached(const std::vector<std::pair<double, double>>& line, double wanted) {
    for (std::size_t k = 0; k < line.size(); ++k) {
        if (!(line[k].second <= wanted)) continue;
        if (k == 0) return line[k].first;
        const auto [t0, e0] = line[k - 1];
        const auto [t1, e1] = line[k];
        return t0 * std::pow(t1 / t0, std::log(wanted / e0) / std::log(e1 / e0));
    }
    return 0;
}

void run(const PhysicsMap& map, double dt) {
    const State state = map.state();
    const Springs s = make_springs(map, Ours::material(state), kHeld * map.diagonal() * map.metres());
    const double volume = volume_of(s, s.rest);
    std::printf("%s, steps of %g ms: %zu masses, %zu edges of %.0f N/m\n", map.file().c_str(), 1e3 * dt, s.rest.size(),
                s.edges.size(), s.stiffness);
    const std::vector<Peer> peers = {
        {"ours", make_ours, {1, 2, 3, 5, 10, 20, 40}, 20, 300},
        {"XPBD", make_xpbd, {1, 5, 20, 100, 300, 1000}, 300, 10000},
        {"XPBD, volume", make_xpbd_with_volume, {1, 5, 20, 100, 300, 1000}, 300, 10000},
        {"Bullet, implicit", make_bullet_implicit, {1, 3, 5, 10, 20, 50, 100}, 50, 1000},
        {"Bullet, 1 Newton", make_bullet_once, {1, 3, 5, 10, 20, 50, 100, 300}, 150, 3000},
        {"Bullet, links", make_bullet_links, {1, 5, 10, 50, 300, 1000}, 300, 10000},
    };
    std::printf("%-18s %10s %12s %12s %12s %12s %14s\n", "solver", "iterations", "us a step", "error, 1st",
                "error, 21st", "volume", "ns/edge/iter.");
    double ours[2] = {};
    for (const Peer& peer : peers) {
        const std::uint32_t usual = peer.usual;
        std::vector<std::pair<double, double>> line;
        std::pair<Points, Points> wanted[2];
        for (int m = 0; m < 2; ++m) wanted[m] = look(map, s, peer, dt, m * kMoment, usual, peer.converged);
        for (const std::uint32_t effort : peer.efforts) {
            double error[2] = {}, swollen = 0;
            for (int m = 0; m < 2; ++m) {
                const auto [start, end] = look(map, s, peer, dt, m * kMoment, usual, effort);
                error[m] = distance(s, end, wanted[m].second) / distance(s, wanted[m].second, wanted[m].first);
                swollen = std::max(swollen, std::fabs(volume_of(s, end) / volume - 1));
            }
            const double seconds = seconds_of(map, s, peer, dt, effort);
            line.emplace_back(seconds, std::max(error[0], error[1]));
            std::printf("%-18s %10u %12.1f %12.2e %12.2e %12.1e %14.2f\n", peer.name, effort, 1e6 * seconds, error[0],
                        error[1], swollen, 1e9 * seconds / effort / static_cast<double>(s.edges.size()));
        }
        const double wished[2] = {0.1, 0.01};
        std::printf("%-18s", peer.name);
        for (int w = 0; w < 2; ++w) {
            const double time = reached(line, wished[w]);
            if (&peer == &peers.front()) ours[w] = time;
            std::printf("  within %g %%: ", 100 * wished[w]);
            if (time == 0)
                std::printf("not by %u iterations", peer.efforts.back());
            else
                std::printf("%.0f us", 1e6 * time);
            const double least = time > 0 ? time : line.back().first;
            if (ours[w] > 0 && &peer != &peers.front())
                std::printf(" (%s%.1f x ours)", time > 0 ? "" : "more than ", least / ours[w]);
        }
        std::printf("\n");
    }
}
}  // namespace
}  // namespace dgm::bench

int main(int argc, char** argv) {
    if (argc < 2 || argc > 3) {
        std::fprintf(stderr, "usage: dgm-bench-physics-peers MAP.dgm [MILLISECONDS]\n");
        return 1;
    }
    const double milliseconds = argc > 2 ? std::atof(argv[2]) : 1;
    if (!(milliseconds >= 0.1 && milliseconds <= 100)) dgm::bench::give_up("steps take 0.1 .. 100 ms");
    dgm::bench::run(dgm::bench::PhysicsMap(argv[1]), milliseconds / 1000);
    return 0;
}
