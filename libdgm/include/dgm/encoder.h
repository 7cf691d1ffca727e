// SPDX-License-Identifier: MIT
// libdgm/include/dgm/encoder.h
// Where a tool is whose place is read from encoders.
//
// A body that is pressed by a millisecond's step of an encoder feels a blow: 30 um are 30 mm/s. The tool has not moved
// so; it has a mass. EncoderTrack follows the simplest motion that agrees with the readings: an alpha-beta filter
// [Kalata 1984] that corrects its prediction by no more than a reading is off beyond what a step of the encoder hides.
#pragma once
#include <algorithm>
#include <cmath>

#include <dgm/vec.h>

namespace dgm {

/// One tool. A tick each reading; plain numbers, no allocation.
///
/// Even motion is followed without lag, within a quantum. Under an acceleration a the place is behind by 16 a tick^2
/// and half a quantum: with 1 ms and 30 um by 31 um at 1 m/s^2. A reading more than 64 quanta from where it was
/// expected begins anew, as where the user has lifted and moved the device.
class EncoderTrack {
 public:
    /// @param quantum  step of the readings along each axis, in their unit; 0: they are exact
    explicit EncoderTrack(float quantum) noexcept : quantum_(std::max(0.0, double{quantum})) {}
    /// @return where the tool is
    [[nodiscard]] Vec3 follow(Vec3 reading) noexcept {
        const double read[3] = {double{reading.x}, double{reading.y}, double{reading.z}};
        for (int c = 0; c < 3; ++c) begun_ = begun_ && std::fabs(read[c] - place_[c] - way_[c]) <= kFar * quantum_;
        for (int c = 0; c < 3; ++c) {
            if (!begun_) {
                place_[c] = read[c];
                way_[c] = 0;
                continue;
            }
            const double ahead = place_[c] + way_[c], off = read[c] - ahead;
            const double beyond = off - std::clamp(off, -0.5 * quantum_, 0.5 * quantum_);
            place_[c] = ahead + kPlace * beyond;
            way_[c] += kWay * beyond;
        }
        begun_ = true;
        return {static_cast<float>(place_[0]), static_cast<float>(place_[1]), static_cast<float>(place_[2])};
    }

 private:
    // Chosen on a device of 80 g in a hand that presses three organs (tests/bench/haptic_bench.cpp): less of either is
    // a smoother force and more lag.
    static constexpr double kPlace = 0.2, kWay = 0.05, kFar = 64;
    double quantum_;
    double place_[3] = {}, way_[3] = {};  ///< way: in a tick
    bool begun_ = false;
};

}  // namespace dgm
