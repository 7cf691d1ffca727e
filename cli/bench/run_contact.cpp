// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/run_contact.cpp
// Contact with a plane: eq. 11 as printed, the volume kept exactly, no bulge; against the volume of the triangles.
#include <dgm/contact.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/run_sweep.h"
#include "bench/runtime_error.h"

namespace dgm::bench {
namespace {

constexpr std::size_t kWarmUp = 3, kContacts = 50;

/// The plane, tilted against all axes, that leaves `share` of the surface's samples beyond it.
Obstacle plane_for(const State& state, double share) {
    const Vec3 normal{-0.3f, 0.5f, -0.8124f};
    std::vector<float> heights;
    for (std::uint32_t k = 0; k < state.sample_count(); ++k)
        if (state.on_surface(k)) heights.push_back(dot(normal, state.positions()[k]));
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(heights.size()));
    std::nth_element(heights.begin(), heights.begin() + at, heights.end());
    Obstacle plane;
    plane.normal = normal;
    plane.point = (heights[static_cast<std::size_t>(at)] / dot(normal, normal)) * normal;
    return plane;
}

const char* name_of(Bulge bulge) {
    return bulge == Bulge::Exact ? "exact" : bulge == Bulge::Paper ? "paper" : "none";
}

}  // namespace

Table contact_table() {
    Table t;
    t.key = "contact";
    t.title = "Contact with a plane";
    t.note =
        "The shape set down on a tilted plane so deep that the given share of its samples is beyond. Volume error: "
        "what "
        "the shape has gained or lost after the contact, divided by the volume that the plane took from it, measured "
        "on "
        "the triangles: 0 is exact, 1 is no bulge at all, and eq. 11 of the paper ('paper') depends on the number of "
        "samples. Open shapes enclose no volume.";
    t.columns = subject_columns(
        {key_column("mode", "mode"), key_column("share", "beyond"), time_column("p50_us", "p50", "us"),
         time_column("p99_us", "p99", "us"), exact_column("samples", "samples in contact", "", Sense::kNone),
         exact_column("ring", "samples bulged", "", Sense::kNone),
         exact_column("volume_error", "volume error", "", Sense::kLower, 1e-3), text_column("outcome", "outcome")});
    t.plots = {{"Volume error against time", "p50_us", "volume_error", "mode", "asset", false}};
    return t;
}

void add_contact_rows(Table& table, const Subject& subject) {
    State state = subject.state();
    const ContactSolver solver = take(ContactSolver::create(state));
    for (const double share : {0.01, 0.05, 0.2}) {
        const Obstacle plane = plane_for(state, share);
        for (const Bulge bulge : {Bulge::Paper, Bulge::Exact, Bulge::None}) {
            ContactOptions options;
            options.bulge = bulge;
            ContactReport report;
            double error = std::nan("");
            const double before = solver.volume(state);
            const TickTimes times = time_ticks(
                kWarmUp, kContacts,
                [&](std::size_t) {
                    state.release();
                    state.update_normals();
                },
                [&](std::size_t) { report = take(resolve_contact(state, solver, plane, options)); });
            if (solver.closed() && report.removed != 0)
                error = std::fabs(solver.volume(state) - before) / std::fabs(report.removed);
            state.release();
            state.update_normals();
            SubjectRow row(table, subject);
            row.set("mode", std::string(name_of(bulge)));
            row.set("share", fmt::format("{:.0f} %", 100 * share));
            row.set("p50_us", times.median);
            row.set("p99_us", times.p99);
            row.set("samples", exactly(report.samples));
            row.set("ring", exactly(report.ring));
            row.set("volume_error", exactly(error));
            row.set("outcome", std::string(!solver.closed() ? "open" : report.volume_kept ? "volume kept" : "contact"));
            table.rows.push_back(row.row());
        }
    }
}

}  // namespace dgm::bench
