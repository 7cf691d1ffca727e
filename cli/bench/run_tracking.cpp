// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/run_tracking.cpp
// Finding the nearest sample: the paper's window of several sizes, the window made certain, the pyramid, all samples.
#include <dgm/collide.h>

#include <algorithm>
#include <cmath>

#include "bench/run_sweep.h"
#include "bench/runtime_error.h"

namespace dgm::bench {
namespace {

constexpr std::size_t kWarmUp = 200, kChecked = 2000;

float distance_to_all(const State& state, Vec3 tool) {
    const PointView points = state.positions();
    float least = std::numeric_limits<float>::infinity();
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
        const Vec3 d = points[k] - tool;
        if (state.on_surface(k)) least = std::min(least, dot(d, d));
    }
    return std::sqrt(least);
}

enum class Way { kWindow, kCertain, kPyramid, kAll };

struct Search {
    const char* name;
    Way way;
    std::uint32_t a = 0;
};
constexpr Search kSearches[] = {{"window", Way::kWindow, 1},
                                {"window", Way::kWindow, 2},
                                {"window", Way::kWindow, 4},
                                {"window", Way::kWindow, 8},
                                {"window", Way::kWindow, 16},
                                {"window, certified", Way::kCertain, 2},
                                {"window, certified", Way::kCertain, 4},
                                {"pyramid", Way::kPyramid},
                                {"all samples", Way::kAll}};

/// One search after the other along a path; each starts from its last result.
class Tracker {
 public:
    Tracker(State& state, const Search& search) : state_(state), search_(search) {}
    float find(Vec3 tool) {
        if (search_.way == Way::kAll) return distance_to_all(state_, tool);
        if (search_.way == Way::kPyramid || last_ == kNone) return keep(take(nearest_sample(state_, tool)));
        if (search_.way == Way::kWindow) return keep(take(track_sample(state_, tool, last_, search_.a)));
        const Tracked found = take(track_nearest(state_, tool, last_, search_.a));
        last_ = found.sample;
        return found.distance;
    }

 private:
    float keep(const Nearest& found) {
        last_ = found.sample;
        return found.distance;
    }
    State& state_;
    const Search& search_;
    std::uint32_t last_ = kNone;
};

}  // namespace

Table tracking_table() {
    Table t;
    t.key = "tracking";
    t.title = "Nearest sample";
    t.note =
        "The paper tracks the nearest sample in the (2a+1) x (2a+1) window around the last one, which can lose it for "
        "good; 'certified' is that window and the pyramid's lower bounds. Missed: share of ticks in which a sample was "
        "nearer than the one found, by search of all samples; too far: the mean of how much, in mean grid steps.";
    t.columns = subject_columns(joined({{
                                            key_column("search", "search"),
                                            key_column("a", "a"),
                                            key_column("path", "path"),
                                        },
                                        percentile_columns(),
                                        {exact_column("missed_share", "missed", "", Sense::kLower),
                                         exact_column("too_far_steps", "too far", "steps", Sense::kLower, 1e-3)}}));
    t.plots = {{"Missed nearest samples against time", "p50_us", "missed_share", "search", "asset", false}};
    return t;
}

void add_tracking_rows(Table& table, const Subject& subject, const RunSweepOptions& options) {
    State state = subject.state();
    for (const Path kind : kPaths)
        for (const Search& search : kSearches) {
            const std::size_t count = search.way == Way::kAll ? kChecked : options.ticks;
            const ToolWay way = path_for(subject, kind, options, std::max(count, kChecked) + kWarmUp);
            std::vector<Vec3> path;  // the first tool's
            for (std::size_t k = 0; k < way.ticks(); ++k) path.push_back(way.place(k, 0));
            Tracker timed(state, search);
            volatile float sink = 0;  // or the search may be left out
            const TickTimes times =
                time_ticks(kWarmUp, count, nullptr, [&](std::size_t k) { sink = timed.find(path[k]); });
            Tracker checked(state, search);
            double missed = 0, too_far = 0;
            for (std::size_t k = 0; k < kChecked; ++k) {
                const float found = checked.find(path[k]), exact = distance_to_all(state, path[k]);
                // Both are square roots of the same float expression where the sample is the same.
                missed += found > exact ? 1 : 0;
                too_far += (found - exact) / state.mean_step();
            }
            SubjectRow row(table, subject);
            row.set("search", std::string(search.name));
            row.set("a", search.a > 0 ? std::to_string(search.a) : std::string());
            row.set("path", std::string(name_of(kind)));
            row.set_percentiles(times);
            row.set("missed_share", exactly(missed / kChecked));
            row.set("too_far_steps", exactly(too_far / kChecked));
            table.rows.push_back(row.row());
        }
}

}  // namespace dgm::bench
