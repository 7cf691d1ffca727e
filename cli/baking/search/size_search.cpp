// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/search/size_search.cpp
#include "baking/search/size_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double samples_of(GridSize size) {
    return static_cast<double>(size.rows) * size.cols;
}

/// Samples along a side of the square with as many samples: the reciprocal of the spacing.
double fineness(GridSize size) {
    return std::sqrt(samples_of(size));
}

/// The largest odd number of samples not above `side`.
std::uint32_t odd_side(double side) {
    const double held = std::clamp(std::floor(side), double{kMinSide}, double{kMaxSide});
    const auto whole = static_cast<std::uint32_t>(held);
    return whole % 2 == 1 ? whole : whole - 1;
}

/// First grid of the ladder at least so fine; the last if none is.
std::size_t first_as_fine(std::span<const GridSize> ladder, double wanted) {
    const auto it = std::lower_bound(ladder.begin(), ladder.end(), wanted,
                                     [](GridSize size, double side) { return fineness(size) < side; });
    return it == ladder.end() ? ladder.size() - 1 : static_cast<std::size_t>(it - ladder.begin());
}

/// A search for a step of a ladder between grids known to lie on one side of the answer and on the other.
class Bracket {
 public:
    Bracket(std::span<const GridSize> ladder, const MeasureStep& measure) : ladder_(ladder), measure_(measure) {}

    /// Measures `step`, once.
    double value(std::size_t step) {
        const auto [it, fresh] = known_.try_emplace(step, 0.0);
        if (fresh) {
            it->second = measure_(step);
            out_.trials.push_back({step, it->second});
        }
        return it->second;
    }

    void set_low(std::size_t step) {
        low_ = static_cast<std::ptrdiff_t>(step);
        narrowed();
    }
    void set_high(std::size_t step) {
        high_ = static_cast<std::ptrdiff_t>(step);
        narrowed();
    }

    [[nodiscard]] bool has_low() const { return low_ >= 0; }
    [[nodiscard]] bool has_high() const { return high_ < static_cast<std::ptrdiff_t>(ladder_.size()); }
    [[nodiscard]] std::size_t low() const { return static_cast<std::size_t>(low_); }
    [[nodiscard]] std::size_t high() const { return static_cast<std::size_t>(high_); }
    [[nodiscard]] bool closed() const { return high_ - low_ <= 1; }

    /// `wanted`, or the nearest step inside; the middle where predictions have not halved the bracket in two tries.
    [[nodiscard]] std::size_t inside(std::size_t wanted) const {
        const std::ptrdiff_t middle = low_ + (high_ - low_) / 2;
        const bool stalled = tries_ >= 2 && has_low() && has_high();
        return static_cast<std::size_t>(
            std::clamp(stalled ? middle : static_cast<std::ptrdiff_t>(wanted), low_ + 1, high_ - 1));
    }

    SizeSearch& out() { return out_; }

 private:
    void narrowed() {
        if (!has_low() || !has_high()) {
            width_ = high_ - low_;
            return;
        }
        ++tries_;
        if (2 * (high_ - low_) <= width_) {
            width_ = high_ - low_;
            tries_ = 0;
        }
    }

    std::span<const GridSize> ladder_;
    const MeasureStep& measure_;
    std::map<std::size_t, double> known_;
    std::ptrdiff_t low_ = -1, high_ = static_cast<std::ptrdiff_t>(ladder_.size());
    std::ptrdiff_t width_ = high_ + 1;
    int tries_ = 0;
    SizeSearch out_;
};

struct Point {
    double side, value;
};

/// The power with which the value falls between two grids, coarse to fine.
double slope(Point coarse, Point fine) {
    return math::log(coarse.value / fine.value) / math::log(fine.side / coarse.side);
}

bool usable(Point p) {
    return p.value > 0 && p.value < kInfinity;
}

/// The nearest usable measurement on the far side of `from`, at least 1.4 times coarser or finer.
std::optional<Point> neighbour(std::span<const GridSize> ladder, const SizeSearch& search, Point from, bool coarser) {
    std::optional<Point> best;
    for (const SizeTrial& trial : search.trials) {
        const Point p{fineness(ladder[trial.step]), trial.value};
        if (!usable(p) || (coarser ? p.side * 1.4 > from.side : p.side < 1.4 * from.side)) continue;
        if (!best || (coarser ? p.side > best->side : p.side < best->side)) best = p;
    }
    return best;
}

}  // namespace

GridSize grid_of(std::uint64_t samples, double aspect) {
    const auto total = static_cast<double>(samples);
    // Either side first, the other takes the rest; the product decides.
    const std::uint32_t rows = odd_side(std::sqrt(total * aspect)), cols = odd_side(std::sqrt(total / aspect));
    const GridSize rows_first{rows, odd_side(total / rows)}, cols_first{odd_side(total / cols), cols};
    const auto off = [&](GridSize s) { return std::abs(math::log((s.rows - 1.0) / (s.cols - 1.0) / aspect)); };
    GridSize best{rows, cols};
    for (const GridSize s : {rows_first, cols_first})
        if (samples_of(s) <= total && samples_of(s) > samples_of(best) && off(s) < 0.05 + off({rows, cols})) best = s;
    return best;
}

GridSize even_grid_of(std::uint64_t samples, double aspect) {
    constexpr std::uint32_t kDivisor = 8, kLeast = 33;
    const GridSize exact = grid_of(samples, aspect);
    const auto held = [](double side) { return 1 + (static_cast<std::uint32_t>(side) - 1) / kDivisor * kDivisor; };
    const bool rows_longer = exact.rows >= exact.cols;
    const std::uint32_t shorter = std::min(exact.rows, exact.cols);
    if (shorter < kLeast) return exact;
    const std::uint32_t few = held(shorter);
    const std::uint32_t many = std::min(held(static_cast<double>(samples) / few), kMaxSide);
    return rows_longer ? GridSize{many, few} : GridSize{few, many};
}

std::vector<GridSize> grid_ladder(GridSize largest, bool coarse) {
    const std::uint32_t longer = std::max(largest.rows, largest.cols) - 1;
    std::vector<GridSize> out;
    for (std::uint32_t intervals = 2, step = 2, octave = 128; intervals < longer; intervals += step) {
        const auto side = [&](std::uint32_t full) {
            const double exact = static_cast<double>(full - 1) * intervals / longer;
            return 1 + 2 * static_cast<std::uint32_t>(std::max(1L, std::lround(exact / 2)));
        };
        const GridSize size{side(largest.rows), side(largest.cols)};
        out.push_back(size);
        if (coarse && intervals == octave) {
            step *= 2;
            octave *= 2;
        }
    }
    out.push_back(largest);
    return out;
}

SizeSearch smallest_that_holds(std::span<const GridSize> ladder, double asked, std::size_t first,
                               const MeasureStep& measure) {
    constexpr double kExpected = 2, kLargestJump = 4, kJudged = 257;
    Bracket bracket(ladder, measure);
    const auto point = [&](std::size_t step) { return Point{fineness(ladder[step]), bracket.value(step)}; };
    std::size_t next = std::min(first, ladder.size() - 1);
    int without_map = 0;
    while (!bracket.closed()) {
        const double value = bracket.value(next);
        without_map = value < kInfinity ? 0 : without_map + 1;
        value <= asked ? bracket.set_high(next) : bracket.set_low(next);
        if (bracket.closed()) break;
        const SizeSearch& so_far = bracket.out();
        if (!bracket.has_high()) {
            const Point low = point(bracket.low());
            if (!usable(low)) {
                // No map on three grids in a row, each twice as fine: it is not the grid's fault.
                if (without_map >= 3) {
                    bracket.out().given_up = true;
                    break;
                }
                next = bracket.inside(first_as_fine(ladder, 2 * low.side));
                continue;
            }
            double power = kExpected;
            if (const auto coarse = neighbour(ladder, so_far, low, true)) {
                const double measured = slope(*coarse, low);
                const double best_case =
                    low.value * math::pow(low.side / fineness(ladder.back()), std::max(0.0, measured) + 1);
                if (low.side >= kJudged && best_case > asked) {
                    bracket.out().given_up = true;
                    break;
                }
                power = std::clamp(measured, 1.0, 3.0);
            }
            const double wanted = low.side * math::pow(low.value / asked, 1 / power);
            next = bracket.inside(first_as_fine(ladder, std::min(wanted, kLargestJump * low.side)));
        } else if (!bracket.has_low()) {
            const Point high = point(bracket.high());
            double power = kExpected;
            if (const auto fine = neighbour(ladder, so_far, high, false))
                power = std::clamp(slope(high, *fine), 1.0, 3.0);
            const double wanted = high.value > 0 ? high.side * math::pow(high.value / asked, 1 / power) : 0;
            next = bracket.inside(first_as_fine(ladder, std::max(wanted, high.side / kLargestJump)));
        } else {
            const Point low = point(bracket.low()), high = point(bracket.high());
            double wanted = std::sqrt(low.side * high.side);
            if (usable(low) && usable(high) && low.value > high.value)
                wanted = low.side * math::pow(low.value / asked, 1 / slope(low, high));
            next = bracket.inside(first_as_fine(ladder, wanted));
        }
    }
    SizeSearch out = std::move(bracket.out());
    if (bracket.has_high()) out.found = bracket.high();
    return out;
}

SizeSearch largest_that_fits(std::span<const GridSize> ladder, double budget, std::size_t first,
                             const MeasureStep& measure) {
    Bracket bracket(ladder, measure);
    std::size_t next = std::min(first, ladder.size() - 1);
    int without_map = 0;
    while (!bracket.closed()) {
        const double value = bracket.value(next);
        without_map = value < kInfinity ? 0 : without_map + 1;
        // A grid without a map is too small, not too large.
        value <= budget || value == kInfinity ? bracket.set_low(next) : bracket.set_high(next);
        if (bracket.closed() || without_map >= 3) break;
        // The line through the two measurements nearest to the budget; through the origin while there is one only.
        std::vector<Point> known;
        for (const SizeTrial& trial : bracket.out().trials)
            if (trial.value < kInfinity) known.push_back({samples_of(ladder[trial.step]), trial.value});
        std::sort(known.begin(), known.end(),
                  [&](Point a, Point b) { return std::abs(a.value - budget) < std::abs(b.value - budget); });
        double wanted = 4 * samples_of(ladder[next]);
        if (!known.empty() && known[0].value > 0) {
            double per_sample = known[0].value / known[0].side;
            if (known.size() > 1 && known[0].side != known[1].side) {
                const double measured = (known[0].value - known[1].value) / (known[0].side - known[1].side);
                if (measured > 0.1 * per_sample) per_sample = measured;
            }
            wanted = known[0].side + (budget - known[0].value) / per_sample;
        }
        // The largest expected to fit: the one before the first that is finer.
        const std::size_t beyond = first_as_fine(ladder, std::sqrt(std::max(1.0, std::floor(wanted) + 1)));
        const bool is_beyond = samples_of(ladder[beyond]) > wanted;
        next = bracket.inside(is_beyond && beyond > 0 ? beyond - 1 : beyond);
    }
    const bool found = bracket.has_low() && bracket.value(bracket.low()) < kInfinity;
    SizeSearch out = std::move(bracket.out());
    if (found) out.found = bracket.low();
    return out;
}

AspectChoice choose_aspect(std::uint64_t samples, const MeasureAspect& measure, AspectRange range) {
    constexpr double kGain = 0.98;
    AspectChoice out;
    const auto aspect_of = [](int step) { return math::pow(2.0, 0.5 * step); };  // in factors of sqrt 2
    std::map<int, double> rms;
    const auto try_step = [&](int step) {
        if (!rms.contains(step)) rms[step] = out.trials.emplace_back(measure(grid_of(samples, aspect_of(step)))).rms;
        return rms[step];
    };
    int best = 0;
    try_step(0);
    if (const double free = out.trials.front().chart_aspect; free > 0) {
        const double aspect = std::clamp(free, 1.0 / 8, 8.0);
        const GridSize size = grid_of(samples, aspect);
        out.rms = out.trials.front().rms;
        if (size == out.trials.front().size) return out;
        if (const double own = out.trials.emplace_back(measure(size)).rms; own < kGain * out.rms) {
            out.aspect = aspect;
            out.rms = own;
        }
        return out;
    }
    const auto consider = [&](int step) {
        if (std::abs(step) > range.longest) return;
        if (try_step(step) < (best == 0 ? kGain : 1.0) * rms[best]) best = step;
    };
    consider(-range.first);
    consider(range.first);
    const bool goes_on = best != 0 || range.near;
    for (int last = 0; best != last;) {
        last = best;
        for (const int step : {last + (last < 0 ? -2 : 2), last + (last < 0 ? 2 : -2)}) consider(step);
    }
    const int centre = best;
    if (goes_on)
        for (const int step : {centre - 1, centre + 1}) consider(step);
    out.aspect = aspect_of(best);
    out.rms = rms[best];
    return out;
}

}  // namespace dgm::bake
