// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/run_ticks.cpp
// Whole haptic ticks: footprint, reach, end of the kernel, rule of the force, path of the tool.
//
// Exact references, worked out outside the clock: weights exp(-s^2 / sigma) with s the exact geodesic distance in mean
// grid steps; the kernel's own formula by exp in double precision; the nearest sample by looking at all of them.
#include <dgm/tick.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>

#include "bench/run_sweep.h"
#include "bench/runtime_error.h"
#include "bench/welded_surface.h"
#include "geometry/cgal/exact_geodesics.h"

namespace dgm::bench {
namespace {

constexpr std::uint32_t kPaperReach = 11;
constexpr std::uint32_t kReaches[] = {6, 21, 33};  ///< beside the paper's
constexpr std::uint32_t kReferenceReach = 21;      ///< beyond it exact geodesics take longer than all the ticks
constexpr float kPaperSigma = 16;  ///< at reach 11 the step at the rim is exp(-121/16), 5e-4 of the dent
constexpr std::size_t kWarmUp = 500, kContacts = 12, kCheckEvery = 997;

struct Setting {
    std::string name;
    Footprint footprint = Footprint::Surface;
    std::uint32_t reach = kPaperReach;
    KernelEnd end = KernelEnd::Printed;
    ContactRule rule = ContactRule::Smooth;
    Path path = Path::kStroke;

    [[nodiscard]] KernelOptions kernel() const {
        KernelOptions out;
        out.reach = reach;
        const float scale = static_cast<float>(reach) / kPaperReach;
        out.sigma = kPaperSigma * scale * scale;
        out.end = end;
        return out;
    }
};

const char* name_of(Footprint f) {
    return f == Footprint::Grid ? "grid" : f == Footprint::Geodesic ? "geodesic" : "surface";
}

/// The paper's setting, then one change at a time.
std::vector<Setting> settings_for(bool paper_grid) {
    std::vector<Setting> out;
    Setting paper{paper_grid ? "paper" : "paper's, finer grid"};
    paper.rule = ContactRule::Printed;
    paper.footprint = Footprint::Grid;
    out.push_back(paper);
    const Setting smooth{"smooth force"};
    out.push_back(smooth);
    const auto with = [&](const char* name, auto change) {
        Setting s = smooth;
        s.name = name;
        change(s);
        out.push_back(s);
    };
    with("compact end", [](Setting& s) { s.end = KernelEnd::Compact; });
    with("grid, compact end", [](Setting& s) {
        s.footprint = Footprint::Grid;
        s.end = KernelEnd::Compact;
    });
    with("geodesic", [](Setting& s) {
        s.footprint = Footprint::Geodesic;
        s.end = KernelEnd::Compact;
    });
    for (const std::uint32_t reach : kReaches)
        with(reach < kPaperReach ? "smaller reach" : "larger reach", [&](Setting& s) { s.reach = reach; });
    with("random path", [](Setting& s) { s.path = Path::kRandom; });
    with("random path, geodesic", [](Setting& s) {
        s.path = Path::kRandom;
        s.footprint = Footprint::Geodesic;
        s.end = KernelEnd::Compact;
    });
    with("recorded path", [](Setting& s) { s.path = Path::kRecorded; });
    return out;
}

/// Largest distance of the table in use from exp(-r^2 / sigma) in double precision, over the part that a tick reads.
double table_error(const DeformTable& table, const Setting& s) {
    const double sigma = s.kernel().sigma;
    const auto reach = static_cast<int>(s.reach);
    double worst = 0;
    if (s.footprint == Footprint::Grid) {
        for (int i = 1 - reach; i < reach; ++i)
            for (int j = 1 - reach; j < reach; ++j)
                worst = std::max(worst, std::fabs(table.weight(static_cast<float>(i), static_cast<float>(j)) -
                                                  std::exp(-(double(i) * i + double(j) * j) / sigma)));
        return worst;
    }
    constexpr int kParts = 4096;
    for (int k = 0; k < kParts; ++k) {
        const auto r = static_cast<float>(static_cast<double>(reach) * k / kParts);
        worst = std::max(worst, std::fabs(table.profile(r) - std::exp(-double(r) * r / sigma)));
    }
    return worst;
}

/// Largest differences as shares of the dent's depth: of contacts within the reach of a seam or border of the grid, and
/// of the others. A mean alone hides the errors that tear a surface at its seams.
struct WeightError {
    double rms = 0;  ///< over samples the dent or the exact one moves, all contacts
    double inside = 0, border = 0;
};

/// Dents at contacts of both kinds, against the kernel over exact geodesics.
class GeodesicReference {
 public:
    explicit GeodesicReference(const State& state)
        : mesh_(surface_of(state, 1, true)), step_(state.mean_step()), grid_(state.rows() * state.cols()) {
        std::mt19937 random(7);
        for (int tries = 0; contacts_.size() < kContacts && tries < 10000; ++tries) {
            auto s = static_cast<std::uint32_t>(random() % state.sample_count());
            // Every other one within three steps of the border.
            if (contacts_.size() % 2 == 0 && s < grid_) s = s % state.cols() + random() % 4 * state.cols();
            if (!state.on_surface(s)) continue;
            contacts_.push_back(s);
            distances_.push_back(bake::exact_geodesics(mesh_.positions, mesh_.faces, representative(state, s),
                                                       1.25 * kReferenceReach * step_));
        }
    }
    WeightError of(State& state, const DeformTable& table, const Setting& setting) {
        double squares = 0, count = 0;
        WeightError out;
        for (std::size_t c = 0; c < contacts_.size(); ++c) {
            state.reset();
            Touch touch;
            touch.sample = contacts_[c];
            touch.d_max = 1e3f * static_cast<float>(step_);  // large beside the coordinates' rounding
            touch.displacement = {0, 0, touch.d_max};
            touch.footprint = setting.footprint;
            (void)take(deform(state, table, touch));
            double& worst = beside_border(state, contacts_[c], setting.reach) ? out.border : out.inside;
            for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
                if (!state.on_surface(k)) continue;
                const double s = distances_[c][representative(state, k)] / step_;
                if (std::fabs(s - setting.reach) < 0.3) continue;  // a kernel as printed has its step there
                const double exact = s < setting.reach ? double{table.profile(static_cast<float>(s))} : 0;
                const double got = (state.positions()[k].z - state.rest_positions()[k].z) / touch.d_max;
                if (exact < 1e-4 && got < 1e-4) continue;
                squares += (got - exact) * (got - exact);
                count += 1;
                worst = std::max(worst, std::fabs(got - exact));
            }
        }
        state.reset();
        out.rms = std::sqrt(squares / std::max(count, 1.0));
        return out;
    }

 private:
    [[nodiscard]] bool beside_border(const State& state, std::uint32_t s, std::uint32_t reach) const {
        if (s >= grid_) return true;
        const std::uint32_t i = s / state.cols(), j = s % state.cols();
        return i < reach || j < reach || i + reach >= state.rows() || j + reach >= state.cols();
    }

    model::TriMesh mesh_;
    double step_;
    std::uint32_t grid_;
    std::vector<std::uint32_t> contacts_;
    std::vector<std::vector<double>> distances_;  ///< of each contact
};

std::uint32_t nearest_of_all(const PointView& points, const State& state, Vec3 tool) {
    std::uint32_t best = kNone;
    float least = 0;
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
        const Vec3 d = points[k] - tool;
        if (state.on_surface(k) && (best == kNone || dot(d, d) < least)) {
            best = k;
            least = dot(d, d);
        }
    }
    return best;
}

struct TickOutcome {
    TickTimes times;
    double force_jump = 0, hits = 0, lost = 0, wrong = 0, samples = 0;
};

double norm(Vec3 v) {
    return std::sqrt(static_cast<double>(dot(v, v)));
}

/// Twice the tool's own step explains a part of the change of d, the displacement that the force is a function of. The
/// rest of that change is a jump; this is its part of the force's change in a tick, for the promise of tick.h about
/// ContactRule::Smooth.
double jump(const ToolOutput& before, const ToolOutput& now, Vec3 tool_step) {
    const double moved = norm(now.displacement - before.displacement), explained = 2 * norm(tool_step);
    return moved > explained ? norm(now.force - before.force) * (1 - explained / moved) : 0;
}

/// What a tick's tools answered, added to the outcome.
void note_answers(TickOutcome& outcome, const ToolWay& way, std::size_t tick, std::span<const ToolOutput> before,
                  std::span<const ToolOutput> now) {
    for (std::uint32_t k = 0; k < way.tools; ++k) {
        const Vec3 step = way.place(tick, k) - way.place(tick - 1, k);
        outcome.force_jump = std::max(outcome.force_jump, jump(before[k], now[k], step));
        outcome.hits += now[k].hit ? 1 : 0;
        outcome.lost += now[k].lost ? 1 : 0;
    }
}

TickOutcome run_ticks(const Subject& subject, const Setting& setting, const ToolWay& way) {
    State state = subject.state();
    const DeformTable table = take(DeformTable::create(setting.kernel()));
    TickOptions options;
    options.d_max = 4 * state.mean_step();
    options.rule = setting.rule;
    options.footprint = setting.footprint;
    std::vector<ToolInput> in(way.tools);
    for (std::uint32_t k = 0; k < way.tools; ++k) in[k].tool = k;
    std::vector<ToolOutput> out(way.tools), before(way.tools);
    TickReport report;
    TickOutcome result;
    double checked = 0;
    result.times = time_ticks(
        kWarmUp, way.ticks() - kWarmUp,
        [&](std::size_t k) {  // looks at the turn before
            if (k > kWarmUp) {
                note_answers(result, way, k - 1, before, out);
                result.samples = std::max(result.samples, double(report.samples));
                if (k % kCheckEvery == 0) {
                    checked += 1;
                    const std::uint32_t exact = nearest_of_all(state.rest_positions(), state, in[0].position);
                    result.wrong += representative(state, exact) == representative(state, out[0].sample) ? 0 : 1;
                }
            }
            before = out;
            for (std::uint32_t t = 0; t < way.tools; ++t)
                in[t].position = way.place(k, t), in[t].engaged = way.is_engaged(k, t);
        },
        [&](std::size_t) { report = take(tick(state, table, options, in, out)); });
    const auto ticks = static_cast<double>((way.ticks() - kWarmUp) * way.tools);
    result.hits /= ticks;
    result.lost /= ticks;
    result.wrong /= std::max(checked, 1.0);
    return result;
}

}  // namespace

Table tick_table() {
    Table t;
    t.key = "ticks";
    t.title = "Ticks";
    t.note =
        "One turn of the haptic loop: track, hit, force, deform, normals; one thread. p50 to p99.9 are of a fifth "
        "of the ticks each, ticks in which the thread lost its processor left out; max is of all. 'Paper' is the "
        "paper's own setting: 81x81, eq. 7, eqs. 8-10 as printed. Errors of weights are shares of the dent's "
        "depth: table, against the kernel by exp; the others, against the kernel over exact geodesic distances around "
        "twelve contacts, up to b = 21: the largest of contacts farther than b steps from a seam or border of the "
        "grid, "
        "the largest of the rest, and the rms of all. Force jump: largest part of the force's change in a tick, as a "
        "share of f_max, "
        "that twice the tool's own step does not explain. Wrong nearest: share of ticks, of those looked at by "
        "search of all samples.";
    t.columns = subject_columns(
        joined({{
                    key_column("setting", "setting"),
                    key_column("footprint", "footprint"),
                    key_column("b", "b"),
                    key_column("end", "kernel's end"),
                    key_column("rule", "force"),
                    key_column("path", "path"),
                },
                percentile_columns(),
                {time_column("max_us", "max", "us"), exact_column("samples", "samples in reach", "", Sense::kNone),
                 exact_column("table_error", "table error", "", Sense::kLower, 1e-3),
                 exact_column("inside_error_max", "largest error inside", "", Sense::kLower, 1e-3),
                 exact_column("border_error_max", "largest error at seams", "", Sense::kLower, 1e-3),
                 exact_column("surface_error_rms", "rms error", "", Sense::kLower, 1e-3),
                 exact_column("force_jump", "force jump", "", Sense::kLower, 1e-3),
                 exact_column("hit_share", "ticks with hit", "", Sense::kNone),
                 exact_column("lost_share", "ticks that searched", "", Sense::kLower, 1e-3),
                 exact_column("wrong_nearest", "wrong nearest", "", Sense::kLower),
                 time_column("preempted", "preempted ticks", "")}}));
    t.columns.back().sense = Sense::kNone;
    t.plots = {{"Largest error of the dent at seams against tick time", "p50_us", "border_error_max", "setting",
                "asset", false},
               {"Force jump against tick time", "p50_us", "force_jump", "setting", "asset", false},
               {"Slow ticks against typical ones", "p50_us", "p999_us", "setting", "asset", false}};
    return t;
}

void add_tick_rows(Table& table, const Subject& subject, const RunSweepOptions& options, ProgressBar& bar) {
    State state = subject.state();
    GeodesicReference reference(state);
    const std::vector<Setting> settings = settings_for(subject.paper_grid);
    for (std::size_t k = 0; k < settings.size(); ++k) {
        const Setting& s = settings[k];
        bar.update(static_cast<double>(k) / static_cast<double>(settings.size()));
        SubjectRow row(table, subject);
        row.set("setting", s.name);
        row.set("footprint", std::string(name_of(s.footprint)));
        row.set("b", std::to_string(s.reach));
        row.set("end", std::string(s.end == KernelEnd::Printed ? "printed" : "compact"));
        row.set("rule", std::string(s.rule == ContactRule::Printed ? "printed" : "smooth"));
        row.set("path", std::string(name_of(s.path)));
        const TickOutcome ticks = run_ticks(subject, s, path_for(subject, s.path, options, options.ticks + kWarmUp));
        row.set_percentiles(ticks.times);
        row.set("max_us", ticks.times.longest);
        const auto preempted = static_cast<double>(ticks.times.preempted);
        row.set("preempted", Figure{preempted, preempted, preempted, 1, false});
        row.set("samples", exactly(ticks.samples));
        row.set("force_jump", exactly(ticks.force_jump));
        row.set("hit_share", exactly(ticks.hits));
        row.set("lost_share", exactly(ticks.lost));
        row.set("wrong_nearest", exactly(ticks.wrong));
        const DeformTable kernel = take(DeformTable::create(s.kernel()));
        row.set("table_error", exactly(table_error(kernel, s)));
        if (s.reach <= kReferenceReach) {
            const WeightError error = reference.of(state, kernel, s);
            row.set("surface_error_rms", exactly(error.rms));
            row.set("inside_error_max", exactly(error.inside));
            row.set("border_error_max", exactly(error.border));
        }
        table.rows.push_back(row.row());
    }
}

}  // namespace dgm::bench
