// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/statistics.cpp
#include "bench/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace dgm::bench {
namespace {

constexpr double kLeastSpread = 0.02;

/// Two-sided 95 % quantile of Student's t with `freedom` >= 1 degrees.
double student95(std::size_t freedom) {
    constexpr std::array kTable{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228};
    return freedom <= kTable.size() ? kTable[freedom - 1] : 1.960 + 2.72 / static_cast<double>(freedom);
}

bool usable(double x) {
    return std::isfinite(x) && x > 0;
}

}  // namespace

double quantile(std::vector<double> sample, double share) {
    if (sample.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::sort(sample.begin(), sample.end());
    const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(sample.size() - 1);
    const auto k = std::min(static_cast<std::size_t>(at), sample.size() - 1);
    const std::size_t next = std::min(k + 1, sample.size() - 1);
    return sample[k] + (at - static_cast<double>(k)) * (sample[next] - sample[k]);
}

Figure summarize(std::span<const double> times) {
    Figure out;
    out.repetitions = static_cast<unsigned>(times.size());
    out.value = out.low = out.high = quantile({times.begin(), times.end()}, 0.5);
    if (times.size() < 2 || !std::all_of(times.begin(), times.end(), usable)) return out;
    const auto n = static_cast<double>(times.size());
    double mean = 0, squares = 0;
    for (const double t : times) mean += std::log(t) / n;
    for (const double t : times) squares += (std::log(t) - mean) * (std::log(t) - mean);
    const double deviation = std::sqrt(squares / (n - 1));
    const double spread = std::exp(std::max(kLeastSpread, student95(times.size() - 1) * deviation * std::sqrt(2 / n)));
    out.low = out.value / spread;
    out.high = out.value * spread;
    return out;
}

std::optional<Ratio> ratio(const Figure& now, const Figure& then) {
    for (const Figure* f : {&now, &then})
        if ((!f->repeatable && f->repetitions < kEnoughRepetitions) || !usable(f->value)) return std::nullopt;
    const double value = now.value / then.value;
    // Each interval is already one for the difference of two runs: the wider one holds for both.
    const double spread = std::max(now.high / now.value, then.high / then.value);
    return Ratio{value, value / spread, value * spread};
}

std::optional<PowerLaw> fit_power_law(std::span<const double> x, std::span<const double> y) {
    if (x.size() < 3 || !std::all_of(x.begin(), x.end(), usable) || !std::all_of(y.begin(), y.end(), usable))
        return std::nullopt;
    if (const auto [least, most] = std::minmax_element(x.begin(), x.end()); *least == *most) return std::nullopt;
    const auto n = static_cast<double>(x.size());
    double mean_x = 0, mean_y = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
        mean_x += std::log(x[k]) / n;
        mean_y += std::log(y[k]) / n;
    }
    double xx = 0, xy = 0, yy = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
        const double dx = std::log(x[k]) - mean_x, dy = std::log(y[k]) - mean_y;
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
    }
    const double slope = xy / xx;
    return PowerLaw{slope, std::sqrt(std::max(0.0, yy - slope * xy) / (n - 2) / xx)};
}

}  // namespace dgm::bench
