// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/fabrics.cpp
// One weave renderer; a fabric is a thread count, a rule which thread lies on top, and a dye for each thread.
#include "fabrics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "math/portable.h"
#include "noise.h"

namespace dgm::samples {
namespace {

/// Colour and height of one point of the cloth.
struct Look {
    Colour colour;
    double relief;
};

struct Weave {
    int warps = 0, wefts = 0;  ///< threads across the picture; multiples of the weave's repeat, so it tiles
    std::function<bool(int warp, int weft)> warp_on_top;
    std::function<Colour(int warp, double along)> warp_dye;  ///< along: 0..1 over the picture
    std::function<Colour(int weft, double along)> weft_dye;
    double thread_width = 0.92;  ///< of the thread's spacing
    double contrast = 0.55;      ///< how dark the flank of a thread is
    int fibres = 4;              ///< fibre streaks across a thread
    double fuzz = 0.16;          ///< strength of the streaks
};

// Share of its float a thread has run at this crossing, 0..1; -1 and +1 steps along the other set until it dives.
template <class OnTop>
double float_share(OnTop&& on_top, double within) {
    constexpr int kLongest = 8;
    int before = 0, after = 0;
    while (before < kLongest && on_top(-before - 1)) ++before;
    while (after < kLongest && on_top(after + 1)) ++after;
    return (before + within) / (before + after + 1);
}

struct Thread {
    double across;  ///< -1..1 over the thread's width
    double share;   ///< along its float
    Colour dye;
    double streak;
};

Look shade_thread(const Weave& w, const Thread& t) {
    const double a = t.across / w.thread_width;
    if (std::abs(a) >= 1) return {t.dye * (1 - w.contrast) * 0.75, 0.1};
    const double round = std::sqrt(1 - a * a);
    const double crown = std::sqrt(math::sin(std::numbers::pi * std::clamp(t.share, 0.02, 0.98)));
    const double height = round * (0.55 + 0.45 * crown);
    return {t.dye * ((1 - w.contrast) + w.contrast * height) * (1 + w.fuzz * t.streak), 0.15 + 0.8 * height};
}

Look weave_at(const Weave& w, double u, double v) {
    const double x = u * w.warps, y = v * w.wefts;
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const double fx = x - i, fy = y - j;
    const auto on_top = [&w](int a, int b) { return w.warp_on_top((a + w.warps) % w.warps, (b + w.wefts) % w.wefts); };
    if (on_top(i, j)) {
        const double streak = tiled_noise2(x * w.fibres, y * 0.9 + 0.0, w.warps * w.fibres, w.wefts, 71);
        return shade_thread(
            w, {2 * fx - 1, float_share([&](int k) { return on_top(i, j + k); }, fy), w.warp_dye(i, v), streak});
    }
    const double streak = tiled_noise2(x * 0.9, y * w.fibres, w.warps, w.wefts * w.fibres, 72);
    return shade_thread(
        w, {2 * fy - 1, float_share([&](int k) { return !on_top(i + k, j); }, fx), w.weft_dye(j, u), streak});
}

Picture render(const Weave& w, int width, int height) {
    constexpr int kSamples = 3;  // a side
    Picture out(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            Colour colour;
            double relief = 0;
            for (int b = 0; b < kSamples; ++b)
                for (int a = 0; a < kSamples; ++a) {
                    const Look s = weave_at(w, (x + (a + 0.5) / kSamples) / width, (y + (b + 0.5) / kSamples) / height);
                    colour += s.colour;
                    relief += s.relief;
                }
            out.colour[out.at(x, y)] = colour / (kSamples * kSamples);
            out.relief[out.at(x, y)] = relief / (kSamples * kSamples);
        }
    return out;
}

bool plain(int warp, int weft) {
    return (warp + weft) % 2 == 0;
}
}  // namespace

Picture make_denim(int side) {
    Weave w;
    w.warps = w.wefts = 72;
    w.warp_on_top = [](int warp, int weft) { return (warp + weft) % 4 != 0; };
    w.warp_dye = [](int warp, double along) {
        const double thread = hash01(warp, 0, 0, 81) - 0.5;
        // Slubs: thicker, paler stretches that come and go along the yarn.
        const double slub =
            smooth_step(0.25, 0.8, tiled_noise2(along * 5 + 5 * hash01(warp, 1, 0, 82), warp, 5, 72, 83));
        const double wear = tiled_noise2(along * 24, warp, 24, 72, 84);
        return mix(rgb(42, 62, 112), rgb(132, 154, 194),
                   std::clamp(0.16 + 0.22 * thread + 0.50 * slub + 0.14 * wear, 0.0, 1.0));
    };
    w.weft_dye = [](int weft, double along) {
        return rgb(226, 226, 218) * (0.93 + 0.07 * tiled_noise2(along * 16, weft, 16, 72, 85));
    };
    w.contrast = 0.62;
    w.fibres = 3;
    w.fuzz = 0.22;
    return render(w, side, side);
}

Picture make_satin(int side) {
    Weave w;
    w.warps = 128;
    w.wefts = 96;
    w.warp_on_top = [](int warp, int weft) { return (warp * 3 + weft) % 8 != 0; };
    const auto dye = [](double across, double along) {
        // Sheen: cloth that turns slightly towards the light, in long soft streaks, with finer ones on top.
        const double bend = 0.6 * tiled_noise2(across * 3, along * 2, 3, 2, 91);
        const double broad = 0.7 * tiled_noise2(across * 4 + bend, along * 2, 4, 2, 92) +
                             0.5 * tiled_noise2(across * 9 + bend, along * 3, 9, 3, 95);
        const double narrow = tiled_noise2(across * 23 + 2 * bend, along * 3, 23, 3, 93);
        const double thread = tiled_noise2(across * 128, along * 5, 128, 5, 94);
        const double sheen = 0.44 + 0.42 * broad + 0.17 * narrow + 0.08 * thread;
        const Colour body = mix(rgb(84, 8, 28), rgb(176, 28, 62), smooth_step(0.0, 0.62, sheen));
        return mix(body, rgb(246, 170, 182), 0.85 * smooth_step(0.52, 0.98, sheen));
    };
    w.warp_dye = [dye](int warp, double along) { return dye((warp + 0.5) / 128.0, along); };
    w.weft_dye = [dye](int weft, double along) { return dye(along, (weft + 0.5) / 96.0); };
    w.thread_width = 1.2;  // packed threads leave no gaps
    w.contrast = 0.17;
    w.fibres = 1;
    w.fuzz = 0.03;
    return render(w, side, side);
}

Picture make_striped_linen(int width, int height) {
    Weave w;
    w.wefts = height / 4 / 2 * 2;
    w.warps = width / 4 / 2 * 2;
    w.warp_on_top = plain;
    const int warps = w.warps, wefts = w.wefts;
    w.warp_dye = [warps](int warp, double along) {
        const double t = warp * 16.0 / warps, f = t - std::floor(t);
        const Colour stripe = f < 0.30               ? rgb(62, 98, 124)
                              : f > 0.42 && f < 0.48 ? rgb(186, 98, 62)
                                                     : rgb(226, 214, 190);
        return stripe * (0.92 + 0.12 * tiled_noise2(along * 9 + hash01(warp, 0, 0, 101), warp, 9, warps, 102));
    };
    w.weft_dye = [wefts](int weft, double along) {
        return rgb(222, 210, 186) * (0.92 + 0.12 * tiled_noise2(along * 18, weft, 18, wefts, 103));
    };
    w.fuzz = 0.08;
    return render(w, width, height);
}

Picture make_gingham(int width, int height) {
    Weave w;
    w.wefts = height / 4 / 2 * 2;
    w.warps = width / 4 / 2 * 2;
    w.warp_on_top = plain;
    const auto band = [](double t) {
        return static_cast<int>(std::floor(t)) % 2 == 0 ? rgb(60, 128, 116) : rgb(238, 238, 230);
    };
    const int warps = w.warps, wefts = w.wefts;
    w.warp_dye = [=](int warp, double along) {
        return band(warp * 32.0 / warps) * (0.94 + 0.06 * tiled_noise2(along * 9, warp, 9, warps, 111));
    };
    w.weft_dye = [=](int weft, double along) {
        return band(weft * 16.0 / wefts) * (0.94 + 0.06 * tiled_noise2(along * 9, weft, 9, wefts, 112));
    };
    w.fuzz = 0.06;
    return render(w, width, height);
}

}  // namespace dgm::samples
