// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/statistics.h
// Statistics of a figure that was measured a few times.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace dgm::bench {

/// A figure and the interval in which another run's figure is expected with 95 %.
struct Figure {
    double value = 0;          ///< median
    double low = 0, high = 0;  ///< equal to value where it was taken once
    unsigned repetitions = 1;  ///< 1: nothing is known about the spread
    bool repeatable = false;   ///< the same input gives the same figure; no repetition is needed
};

/// A figure that does not differ from run to run: an error, a size, a count.
[[nodiscard]] constexpr Figure exactly(double value) {
    return {value, value, value, 1, true};
}

/// In another unit.
[[nodiscard]] constexpr Figure scaled(Figure f, double factor) {
    f.value *= factor;
    f.low *= factor;
    f.high *= factor;
    return f;
}

/// Times are compared by ratio only if each was taken so often.
inline constexpr unsigned kEnoughRepetitions = 3;

/// The value at `share` (0..1) of the sorted sample, linear between neighbours; NaN if there is none.
[[nodiscard]] double quantile(std::vector<double> sample, double share);

/// Median of positive times, and around it exp(+-t s sqrt(2/n)) of their logarithms' deviation s: Student's interval
/// for the difference of two such runs, at least 2 % either way (below, a machine differs from itself). The value alone
/// if there is one, or if a time is not positive. @return NaN without times
[[nodiscard]] Figure summarize(std::span<const double> times);

/// now / then.
struct Ratio {
    double value = 1;
    double low = 1, high = 1;  ///< of the two intervals together
    [[nodiscard]] bool beyond_noise() const { return low > 1 || high < 1; }
};

/// nullopt where no ratio can be stated: a side taken fewer than kEnoughRepetitions times, not positive or not finite.
[[nodiscard]] std::optional<Ratio> ratio(const Figure& now, const Figure& then);

/// y = c x^exponent by least squares on logarithms.
struct PowerLaw {
    double exponent = 0;
    double error = 0;  ///< standard error of the exponent
};

/// nullopt for fewer than three points, x all equal, or something not positive. @pre as many x as y
[[nodiscard]] std::optional<PowerLaw> fit_power_law(std::span<const double> x, std::span<const double> y);

}  // namespace dgm::bench
