// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/search_repair.cpp
#include "geometry/fit/search_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "geometry/fit/cover.h"
#include "geometry/fit/inverted_faces.h"
#include "geometry/mesh/infinity.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr int kPasses = 10, kPlainPasses = 3;
constexpr std::array<double, kPlainPasses> kLiftShares{0.1, 0.3, 1};  // of the most, by pass
constexpr std::size_t kTries = 120;                                   // places an inverted face, in one pass
constexpr double kHeat = 0.4;             // price that a try may cost when an annealing begins
constexpr std::size_t kMostFaces = 1000;  // with more, the source has no distinct sides (slivers, folds onto itself)
constexpr double kInverted = 2;           // price of an inverted face, more the further it is inverted
constexpr double kWanted = 0.15;          // cosine from which a face counts as upright
constexpr double kOff = 0.5;              // price of a face whose middle is a unit away from the source
constexpr double kCover = 3;              // price of a source vertex a unit away from the faces that covered it
constexpr double kThinnest = 0.01, kThin = 0.2;  // twice the area over the longest edge squared, and its price
constexpr double kLeastGain = 1e-4;

/// Of one annealing, where `made` were made and so many annealings may follow. A few faces may have more than many, and
/// leave half of the effort to what comes after them.
std::size_t tries_a_face(const SearchEffort& effort, std::size_t made, std::size_t annealings) {
    const std::size_t left = made < effort.tries ? effort.tries - made : 0;
    return std::clamp(left / (2 * annealings), SearchEffort{}.most_a_face, effort.most_a_face);
}

/// After a share of an annealing's tries.
double heat_after(double share) {
    const double left = 1 - share;
    return kHeat * (left * left);
}

class SearchRepair {
 public:
    SearchRepair(const LinkedSurface& source, const ClosestPointIndex& index, WeldedGrid& grid, Matches& matches,
                 std::span<const char> fixed, const SearchEffort& effort)
        : source_(source),
          index_(index),
          grid_(grid.surface),
          matches_(matches),
          fixed_(fixed),
          effort_(effort),
          rings_(grid.rings()),
          squared_spacing_(surface_area(source) / static_cast<double>(grid.surface.positions.size())),
          squared_unit_(std::min(squared_spacing_, effort.unit * effort.unit)),
          cover_(matches, grid_.faces.size()),
          price_(grid_.faces.size(), {std::numeric_limits<double>::quiet_NaN(), false}) {}

    bool run(std::span<const std::uint32_t> inverted) {
        std::vector<std::uint32_t> left(inverted.begin(), inverted.end());
        bool moved = false;
        for (int pass = 0; pass < kPasses && !left.empty() && has_effort(); ++pass) {
            lift_ = effort_.lift * kLiftShares[static_cast<std::size_t>(std::min(pass, kPlainPasses - 1))];
            reached_.clear();
            heated_tries_ = tries_a_face(effort_, tries_, left.size() * static_cast<std::size_t>(kPasses - pass));
            for (const std::uint32_t f : left) moved = (pass < kPlainPasses ? mend(f) : anneal(f)) || moved;
            left.insert(left.end(), reached_.begin(), reached_.end());
            std::sort(left.begin(), left.end());
            left.erase(std::unique(left.begin(), left.end()), left.end());
            std::erase_if(left, [&](std::uint32_t f) { return !judge(f).inverted; });
        }
        return moved;
    }

    [[nodiscard]] std::uint64_t looked() const { return looked_; }
    [[nodiscard]] std::size_t tries() const { return tries_; }

 private:
    [[nodiscard]] bool has_effort() const { return tries_ < effort_.tries && looked_ < Matches::kMostLooksOfRepair; }

    struct Price {
        double value;
        bool inverted;
    };

    [[nodiscard]] std::span<const std::uint32_t> ring(std::uint32_t c) const {
        return std::span(rings_.faces).subspan(rings_.first[c], rings_.first[c + 1] - rings_.first[c]);
    }

    /// Price of a face in its present place, from memory if it has not moved.
    const Price& judge(std::uint32_t f) {
        if (std::isnan(price_[f].value)) price_[f] = measure(f);
        return price_[f];
    }

    [[nodiscard]] Price measure(std::uint32_t f) const {
        const auto q = grid_.corners(f);
        const Vec3d area = cross(q[1] - q[0], q[2] - q[0]), centre = (q[0] + q[1] + q[2]) / 3;
        Vec3d normal = normalized(area, Vec3d{});
        if (normal == Vec3d{}) return {2 * kInverted, true};
        const ClosestPoint any = index_.query(centre, matches_.middles[f].hit.face);
        if (any.face == kNone) return {2 * kInverted, true};
        if (!grid_.either_side.empty() && grid_.either_side[f] && dot(index_.unit_normal(any.face), normal) < 0)
            normal = -normal;
        const double cosine = dot(index_.unit_normal(any.face), normal);
        bool inverted = false;
        if (!(cosine > kSafeCosine)) {
            const double limit = any.distance + kSafeTie * index_.diagonal();
            const ClosestPoint facing = index_.query_facing(centre, normal, kSafeCosine, any.face, limit);
            inverted = facing.face == kNone || facing.distance > limit;
        }
        const double longest = std::sqrt(longest_edge_squared(q));
        inverted = inverted || is_flat(q);
        const double thin = length(area) / (longest * longest);
        return {(inverted ? kInverted - cosine : std::max(0.0, kWanted - std::max(cosine, 0.0))) +
                    kThin * std::max(0.0, 1 - thin / kThinnest) +
                    kOff * std::min(4.0, any.distance * any.distance / squared_unit_),
                inverted};
    }

    /// Price of some faces; of a part of them that is too dear, if there is: no price is negative.
    /// @param is_too_dear  of a price; true for all greater ones, too
    template <class IsTooDear>
    [[nodiscard]] double total(std::span<const std::uint32_t> faces, const IsTooDear& is_too_dear) {
        const auto price = [&](double squared) { return kCover * squared / squared_unit_; };
        double sum = price(cover_.farthest(grid_, faces, [&](double squared) { return is_too_dear(price(squared)); }));
        for (std::size_t k = 0; k < faces.size() && !is_too_dear(sum); ++k) sum += judge(faces[k]).value;
        return sum;
    }

    [[nodiscard]] double uniform() { return static_cast<double>(random_()) / 4294967296.0; }
    [[nodiscard]] std::uint32_t below(std::size_t count) {
        return static_cast<std::uint32_t>(uniform() * static_cast<double>(count));
    }

    struct Place {
        Vec3d position;
        SurfaceHit hit;
    };

    /// Above the place of class c, to the side that one of its faces looks to; nearer places more often.
    [[nodiscard]] Place place_above(std::uint32_t c) {
        const auto q = grid_.corners(ring(c)[below(ring(c).size())]);
        const Vec3d up = normalized(cross(q[1] - q[0], q[2] - q[0]), Vec3d{});
        const double share = uniform(), way = lift_ * std::sqrt(squared_spacing_) * (share * share);
        const Vec3d to = grid_.positions[c] + up * way;
        return {to, walk_to_closest(source_, to, matches_.classes[c].hit.face, &looked_)};
    }

    /// Some place about class c, as far as the rim of its ring and a little beyond, on the source or on the grid.
    [[nodiscard]] Place place_about(std::uint32_t c) {
        constexpr std::uint32_t kLifted = 3;  // one try in so many
        if (effort_.lift > 0 && below(kLifted) == 0) return place_above(c);
        constexpr double kBeyond = 1.3;
        const auto q = grid_.corners(ring(c)[below(ring(c).size())]);
        double a = uniform(), b = uniform();
        if (a + b > 1) {
            a = 1 - a;
            b = 1 - b;
        }
        const Vec3d on_ring = q[0] * (1 - a - b) + q[1] * a + q[2] * b, at = grid_.positions[c];
        const Vec3d to = at + (on_ring - at) * (kBeyond * uniform());
        // The nearest of all may be another sheet, and a walk may end on this one's wrong side: by turns. Where the
        // source itself folds within a spacing, neither helps.
        const std::uint32_t kind = below(5);
        if (kind >= 3)
            if (const ClosestPoint hit = index_.query(to, matches_.classes[c].hit.face); hit.face != kNone) {
                const auto& w = hit.barycentric;
                return {hit.point, {hit.face, 0, {w[0], w[1], w[2]}}};
            }
        const SurfaceHit hit = walk_to_closest(source_, to, matches_.classes[c].hit.face, &looked_);
        return {kind == 0 ? to : point_at(source_, hit), hit};
    }

    /// One try: class c goes elsewhere, and `with`, if any, by the same way, if that costs no more than `allowed`.
    bool attempt(std::uint32_t c, std::uint32_t with, double allowed) {
        ++tries_;
        const std::array<std::uint32_t, 2> moving{c, with};
        const std::size_t count = with == kNone ? 1 : 2;
        std::array<Place, 2> old, fresh;
        fresh[0] = place_about(c);
        affected_.clear();
        for (std::size_t k = 0; k < count; ++k) {
            old[k] = {grid_.positions[moving[k]], matches_.classes[moving[k]].hit};
            affected_.insert(affected_.end(), ring(moving[k]).begin(), ring(moving[k]).end());
        }
        if (count == 2) {
            const Vec3d to = old[1].position + fresh[0].position - old[0].position;
            fresh[1].hit = walk_to_closest(source_, to, old[1].hit.face, &looked_);
            fresh[1].position = point_at(source_, fresh[1].hit);
            std::sort(affected_.begin(), affected_.end());
            affected_.erase(std::unique(affected_.begin(), affected_.end()), affected_.end());
        }
        const double before = total(affected_, [](double) { return false; });
        known_.clear();
        for (const std::uint32_t f : affected_) {
            known_.push_back(price_[f]);
            forget(f);
        }
        for (std::size_t k = 0; k < count; ++k) grid_.positions[moving[k]] = fresh[k].position;
        const double after = total(affected_, [&](double price) { return !(price - before < allowed); });
        if (const double change = after - before; change < allowed) {
            change_ += change;
            for (std::size_t k = 0; k < count; ++k) {
                log_.push_back({moving[k], old[k]});
                matches_.classes[moving[k]].position = fresh[k].position;
                matches_.classes[moving[k]].hit = fresh[k].hit;
            }
            for (const std::uint32_t f : affected_) {
                grid_.update_normal(f);
                matches_.update_middle(f);
                if (judge(f).inverted) reached_.push_back(f);
            }
            return true;
        }
        for (std::size_t k = 0; k < count; ++k) grid_.positions[moving[k]] = old[k].position;
        for (std::size_t k = 0; k < affected_.size(); ++k) price_[affected_[k]] = known_[k];
        return false;
    }

    void forget(std::uint32_t f) { price_[f].value = std::numeric_limits<double>::quiet_NaN(); }

    bool attempt_about(std::uint32_t face, std::size_t k, double allowed) {
        const Face& own = grid_.faces[face];
        std::uint32_t c = own[below(3)], with = kNone;
        if (k % 3 == 1) {  // makes room beside it
            const Face& near = grid_.faces[ring(c)[below(ring(c).size())]];
            c = near[below(3)];
        } else if (k % 3 == 2) {
            with = own[below(3)];
            if (with == c || fixed_[with]) with = kNone;
        }
        return !fixed_[c] && attempt(c, with, allowed);
    }

    bool mend(std::uint32_t face) {
        bool moved = false;
        for (std::size_t k = 0; k < kTries && has_effort() && judge(face).inverted; ++k)
            moved = attempt_about(face, k, -kLeastGain) || moved;
        return moved;
    }

    /// Steps that cost something, ever less of it; all are taken back unless they paid in the end.
    bool anneal(std::uint32_t face) {
        if (!judge(face).inverted) return false;
        log_.clear();
        change_ = 0;
        for (std::size_t k = 0; k < heated_tries_ && has_effort(); ++k) {
            const double heat = heat_after(static_cast<double>(k) / static_cast<double>(heated_tries_));
            attempt_about(face, k, -kLeastGain - heat * math::log(std::max(uniform(), 1e-9)));
            if (change_ < -0.5 * kInverted && !judge(face).inverted) break;
        }
        if (change_ < -0.5 * kInverted) return true;  // a face less
        for (std::size_t k = log_.size(); k-- > 0;) {
            const std::uint32_t c = log_[k].c;
            grid_.positions[c] = matches_.classes[c].position = log_[k].before.position;
            matches_.classes[c].hit = log_[k].before.hit;
            for (const std::uint32_t f : ring(c)) forget(f);
        }
        for (const Step& step : log_)
            for (const std::uint32_t f : ring(step.c)) {
                grid_.update_normal(f);
                matches_.update_middle(f);
            }
        return false;
    }

    const LinkedSurface& source_;
    const ClosestPointIndex& index_;
    LinkedSurface& grid_;
    Matches& matches_;
    std::span<const char> fixed_;
    SearchEffort effort_;
    double lift_ = 0;  // in this pass
    WeldedGrid::Rings rings_;
    double squared_spacing_;
    double squared_unit_;  // of the distances that are paid for
    Cover cover_;
    std::vector<Price> price_;  // per face; NaN: not known
    std::mt19937 random_{1};    // the same places each time
    std::vector<std::uint32_t> affected_, reached_;
    std::vector<Price> known_;
    struct Step {
        std::uint32_t c;
        Place before;
    };
    std::vector<Step> log_;
    std::size_t heated_tries_ = 0;  // places an inverted face, in one annealing of this pass
    double change_ = 0;             // of the price, by the steps of the log
    std::size_t tries_ = 0;
    std::uint64_t looked_ = 0;  // faces that walks looked at
};

}  // namespace

bool repair_by_search(const LinkedSurface& source, const ClosestPointIndex& index, WeldedGrid& grid, Matches& matches,
                      std::span<const char> fixed, std::span<const std::uint32_t> inverted, SearchEffort& effort) {
    if (inverted.size() > kMostFaces) return false;
    SearchRepair repair(source, index, grid, matches, fixed, effort);
    const bool moved = repair.run(inverted);
    effort.tries -= std::min(effort.tries, repair.tries());
    matches.count_looks(repair.looked());
    return moved;
}

}  // namespace dgm::bake
