// SPDX-License-Identifier: MIT
// libdgm/src/touch/window_queue.h
// Windows that wait for their turn, those at near edges first, and that join where they give the same distances.
//
// [Surazhsky et al. 2005] Fast exact and approximate geodesics on meshes. SIGGRAPH 2005. Merging of windows.
// Our choices: a bucket queue of kBuckets widths by the distance of the edge's middle, so that all windows of an edge
// have come before the first of them goes on. The wider of two windows takes the lines of the narrower, if it gives
// them the same lengths at both ends within kMerge. So there are 4 windows a sample where without it there are 25.
#pragma once
#include <algorithm>
#include <cmath>

#include "touch/geodesic.h"

namespace dgm::detail {

struct Vec2 {
    float x, y;
};
DGM_INLINE Vec2 operator+(Vec2 a, Vec2 b) noexcept {
    return {a.x + b.x, a.y + b.y};
}
DGM_INLINE Vec2 operator-(Vec2 a, Vec2 b) noexcept {
    return {a.x - b.x, a.y - b.y};
}
DGM_INLINE Vec2 operator-(Vec2 a) noexcept {
    return {-a.x, -a.y};
}
DGM_INLINE Vec2 operator*(float k, Vec2 a) noexcept {
    return {k * a.x, k * a.y};
}
DGM_INLINE float dot(Vec2 a, Vec2 b) noexcept {
    return a.x * b.x + a.y * b.y;
}
DGM_INLINE float cross(Vec2 a, Vec2 b) noexcept {
    return a.x * b.y - a.y * b.x;
}
DGM_INLINE float length(Vec2 a) noexcept {
    return std::sqrt(dot(a, a));
}

class WindowQueue {
 public:
    WindowQueue(GeodesicScratch& scratch, float radius) noexcept
        : windows_(scratch.windows.data()),
          buckets_(scratch.buckets),
          recent_(scratch.recent),
          capacity_(static_cast<std::uint32_t>(scratch.windows.size())),
          per_bucket_(static_cast<float>(kBuckets) / radius) {
        std::fill_n(buckets_, kBuckets, kNone);
    }

    /// @return false if there is no room; the window is lost.
    bool put(const Window& w) noexcept {
        std::uint32_t& recent = recent_[(w.way * 2654435769u) >> 22];
        static_assert(GeodesicScratch::kRecent == 1u << 10);
        if (recent < used_ && windows_[recent].way == w.way && merge(windows_[recent], w)) return true;
        const Vec2 middle{w.ax + 0.5f * w.ex, w.ay + 0.5f * w.ey};
        if (!put_at(w.offset + length(middle), w)) return false;
        recent = last_;
        return true;
    }
    /// The same, at its turn by a distance; it joins no other.
    bool put_at(float distance, const Window& w) noexcept {
        std::uint32_t k = free_;
        if (k != kNone)
            free_ = windows_[k].next;
        else if (used_ < capacity_)
            k = used_++;
        else
            return false;
        const float at = per_bucket_ * distance;
        const std::uint32_t bucket =
            at < static_cast<float>(kBuckets - 1) ? static_cast<std::uint32_t>(at) : kBuckets - 1;
        std::uint32_t& head = buckets_[std::max(bucket, bucket_)];
        windows_[k] = w;
        windows_[k].next = head;
        head = last_ = k;
        return true;
    }
    /// @return false if none waits.
    bool take(Window& w) noexcept {
        while (buckets_[bucket_] == kNone)
            if (++bucket_ == kBuckets) {
                bucket_ = 0;
                return false;
            }
        const std::uint32_t k = buckets_[bucket_];
        w = windows_[k];
        buckets_[bucket_] = w.next;
        windows_[k].way = kNone;
        windows_[k].next = free_;
        free_ = k;
        return true;
    }

 private:
    static constexpr std::uint32_t kBuckets = GeodesicScratch::kBuckets;
    static constexpr float kMerge = 0.007f;  ///< of the distance to the nearer source
    static constexpr float kPart = 0.05f;    ///< radians by which lines of two that join lead away from each other
    static constexpr float kMeet = 0.15f;    ///< or towards each other
    static constexpr float kGap = 0.1f;      ///< radians between two windows that join

    [[nodiscard]] static bool merge(Window& first, const Window& w) noexcept {
        const Vec2 a1{first.ax, first.ay}, e1{first.ex, first.ey}, a2{w.ax, w.ay}, e2{w.ex, w.ey};
        const bool second = w.left - w.right > first.left - first.right;
        const Window& narrow = second ? first : w;
        const float bend = first.offset - w.offset;
        const Vec2 r1 = a1 + narrow.right * e1, l1 = a1 + narrow.left * e1;
        const Vec2 r2 = a2 + narrow.right * e2, l2 = a2 + narrow.left * e2;
        const float right1 = length(r1), right2 = length(r2), left1 = length(l1), left2 = length(l2);
        const float most = kMerge * std::min(right1, right2);
        if (!(std::fabs(right1 + bend - right2) < most) || !(std::fabs(left1 + bend - left2) < most)) return false;
        // The lines of both must run side by side, above all not lead away from each other.
        const bool first_right = first.right + first.left < w.right + w.left, at_left = first_right == second;
        const float length1 = at_left ? left1 : right1, length2 = at_left ? left2 : right2;
        const float apart = dot(at_left ? l1 : r1, e1) * length2 - dot(at_left ? l2 : r2, e2) * length1;
        const float turn = first_right ? -apart : apart, unit = std::sqrt(dot(e1, e1)) * length1 * length2;
        if (!(turn < kPart * unit) || !(-turn < kMeet * unit)) return false;
        const float gap = std::max(first.right, w.right) - std::min(first.left, w.left);
        if (!(gap * cross(a1, e1) < kGap * length1 * length1)) return false;
        const float right = std::min(first.right, w.right), left = std::max(first.left, w.left);
        if (second) {
            const std::uint32_t next = first.next;
            first = w;
            first.next = next;
        }
        first.right = right;
        first.left = left;
        return true;
    }

    Window* const windows_;
    std::uint32_t* const buckets_;
    std::uint32_t* const recent_;
    const std::uint32_t capacity_;
    const float per_bucket_;
    std::uint32_t bucket_ = 0, used_ = 0, free_ = kNone;
    std::uint32_t last_ = kNone;
};

}  // namespace dgm::detail
