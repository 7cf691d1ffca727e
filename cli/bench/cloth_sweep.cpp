// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/cloth_sweep.cpp
#include "bench/cloth_sweep.h"

#include <dgm/cloth.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "bench/interrupt.h"
#include "bench/machine_facts.h"
#include "bench/run_sweep.h"
#include "bench/runtime_error.h"
#include "files/output_file.h"
#include "files/temporary_folder.h"

namespace dgm::bench {
namespace {

constexpr double kGravity = 9.81, kDensity = 0.2;

/// A flat square of 1 m, 8 x 8 quads.
std::string sheet_mesh() {
    constexpr int kQuads = 8;
    std::string out;
    for (int i = 0; i <= kQuads; ++i)
        for (int j = 0; j <= kQuads; ++j) out += fmt::format("v {} {} 0\n", j / double(kQuads), i / double(kQuads));
    for (int i = 0; i < kQuads; ++i)
        for (int j = 0; j < kQuads; ++j) {
            const int a = i * (kQuads + 1) + j + 1, b = a + kQuads + 1;
            out += fmt::format("f {} {} {} {}\n", a, a + 1, b + 1, b);
        }
    return out;
}

/// A ball of 0.3 m around the origin.
std::string ball_mesh() {
    constexpr int kRings = 32, kSides = 64;
    constexpr double kRadius = 0.3;
    std::string out = fmt::format("v 0 0 {}\nv 0 0 {}\n", kRadius, -kRadius);
    for (int i = 1; i < kRings; ++i)
        for (int j = 0; j < kSides; ++j) {
            const double polar = M_PI * i / kRings, around = 2 * M_PI * j / kSides;
            out += fmt::format("v {} {} {}\n", kRadius * std::sin(polar) * std::cos(around),
                               kRadius * std::sin(polar) * std::sin(around), kRadius * std::cos(polar));
        }
    const auto at = [](int i, int j) { return 3 + (i - 1) * kSides + j % kSides; };
    for (int j = 0; j < kSides; ++j) {
        out += fmt::format("f 1 {} {}\nf 2 {} {}\n", at(1, j), at(1, j + 1), at(kRings - 1, j + 1), at(kRings - 1, j));
        for (int i = 1; i + 1 < kRings; ++i)
            out += fmt::format("f {} {} {} {}\n", at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
    return out;
}

struct Setting {
    std::uint32_t substeps, cycles, levels;
};

ClothStep step_of(const Setting& setting) {
    ClothStep how;
    how.substeps = setting.substeps;
    how.cycles = setting.cycles;
    how.levels = setting.levels;
    return how;
}

Vec3 mean_of(const PointView& samples, std::size_t first, std::size_t count) {
    double sum[3] = {};
    for (std::size_t k = first; k < first + count; ++k) {
        sum[0] += double{samples[k].x};
        sum[1] += double{samples[k].y};
        sum[2] += double{samples[k].z};
    }
    const double by = 1 / static_cast<double>(count);
    return {static_cast<float>(by * sum[0]), static_cast<float>(by * sum[1]), static_cast<float>(by * sum[2])};
}

/// The sheet, held by its first row; gravity leads to the last one.
class Hung {
 public:
    Hung(const Subject& subject, const ClothSweepOptions& options, const Setting& setting)
        : state_(subject.state()), cloth_(take(Cloth::create(state_, made_of(options)))), how_(step_of(setting)) {
        const Vec3 way = mean_of_row(state_.rows() - 1) - mean_of_row(0);
        length_ = std::sqrt(double{dot(way, way)});
        down_ = static_cast<float>(1 / length_) * way;
        for (std::uint32_t k = 0; k < state_.cols(); ++k) pins_.push_back({k, state_.rest_positions()[k]});
        how_.gravity = static_cast<float>(kGravity) * down_;
        how_.pins = pins_;
    }
    ClothReport go() { return take(step(state_, cloth_, how_)); }
    /// Over its length.
    [[nodiscard]] double stretch() const {
        return double{dot(mean_of_row(state_.rows() - 1) - mean_of_row(0), down_)} / length_ - 1;
    }
    [[nodiscard]] double length() const { return length_; }

 private:
    static ClothOptions made_of(const ClothSweepOptions& options) {
        ClothOptions o;
        const auto modulus = static_cast<float>(options.modulus);
        o.fabric = {.warp = modulus, .weft = modulus, .shear = 0.2F * modulus, .density = static_cast<float>(kDensity)};
        o.metres_per_unit = 1;
        return o;
    }
    [[nodiscard]] Vec3 mean_of_row(std::uint32_t i) const {
        return mean_of(state_.positions(), std::size_t{i} * state_.cols(), state_.cols());
    }
    State state_;
    Cloth cloth_;
    std::vector<Pin> pins_;
    ClothStep how_;
    Vec3 down_;
    double length_ = 0;
};

/// What a sheet falls on; on all but a plane there is one below it.
struct Below {
    const char* name;
    ObstacleKind kind;
    bool itself = false;  ///< the sheet meets itself, too
    bool goes = false;    ///< to and fro
};
constexpr Below kBelow[] = {{"plane", ObstacleKind::Plane},
                            {"sphere", ObstacleKind::Sphere},
                            {"surface", ObstacleKind::Surface},
                            {"surface that goes", ObstacleKind::Surface, false, true},
                            {"surface, itself", ObstacleKind::Surface, true}};

/// A sheet of cotton, 2 mm thick, that falls on a thing of 0.3 m and the floor below it.
class Draped {
 public:
    Draped(const Subject& subject, State& ball, const Below& below, const Setting& setting)
        : state_(subject.state()),
          cloth_(take(Cloth::create(state_, cotton(below.itself)))),
          goes_(below.goes),
          how_(step_of(setting)) {
        constexpr float kRadius = 0.3F, kAbove = 0.01F;
        const bool plane = below.kind == ObstacleKind::Plane;
        const Vec3 top = mean_of(state_.positions(), 0, state_.positions().count) - Vec3{0, 0, kAbove};
        things_.resize(plane ? 1 : 2);
        things_.front().point = plane ? top : top - Vec3{0, 0, 2 * kRadius};
        if (!plane) {
            Obstacle& thing = things_.back();
            thing.kind = below.kind;
            thing.point = top - Vec3{0, 0, kRadius};
            thing.radius = kRadius;
            thing.surface = &ball;
        }
        how_.gravity = {0, 0, static_cast<float>(-kGravity)};
        how_.obstacles = things_;
    }
    ClothReport go() {
        constexpr float kWay = 2e-3F;  // metres a frame
        constexpr int kFrames = 20;    // in either direction
        if (goes_) things_.back().point.x += frame_++ / kFrames % 2 == 0 ? kWay : -kWay;
        return take(step(state_, cloth_, how_));
    }

 private:
    static ClothOptions cotton(bool self_contact) {
        ClothOptions o;
        o.fabric = {.warp = 800,
                    .weft = 800,
                    .shear = 160,
                    .bending = 4e-5F,
                    .density = static_cast<float>(kDensity),
                    .damping = 0.5F};
        o.thickness = 2e-3F;
        o.metres_per_unit = 1;
        o.self_contact = self_contact;
        return o;
    }
    State state_;
    Cloth cloth_;
    std::vector<Obstacle> things_;
    bool goes_;
    int frame_ = 0;
    ClothStep how_;
};

Table drape_table() {
    Table t;
    t.key = "drape";
    t.title = "A sheet that falls on things";
    t.note =
        "Frames of 1/60 s of a sheet of cotton, 2 mm thick, that falls on a plane, or on a ball of 0.3 m and a plane: "
        "a sphere, the same as a map of 129 x 129 samples, which stays or goes to and fro at 0.12 m/s, and with "
        "contact of the sheet with itself. All levels. Samples that bear and places kept apart are those of the last "
        "frame.";
    t.columns = subject_columns({key_column("below", "on"), key_column("substeps", "substeps"),
                                 key_column("cycles", "cycles"), time_column("p50_us", "p50", "us"),
                                 time_column("p99_us", "p99", "us"), time_column("p999_us", "p99.9", "us"),
                                 exact_column("contacts", "bear", "", Sense::kNone, 1e-3),
                                 exact_column("touches", "kept apart", "", Sense::kNone, 1e-3)});
    return t;
}

/// Of a table of both kinds, what they have in common.
SubjectRow row_of(const Table& table, const Subject& subject, const Setting& setting, const TickTimes& times) {
    SubjectRow row(table, subject);
    row.set("substeps", std::to_string(setting.substeps));
    row.set("cycles", std::to_string(setting.cycles));
    row.set_percentiles(times);
    return row;
}

void add_drape_row(Run& run, const Subject& subject, State& ball, const Below& below, const Setting& setting,
                   std::size_t frames) {
    Table& table = run.tables.back();
    Draped sheet(subject, ball, below, setting);
    ClothReport last;
    const TickTimes times = time_ticks(
        0, frames, [](std::size_t) {}, [&](std::size_t) { last = sheet.go(); });
    SubjectRow row = row_of(table, subject, setting, times);
    row.set("below", below.name);
    row.set("contacts", exactly(last.contacts));
    row.set("touches", exactly(last.touches));
    table.rows.push_back(row.row());
    run.findings.push_back(fmt::format("{}, on {}, {} substeps, {} cycles: p50 {} us a frame, {} samples bear",
                                       subject.grid, below.name, setting.substeps, setting.cycles,
                                       three_digits(times.median.value), last.contacts));
}

Table frame_table() {
    Table t;
    t.key = "cloth";
    t.title = "A hanging sheet";
    t.note =
        "Frames of 1/60 s of a sheet that is let go where it is free of stress, held by its first row. Stretch at the "
        "end, over the "
        "length; exactly it is density gravity length / (2 modulus). Energy rise: the largest in a frame, of kinetic, "
        "elastic and potential energy, over the weight times a millimetre.";
    t.columns = subject_columns({key_column("substeps", "substeps"), key_column("cycles", "cycles"),
                                 key_column("levels", "levels"), time_column("p50_us", "p50", "us"),
                                 time_column("p99_us", "p99", "us"), time_column("p999_us", "p99.9", "us"),
                                 exact_column("stretch_percent", "stretch", "%", Sense::kNone, 1e-3),
                                 exact_column("exact_percent", "exact", "%", Sense::kNone, 1e-3),
                                 exact_column("off_percent", "off by", "%", Sense::kLower, 1e-2),
                                 exact_column("energy_rise", "energy rise", "", Sense::kLower, 1e-2)});
    t.plots = {{"Error against time", "p50_us", "off_percent", "grid", "asset", true}};
    return t;
}

void add_row(Run& run, const Subject& subject, const ClothSweepOptions& options, const Setting& setting) {
    Table& table = run.tables.front();
    Hung sheet(subject, options, setting);
    double energy = 0, rise = 0;
    bool any = false;
    const TickTimes times = time_ticks(
        0, options.frames, [](std::size_t) {},
        [&](std::size_t) {
            const ClothReport r = sheet.go();
            const double now = r.kinetic + r.elastic + r.potential;
            if (any) rise = std::max(rise, now - energy);
            any = true;
            energy = now;
        });
    const double exact = kDensity * kGravity * sheet.length() / (2 * options.modulus), stretch = sheet.stretch();
    SubjectRow row = row_of(table, subject, setting, times);
    row.set("levels", setting.levels == 0 ? std::string("all") : std::to_string(setting.levels));
    row.set("stretch_percent", exactly(100 * stretch));
    row.set("exact_percent", exactly(100 * exact));
    row.set("off_percent", exactly(100 * std::fabs(stretch - exact)));
    row.set("energy_rise", exactly(rise / (kDensity * kGravity * 1e-3)));
    table.rows.push_back(row.row());
    run.findings.push_back(fmt::format(
        "{}, {} substeps, {} cycles, {} levels: p50 {} us a frame, stretch {:.4f} %, exactly {:.4f} %", subject.grid,
        setting.substeps, setting.cycles, setting.levels == 0 ? "all" : std::to_string(setting.levels),
        three_digits(times.median.value), 100 * stretch, 100 * exact));
}
}  // namespace

Run sweep_cloth(const ClothSweepOptions& options, bool quiet) {
    Run run;
    run.command = "cloth";
    run.machine = machine_facts();
    run.tables = {frame_table(), drape_table()};
    const formats::TemporaryFolder folder("dgm-bench");
    const std::filesystem::path mesh = folder.path() / "sheet.obj", ball_path = folder.path() / "ball.obj";
    formats::write_output(mesh, sheet_mesh());
    formats::write_output(ball_path, ball_mesh());
    ProgressBar bar(quiet, 1 + static_cast<double>(options.sizes.size()));
    const auto each_setting = [&](const auto& use) {
        for (const std::uint32_t substeps : options.substeps)
            for (const std::uint32_t cycles : options.cycles) {
                stop_if_interrupted();
                use(substeps, cycles);
            }
    };
    each_subject({ball_path}, {129}, folder.path(), options.time_limit_seconds, bar, [&](const Subject& thing) {
        State ball = thing.state();
        each_subject({mesh}, options.sizes, folder.path(), options.time_limit_seconds, bar, [&](const Subject& sheet) {
            for (const std::uint32_t levels : options.levels)
                each_setting([&](std::uint32_t substeps, std::uint32_t cycles) {
                    add_row(run, sheet, options, {substeps, cycles, levels});
                });
            for (const Below& below : kBelow)
                each_setting([&](std::uint32_t substeps, std::uint32_t cycles) {
                    add_drape_row(run, sheet, ball, below, {substeps, cycles, 0}, options.frames);
                });
        });
    });
    run.settings = {{"sizes", fmt::format("{}", fmt::join(options.sizes, ", "))},
                    {"substeps", fmt::format("{}", fmt::join(options.substeps, ", "))},
                    {"cycles", fmt::format("{}", fmt::join(options.cycles, ", "))},
                    {"levels", fmt::format("{}; 0: all", fmt::join(options.levels, ", "))},
                    {"frames", std::to_string(options.frames)},
                    {"modulus", fmt::format("{:g} N/m, shear a fifth of it", options.modulus)},
                    {"sheet", "1 m, 0.2 kg; it hangs, then it falls as cotton of 800 N/m"},
                    {"spread", "95 % interval for another run's median (Student's t on logarithms, at least 2 %)"}};
    return run;
}

}  // namespace dgm::bench
