// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/dice.h
// Throws decisions from a fuzzer's bytes, one byte each while there are any, then from a generator seeded by them all:
// eight bytes make a whole program, and a changed byte changes one decision.
#pragma once
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <span>

namespace dgm::test {

class Dice {
 public:
    explicit Dice(std::span<const std::uint8_t> bytes) : bytes_(bytes), state_(0xCBF29CE484222325u) {
        for (const std::uint8_t b : bytes) state_ = (state_ ^ b) * 0x100000001B3u;
    }
    explicit Dice(std::uint64_t seed) : state_(seed) {}  // from the generator alone
    std::uint64_t bits() {                               // splitmix64
        std::uint64_t z = state_ += 0x9E3779B97F4A7C15u;
        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
        z = (z ^ z >> 27) * 0x94D049BB133111EBu;
        return z ^ z >> 31;
    }
    /// 0 .. count - 1; count > 0.
    std::uint32_t below(std::uint32_t count) {
        std::uint64_t r = bits() >> 16;
        if (next_ < bytes_.size()) r = count > 256 ? bytes_[next_++] << 8 | (r & 255) : bytes_[next_++];
        return static_cast<std::uint32_t>(r % count);
    }
    std::uint32_t between(std::uint32_t low, std::uint32_t high) { return low + below(high - low + 1); }
    bool one_in(std::uint32_t count) { return below(count) == 0; }
    float real(float low, float high) {
        return low + (high - low) * static_cast<float>(static_cast<double>(bits() >> 11) * 0x1p-53);
    }
    template <class T>
    T of(std::initializer_list<T> values) {
        return values.begin()[below(static_cast<std::uint32_t>(values.size()))];
    }
    /// A size over the powers of ten that limits.h allows, and the limits themselves.
    float size(float low, float high) {
        switch (below(4)) {
            case 0:
                return of({low, high});
            case 1: {
                const float s = of({1e-30f, 1e-15f, 1e-9f, 1e-4f, 1e4f, 1e9f, 1e15f, 1e18f, 1e30f});
                return s < low ? low : s > high ? high : s;
            }
            default:
                return real(low > 0.1f ? low : 0.1f < high ? 0.1f : low, high < 4 ? high : 4);
        }
    }
    /// No size: what no call may take for one.
    float absurd() {
        using Limits = std::numeric_limits<float>;
        return of({Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), Limits::max(), -1.0f, 2e18f});
    }

 private:
    std::span<const std::uint8_t> bytes_;
    std::size_t next_ = 0;
    std::uint64_t state_;
};

}  // namespace dgm::test
