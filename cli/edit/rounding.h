// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/rounding.h
// How finely a painted file holds numbers, and so which of them were painted.
#pragma once
#include <algorithm>
#include <cmath>

#include "model/half.h"

namespace dgm::edit {

/// The numbers that a file can hold.
struct Rounding {
    enum class Kind { kExact, kHalf, kSteps } kind = Kind::kExact;
    double low = 0, high = 1;  ///< kSteps: what the codes 0 and `steps` stand for
    unsigned steps = 255;

    [[nodiscard]] static Rounding exact() { return {}; }
    [[nodiscard]] static Rounding half() { return {Kind::kHalf, 0, 1, 0}; }
    [[nodiscard]] static Rounding codes(double low, double high, unsigned steps) {
        return {Kind::kSteps, low, high, steps};
    }
    /// The number that a code 0..1 of a picture stands for.
    [[nodiscard]] double value_of(double unit) const { return kind == Kind::kSteps ? low + unit * (high - low) : unit; }
};

/// Whether a file with this rounding, made from `original`, holds `saved`: then nobody has painted there.
/// For codes that is the nearest one; beyond the range, the last.
[[nodiscard]] inline bool is_untouched(double original, double saved, const Rounding& rounding) {
    if (std::isnan(original) || std::isnan(saved)) return std::isnan(original) && std::isnan(saved);
    if (original == saved) return true;
    switch (rounding.kind) {
        case Rounding::Kind::kExact:
            return false;
        case Rounding::Kind::kHalf:
            return model::half_bits(static_cast<float>(original)) == model::half_bits(static_cast<float>(saved));
        case Rounding::Kind::kSteps:
            break;
    }
    const double size = rounding.high - rounding.low;
    if (!(size > 0)) return true;  // all codes stand for one number
    const auto code = [&](double value) {
        return std::lround(std::clamp((value - rounding.low) / size, 0.0, 1.0) * rounding.steps);
    };
    // Half-way numbers round to either side, depending on the program.
    const double exact = std::clamp((original - rounding.low) / size, 0.0, 1.0) * rounding.steps;
    constexpr double kTie = 1e-4;
    return std::abs(exact - static_cast<double>(code(saved))) <= 0.5 + kTie;
}

}  // namespace dgm::edit
