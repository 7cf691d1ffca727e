// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/border_rails.h
// The source's real borders as rails: samples on them slide along them, and never leave them.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "geometry/fit/normal_equations.h"

namespace dgm::bake {

/// Each class on the source's real border is a stop on one of its loops, at an arc length. Between two stops that are
/// neighbours the grid's border is a chord; the chord stands for the part of the loop between them, so comparing the
/// two needs no search. A stop on a corner of the border stays there, and so does a stop that reaches one: where the
/// border turns by 30 degrees over half a chord to each side, or at one vertex alone by 6. Loops whose stops are not in
/// the order of the grid's border keep theirs where they are. Thread-safe but for `slide` and `set_places`.
class BorderRails {
 public:
    /// The references must outlive the object. Diagonals may change later, the grid's border must not.
    BorderRails(const SampledChart& chart, const LinkedSurface& source, const WeldedGrid& grid);

    [[nodiscard]] bool empty() const { return stops_.empty(); }
    /// Per class: free, held where it is, or sliding.
    [[nodiscard]] std::span<const Freedom> freedom() const { return freedom_; }
    /// Per class: unit direction of the border there, at the scale of the chords; zero where it does not slide.
    [[nodiscard]] std::span<const Vec3d> directions() const { return directions_; }

    /// How far a sliding class may go to either side in one round: two neighbours cannot meet.
    [[nodiscard]] double reach(std::uint32_t c) const;
    /// Where the class would be, `by` further along the border; stops at a corner on the way.
    [[nodiscard]] Vec3d place_after(std::uint32_t c, double by) const;
    /// They go there.
    void slide(std::span<const std::pair<std::uint32_t, double>> ways);
    /// True if it is not where it was at first.
    [[nodiscard]] bool has_moved(std::uint32_t c) const;
    /// Per class: how far to the corner without a stop that it is the nearest to, else 0.
    [[nodiscard]] std::vector<double> ways_to_corners() const;
    /// The surface point of a class on the border.
    [[nodiscard]] SurfaceSample sample(std::uint32_t c) const;

    /// Arc lengths of all stops, to come back to later.
    [[nodiscard]] const std::vector<double>& places() const { return places_; }
    void set_places(const std::vector<double>& places);

    /// Rows that pull the grid's border to the source's, at all points of the latter that matter.
    /// @param urgency  factor of a row's weight by the squared gap
    void add_rows(NormalEquations& equations, double weight, const std::function<double(double)>& urgency) const;
    /// Largest distance from the source's border to the chord that stands for it.
    [[nodiscard]] double largest_gap() const;

 private:
    struct Loop {
        std::vector<std::uint32_t> half_edges;  // of the source: 3 * face + edge
        std::vector<double> starts;             // arc length where each begins, then the whole length
        std::vector<double> corners;            // arc lengths, ascending
        std::vector<double> points;             // arc lengths of vertices and points between them, ascending
        [[nodiscard]] double length() const { return starts.back(); }
    };
    struct Stop {
        std::uint32_t class_id = kNone, loop = kNone;
        std::uint32_t before = kNone, after = kNone;  // stops
    };
    /// A point of a loop, against the chord of the stop before it.
    struct Gap {
        std::uint32_t stop;
        double x;  // along the chord, 0..1
        Vec3d gap, chord;
    };

    [[nodiscard]] std::vector<std::uint32_t> leaving_half_edges() const;  // border of the grid, by class
    void refresh();
    void find_loops();
    void find_stops(const SampledChart& chart);
    void order_stops();
    void find_corners();
    [[nodiscard]] std::size_t edge_at(const Loop& loop, double t) const;
    [[nodiscard]] Vec3d point_at_length(const Loop& loop, double t) const;
    [[nodiscard]] double turn_at(const Loop& loop, double t, double reach) const;
    [[nodiscard]] double piece(const Stop& stop) const;
    [[nodiscard]] double after_sliding(const Stop& stop, double by) const;
    template <class Visit>
    void for_gaps(Visit visit) const;

    const LinkedSurface& source_;
    const WeldedGrid& grid_;
    std::vector<Loop> loops_;
    std::vector<Stop> stops_;
    std::vector<double> places_, first_places_;       // per stop
    std::vector<std::uint32_t> stop_of_;              // per class
    std::vector<std::vector<std::uint32_t>> orders_;  // per loop: its stops along the border; empty if they stay
    std::vector<Freedom> freedom_;
    std::vector<Vec3d> directions_;
};

}  // namespace dgm::bake
