// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/local_repair.cpp
#include "geometry/fit/local_repair.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "geometry/fit/patch_repair.h"
#include "geometry/fit/region.h"
#include "geometry/fit/search_repair.h"
#include "geometry/fit/vertex_repair.h"

namespace dgm::bake {
namespace {

constexpr double kSearchPrice = 1.5;       // in rms, of fewer inverted faces
constexpr double kRoundingPrice = 1.03;    // in rms, of faces that rounding may invert
constexpr double kLastPrice = 1.25;        // in rms, of fewer inverted faces when all else has failed: 2 dB
constexpr double kLastLargest = 1.5;       // in the largest error, likewise
constexpr double kRefitLargest = 1.02;     // largest error after refitting over before, where it is held ...
constexpr double kRefitLargestFree = 1.3;  // ... and where it is not
constexpr double kRefitGain = 2e-3;        // in rms, of two rounds, to go on

/// Some seconds. Over walls thinner than a cell a face is upright once its middle is nearer to the wall that it stands
/// for.
SearchEffort long_search(double rms, std::size_t tries) {
    // In rms, so that what is tried for one face costs no more than many others have.
    constexpr double kUnit = 10, kLeastUnit = 1e-6;
    SearchEffort out;
    constexpr std::size_t kMostInOneSearch = 400'000, kMostOfOneFace = 30'000;
    out.tries = std::min(tries, kMostInOneSearch);
    out.most_a_face = kMostOfOneFace;
    out.unit = std::max(kUnit * rms, kLeastUnit);
    out.lift = 0.5;
    return out;
}

/// Members of either of two ascending lists.
std::vector<std::uint32_t> joined(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
    std::vector<std::uint32_t> out;
    std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
    return out;
}

/// The classes that are not where they were, and a few rings around them.
Region around_moved(const WeldedGrid& grid, const std::vector<Vec3d>& before) {
    constexpr int kRings = 4;
    std::vector<char> moved(before.size(), 0);
    for (std::size_t c = 0; c < moved.size(); ++c) moved[c] = grid.surface.positions[c] != before[c];
    return grown(grid, std::move(moved), kRings);
}

}  // namespace

LocalRepair::LocalRepair(FitState& fit, std::size_t patch_effort)
    : fit_(fit), most_patch_effort_(patch_effort), patch_effort_(patch_effort) {
    constexpr std::size_t kLongTries = 800'000, kFewestLong = 40'000, kFewestShort = 10'000;
    const auto share = [&](std::size_t tries) { return tries * patch_effort / kPatchEffort; };
    short_tries_ = std::max(share(SearchEffort{}.tries), kFewestShort);
    long_tries_ = std::max(share(kLongTries), kFewestLong);
}

void LocalRepair::repair() {
    const std::vector<std::uint32_t> inverted = inverted_now();
    if (inverted.empty() || fit_.is_spent() || (unrepaired_ && without(inverted, *unrepaired_).empty())) return;
    const FitState::Kept before = fit_.kept;
    for (const bool all_means : {true, false}) {
        if (!try_means(all_means) || inverted_now().size() < inverted.size() || fit_.kept.rms <= before.rms) break;
        fit_.go_back_to(before);
    }
    unrepaired_ = inverted_now();
}

void LocalRepair::repair_nearly() {
    const FitState::Kept before = fit_.kept;
    const std::size_t inverted = fit_.inverted.faces().size();
    nearly_ = true;
    repair();
    if (fit_.kept.rms <= kRoundingPrice * before.rms || fit_.inverted.faces().size() < inverted) return;
    fit_.go_back_to(before);
}

void LocalRepair::repair_at_a_price() {
    constexpr int kAttempts = 6;
    nearly_ = true;
    means_ = Means::kLongSearch;
    for (int attempt = 0; attempt < kAttempts && !fit_.is_spent(); ++attempt) {
        const std::size_t inverted = fit_.inverted.faces().size();
        if (inverted == 0 || inverted > kMostAtAPrice) return;
        const FitState::Kept before = fit_.kept;
        patch_effort_ = most_patch_effort_;
        const bool moved = try_means(false);
        const bool cheap =
            fit_.kept.rms <= kLastPrice * before.rms && fit_.kept.largest <= kLastLargest * before.largest;
        if (moved && cheap && fit_.inverted.faces().size() < inverted) continue;
        if (moved) fit_.go_back_to(before);
        if (means_ == Means::kDearPlaces) return;
        means_ = means_ == Means::kLongSearch ? Means::kDearPatches : Means::kDearPlaces;
    }
}

/// Walks end in local minima; the last faces to repair are those that the measure finds. The samples that had to move
/// are fitted again, as long as nothing inverts.
/// @param all_means  also those that do not count the faces they invert
/// @return  true if something moved
bool LocalRepair::try_means(bool all_means) {
    constexpr int kSearches = 3;
    const std::vector<Vec3d> before = fit_.grid.surface.positions;
    bool moved = all_means && move_vertices(), patches_moved = false;
    if (moved) fit_.matches.update(false);
    for (int round = 0; round < kSearches && !fit_.is_spent(); ++round) {
        if (move_patches()) moved = patches_moved = true;
        const std::vector<std::uint32_t> left = inverted_now();
        if (left.empty() || !search_places(left)) break;
        moved = true;
    }
    if (!moved) return false;
    fit_.matches.update(fit_.holds_largest);
    fit_.keep();
    refit_around(before, patches_moved);
    return true;
}

/// @return  true if a sample moved
bool LocalRepair::move_vertices() {
    constexpr int kPasses = 10;
    const ClosestPointIndex& index = fit_.inverted.source_index();
    bool moved = repair_by_vertex(fit_.source, fit_.grid, fit_.matches, fit_.fixed, kEndUpright);
    for (int pass = 0; pass < kPasses && !fit_.is_spent(); ++pass) {
        const std::vector<std::uint32_t> inverted = inverted_now();
        for (const std::uint32_t f : inverted) {
            Match& middle = fit_.matches.middles[f];
            if (const ClosestPoint hit = index.query(middle.position); hit.face != kNone) middle.hit.face = hit.face;
        }
        if (inverted.empty()) break;
        if (!fit_.flip_quads(inverted, false) &&
            !repair_by_vertex(fit_.source, fit_.grid, fit_.matches, fit_.fixed, inverted))
            break;
        moved = true;
    }
    return moved;
}

/// @return  true if a sample moved
bool LocalRepair::move_patches() {
    const std::vector<std::uint32_t> left = inverted_now();
    if (left.empty() ||
        !repair_by_patch(fit_.source, fit_.inverted.source_index(), fit_.upward, fit_.grid, fit_.matches, fit_.fixed,
                         left, patch_effort_, is_at_a_price() ? kAnyPatch : PatchAllowance{}))
        return false;
    fit_.matches.update(false);
    return true;
}

/// The classes on the border; at a price only those that are no corners of inverted faces. The ears of a jagged border
/// have no others.
std::vector<char> LocalRepair::held_while_searching(const std::vector<std::uint32_t>& left) const {
    std::vector<char> out = fit_.fixed;
    if (is_at_a_price())
        for (const std::uint32_t f : left)
            for (const std::uint32_t c : fit_.grid.surface.faces[f]) out[c] = 0;
    return out;
}

SearchEffort LocalRepair::search_effort() const {
    if (!is_at_a_price()) return {.tries = short_tries_};
    SearchEffort out = long_search(fit_.kept.rms, long_tries_);
    if (means_ == Means::kDearPlaces) out.unit = SearchEffort{}.unit;
    return out;
}

/// Undone where it repairs no face, or makes the others pay too much for it.
/// @return  true if fewer are left
bool LocalRepair::search_places(const std::vector<std::uint32_t>& left) {
    const std::vector<Vec3d> positions = fit_.grid.surface.positions;
    const std::vector<std::uint8_t> diagonals = fit_.chart.diagonals;
    SearchEffort effort = search_effort();
    const std::size_t tries = effort.tries;
    const bool found = repair_by_search(fit_.source, fit_.inverted.source_index(), fit_.grid, fit_.matches,
                                        held_while_searching(left), left, effort);
    if (is_at_a_price()) long_tries_ -= tries - effort.tries;
    if (!found) return false;
    if (!fit_.flip_quads(inverted_now(), true)) fit_.matches.update(false);
    const bool cheap = is_at_a_price() || fit_.matches.rms <= kSearchPrice * fit_.kept.rms;
    if (cheap && inverted_now().size() < left.size()) return true;
    fit_.grid.surface.positions = positions;
    fit_.chart.diagonals = diagonals;
    fit_.relink();
    fit_.matches.update(false);
    return false;
}

/// Fits the neighbourhood of the classes that moved, while all others are held. Faces that invert again in a round have
/// theirs held in the next.
void LocalRepair::refit_around(const std::vector<Vec3d>& before, bool patches_moved) {
    const int rounds = patches_moved || is_at_a_price() ? 8 : fit_.holds_largest ? 6 : 2;
    const Region near = around_moved(fit_.grid, before);
    std::vector<Freedom> freedom(before.size(), Freedom::kHeld);
    for (std::size_t c = 0; c < freedom.size(); ++c)
        if (near.classes[c] && !fit_.fixed[c]) freedom[c] = Freedom::kFree;
    const std::vector<std::uint32_t> left = fit_.inverted.faces(near.faces, nearly_);
    std::vector<char> held(before.size(), 0);
    const double limit = (fit_.holds_largest ? kRefitLargest : kRefitLargestFree) * fit_.kept.largest;
    const auto fresh = [&] {
        return without(joined(fit_.inverted.faces(near.faces, nearly_), fit_.matches.faces_beyond(limit)), left);
    };
    double gained = 1, gained_before = 1;
    for (int round = 0; round < rounds && gained + gained_before > kRefitGain && !fit_.is_spent(); ++round) {
        gained_before = gained;
        fit_.equations.clear();
        fit_.rows.assemble(fit_.equations, round % 2 == 1, near.faces);
        fit_.sliding.take(fit_.equations.solve(freedom, {}, fit_.damping, kCgIterations), {});
        fit_.matches.update(fit_.holds_largest, near.faces);
        const bool sound = fit_.take_back(fit_.kept.positions, fresh, held);
        gained = sound ? std::max(0.0, 1 - fit_.matches.rms / fit_.kept.rms) : 0;
        if (gained > 0) {
            fit_.keep();
        } else {
            fit_.grid.surface.positions = fit_.kept.positions;
            fit_.grid.surface.update_normals();
            fit_.matches.update(fit_.holds_largest, near.faces);
        }
        // What has inverted is held in the next round.
        if (!sound && is_at_a_price()) gained = 2 * kRefitGain;
        for (std::size_t c = 0; c < held.size(); ++c)
            if (held[c]) freedom[c] = Freedom::kHeld;
    }
}

}  // namespace dgm::bake
