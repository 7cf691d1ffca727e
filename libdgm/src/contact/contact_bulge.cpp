// SPDX-License-Identifier: MIT
// libdgm/src/contact/contact_bulge.cpp
// The volume kept as in docs/methods.md section 6.
//
// x' is the shape after projecting Phi, b_i = w_i n_i the bulge of Psi. The volume of x' + beta b is a cubic in beta.
// Samples that this takes beyond the obstacle are put back on it, and the volume that costs grows about as a power of
// beta: its coefficient and exponent are found by measuring the bulged volume. Most of the ring is too far from the
// obstacle for that to happen; there the cubic holds, and only the rest is moved and measured again at every step, all
// of it at the last. The error that rounding to float leaves is put on a few samples one after another: the volume is
// linear in each.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/portable_math.h"
#include "contact/contact_resolver.h"

namespace dgm::detail {
namespace {
// Shares of the removed volume. From an error of kForeseen the next step is good to some 1e-5, which a few samples can
// take.
constexpr double kForeseen = 4e-3, kSolved = 3e-4;
constexpr std::uint32_t kMaxPasses = 10;
constexpr double kPower = 1.8;  // of beta, to which the volume put back grows, before it is measured
}  // namespace

void Resolver::weigh() noexcept {
    const float slope = report_.ring_reach * report_.ring_reach / report_.ring_sigma;
    WeightJob job{};
    job.cols = s_.tables.cols;
    job.square = c_.spread ? c_.weight.data() : c_.square.data();
    job.mobility = s_.mobility.empty() ? nullptr : s_.mobility.data();
    job.weight = c_.weight.data();
    job.factor = 1 / report_.ring_sigma;
    job.limit = std::min(report_.ring_reach * report_.ring_reach, 64 * report_.ring_sigma);
    job.slope = slope;
    // A kernel that is flat up to R has no compact form to speak of.
    job.end = o_.bulge == Bulge::Exact && slope > 0.25f ? portable_exp(-slope) : 0.0f;
    const auto add = [&](const WeightSums& sums) {
        report_.ring += sums.count;
        weights_ += sums.total;
        return sums.largest;
    };
    for (std::uint32_t k = 0; k < c_.tile_count; ++k) {
        if ((c_.tile_bits[c_.tiles[k]] & kTilePsi) == 0) continue;
        job.rect = c_.rects[c_.tiles[k]];
        c_.tile_top[c_.tiles[k]] = add(c_.rows_of->weights(job));
    }
    if (!c_.border) return;
    job.rect = {0, 0, 0, 0};
    job.cols = 0;
    for (std::uint32_t k = s_.tables.grid; k < s_.total(); ++k) {
        job.square = c_.square.data() + k;
        job.weight = c_.weight.data() + k;
        const float m = mobility_of(s_, k);
        job.mobility = &m;
        add(c_.rows_of->weights(job));
    }
}

double Resolver::swept(const Rect& r) const noexcept {
    const QuadJob job = quad_job(r);
    if (job.rect.empty()) return 0;
    return c_.rows_of->swept(job, StateImpl::fixed(c_.before()), c_.marks.data(), c_.weight.data());
}

double Resolver::swept(const Runs& runs) const noexcept {
    double six = 0;
    for (const Rect& r : runs) six += swept(r);
    return six;
}

void Resolver::add_face(const Face& f, double* c) noexcept {
    const Double3 e = f.at[1] - f.at[0], g = f.at[2] - f.at[0], be = f.by[1] - f.by[0], bg = f.by[2] - f.by[0];
    const Double3 by = f.by[0] + f.by[1] + f.by[2];
    c[0] += dot(by, cross(e, g));
    c[1] += dot(by, cross(e, bg) + cross(be, g)) / 2;
    c[2] += dot(by, cross(be, bg)) / 3;
}

double Resolver::swept_faces() const noexcept {
    double c[3] = {0, 0, 0};
    for (std::size_t k = 0; k + 2 < s_.faces.size(); k += 3) {
        Face f;
        for (std::size_t a = 0; a < 3; ++a) {
            const std::uint32_t sample = s_.faces[k + a];
            const Double3 now = widen(s_.point(sample));
            const bool moves = (c_.marks[sample] & kInside) != 0 || c_.weight[sample] > 0;  // the others are not saved
            f.at[a] = moves ? widen(StateImpl::at(c_.before(), sample)) : now;
            f.by[a] = now - f.at[a];
        }
        add_face(f, c);
    }
    return c[0] + c[1] + c[2];
}

void Resolver::cubic(const Runs& runs, double* c) const noexcept {
    for (const Rect& r : runs) {
        const QuadJob job = quad_job(r);
        if (!job.rect.empty()) c_.rows_of->cubic(job, StateImpl::fixed(s_.normal), c_.weight.data(), c);
    }
}

void Resolver::cubic_faces(double* c) const noexcept {
    for (std::size_t k = 0; k + 2 < s_.faces.size(); k += 3) {
        Face f;
        for (std::size_t a = 0; a < 3; ++a) {
            const std::uint32_t sample = s_.faces[k + a];
            f.at[a] = widen(s_.point(sample));
            f.by[a] = double{c_.weight[sample]} * widen(StateImpl::at(s_.normal, sample));
        }
        add_face(f, c);
    }
}

double Resolver::held_back(const Rect& r, double beta) const noexcept {
    HoldJob job{};
    job.normal = StateImpl::fixed(s_.normal);
    job.weight = c_.weight.data();
    job.beta = static_cast<float>(beta);
    job.n[0] = static_cast<float>(shape_.normal.x);
    job.n[1] = static_cast<float>(shape_.normal.y);
    job.n[2] = static_cast<float>(shape_.normal.z);
    job.d = static_cast<float>(shape_.offset);
    const QuadJob quads = quad_job(r);
    return quads.rect.empty() ? 0 : c_.rows_of->held_back(quads, job);
}

double Resolver::held_back(double beta) const noexcept {
    double six = 0;
    for (const Rect& r : c_.inner) six += held_back(r, beta);
    return six;
}

void Resolver::part_ring() noexcept {
    // More than an even contact needs; should it need more still, the last measurement shows it. Border faces are
    // measured at every step, with all their corners.
    highest_ = s_.faces.empty() ? 1.6 * std::fabs(removed_) / 6 * report_.samples / (area_ * weights_)
                                : std::numeric_limits<double>::infinity();
    for (std::uint32_t e = 0, listed = c_.tile_count; e < listed; ++e) {
        const std::uint32_t tile = c_.tiles[e], ti = tile / s_.tile_cols, tj = tile % s_.tile_cols;
        // Volume that quads gained by sinking is measured together with their gain by bulging.
        constexpr std::uint8_t kBoth = kTileSinking | kTileBulging;
        if ((c_.tile_bits[tile] & kBoth) == kBoth) c_.tile_bits[tile] |= kTileNear;
        if ((c_.tile_bits[tile] & kTilePsi) == 0) continue;
        const double reach = highest_ * double{c_.tile_top[tile]};
        if ((c_.tile_bits[tile] & kTilePhi) == 0 && box_distance(shape_, s_.now_boxes.boxes[tile]) > reach) continue;
        for (std::uint32_t i = ti == 0 ? 0 : ti - 1; i <= ti; ++i)
            for (std::uint32_t j = tj == 0 ? 0 : tj - 1; j <= tj; ++j) c_.tile_bits[i * s_.tile_cols + j] |= kTileNear;
    }
    for (std::uint32_t e = 0; foreseen() && e < c_.tile_count; ++e) {
        std::uint8_t& bits = c_.tile_bits[c_.tiles[e]];
        if ((bits & (kTileBulging | kTileNear)) != (kTileBulging | kTileNear)) continue;
        const double held = held_back(c_.rects[c_.tiles[e]], std::copysign(highest_, removed_));
        held_ += held;
        // Nothing is held back of a lower bulge either.
        if (held != 0)
            bits |= kTileHeld;
        else if ((bits & kTileSinking) == 0)
            bits &= static_cast<std::uint8_t>(~kTileNear);
    }
    collect(c_.near, kTileBulging | kTileNear, kTileBulging | kTileNear);
    collect(c_.ring, kTileBulging | kTileNear, kTileBulging);
    if (foreseen()) collect(c_.inner, kTileHeld, kTileHeld);  // measured, and not asked for again
    if (shape_.kind == ObstacleKind::Plane) return;
    // From here on: heights over the obstacle, where they have been computed.
    heights_ = true;
    for (std::uint32_t e = 0; e < c_.tile_count; ++e)
        if ((c_.tile_bits[c_.tiles[e]] & kTilePsi) != 0)
            each_sample(c_.tiles[e], [&](std::uint32_t k) { c_.square[k] = __builtin_inff(); });
    std::fill(c_.square.begin() + s_.tables.grid, c_.square.end(), __builtin_inff());
}

bool Resolver::falls_in(std::uint32_t k, double beta, Vec3 bulged, Probe& there) noexcept {
    if (!(c_.weight[k] > 0)) return false;
    // How far it was before: a bulge lower than that cannot reach the obstacle.
    float& height = c_.square[k];
    const double rise = (1 + 1e-5) * std::fabs(beta) * double{c_.weight[k]};
    if (height == __builtin_inff()) {
        const Double3 before = widen(StateImpl::at(c_.before(), k));
        if (around_.clearance(shape_, before) > rise) return false;
        const double distance = probe(shape_, before).distance;
        around_.note(before, distance);
        height = static_cast<float>(distance);
    }
    if (double{height} > rise + 1e-6 * std::fabs(double{height})) return false;
    there = probe(shape_, widen(bulged));
    return there.distance < 0;
}

void Resolver::put_back_sample(std::uint32_t k, double beta) noexcept {
    Probe there;
    if (c_.in_class[k] == 0 && falls_in(k, beta, s_.point(k), there)) put(k, there.nearest);
}

void Resolver::put_back_tile(std::uint32_t tile, double beta) noexcept {
    if (is_round()) return c_.rows_of->put_back(mark_job(c_.rects[tile]), c_.weight.data(), s_.now);
    each_sample(tile, [&](std::uint32_t k) { put_back_sample(k, beta); });
}

// Tiles of copies may differ in whether they are near; their heights may be computed from different places. So one copy
// is measured for all, and it does not matter whether the loops have bulged it.
void Resolver::put_back_classes(double beta) noexcept {
    for (std::uint32_t e = 0; e < class_count_; ++e) {
        const std::uint32_t k = c_.source[e];
        const float step = c_.weight[k] * static_cast<float>(beta);
        Vec3 to = StateImpl::at(c_.before(), k) + step * StateImpl::at(s_.normal, k);
        Probe there;
        if (falls_in(k, beta, to, there)) to = narrow(there.nearest);
        for (const std::uint32_t copy : s_.members(s_.class_id(k))) put(copy, widen(to));
    }
}

void Resolver::list_classes() noexcept {
    class_count_ = 0;
    if (s_.class_count == 0 || shape_.kind == ObstacleKind::Plane) return;
    const auto list = [&](std::uint32_t k) {
        if (c_.weight[k] > 0 && s_.class_id(k) != kNone && s_.representative(k) == k) c_.source[class_count_++] = k;
    };
    for (std::uint32_t e = 0; e < c_.tile_count; ++e)
        if ((c_.tile_bits[c_.tiles[e]] & kTilePsi) != 0 && (s_.tile_flags[c_.tiles[e]] & kTileSpecial) != 0)
            each_sample(c_.tiles[e], list);
    if (c_.border)
        for (std::uint32_t k = s_.tables.grid; k < s_.total(); ++k) list(k);
}

BulgeJob Resolver::bulge_job(double beta) const noexcept {
    BulgeJob job{};
    job.cols = s_.tables.cols;
    job.from = StateImpl::fixed(c_.before());
    job.normal = StateImpl::fixed(s_.normal);
    job.to = s_.now;
    job.weight = c_.weight.data();
    job.beta = static_cast<float>(beta);
    job.clamp = o_.bulge == Bulge::Exact && shape_.kind == ObstacleKind::Plane;
    job.n[0] = static_cast<float>(shape_.normal.x);
    job.n[1] = static_cast<float>(shape_.normal.y);
    job.n[2] = static_cast<float>(shape_.normal.z);
    job.d = static_cast<float>(shape_.offset);
    return job;
}

void Resolver::apply(const Runs& runs, double beta) noexcept {
    const bool clamp = o_.bulge == Bulge::Exact;
    BulgeJob job = bulge_job(beta);
    for (const Rect& r : runs) {
        job.rect = with_corners(r);
        c_.rows_of->bulge(job);
    }
    if (c_.border && s_.total() > s_.tables.grid) {
        job.rect = {0, 0, s_.tables.grid, s_.total() - 1};
        job.cols = 0;
        c_.rows_of->bulge(job);
    }
    if (!clamp || shape_.kind == ObstacleKind::Plane) return;
    const bool all = &runs != &c_.near;
    for (std::uint32_t e = 0; e < c_.tile_count; ++e) {
        const std::uint32_t tile = c_.tiles[e];
        if ((c_.tile_bits[tile] & kTilePsi) == 0) continue;
        const bool near = (c_.tile_bits[tile] & kTileNear) != 0;
        if (near == all) continue;
        // For a surface the box costs a search, and most of its samples know their heights.
        const bool asked = near && searches();
        if (asked || box_distance(shape_, s_.now_boxes.boxes[tile]) < std::fabs(beta) * double{c_.tile_top[tile]})
            put_back_tile(tile, beta);
    }
    if (c_.border && !all)
        for (std::uint32_t k = s_.tables.grid; k < s_.total(); ++k) put_back_sample(k, beta);
    put_back_classes(beta);
}

namespace {
/// Where cubic(b) - cost (b / at)^power = aim, from b = at.
double solve(const Cubic& cubic, double aim, double cost, double at, double power) noexcept {
    double b = at;
    for (int k = 0; k < 12; ++k) {
        const double lost = cost == 0 ? 0 : cost * portable_pow(b / at, power);
        const double next = b - (cubic(b) - lost - aim) / (cubic.slope(b) - power * lost / b);
        if (!std::isfinite(next) || !(next * at > 0)) break;
        const bool done = std::fabs(next - b) <= 1e-13 * std::fabs(next);
        b = next;
        if (done) break;
    }
    return b;
}
}  // namespace

double Resolver::settle(double beta) noexcept {
    double error = sunk_;
    if (s_.faces.empty() && (shape_.kind == ObstacleKind::Plane || o_.bulge == Bulge::Paper)) {
        // Nothing is left to put back: each run is measured while it is at hand.
        BulgeJob job = bulge_job(beta);
        for (const Runs* runs : {&c_.near, &c_.ring})
            for (const Rect& r : *runs) {
                job.rect = with_corners(r);
                c_.rows_of->bulge(job);
                error += swept(r);
            }
    } else {
        apply(c_.near, beta);
        apply(c_.ring, beta);
        error += swept(c_.near) + swept(c_.ring) + swept_faces();
    }
    ++report_.passes;
    report_.beta = static_cast<float>(beta);
    report_.volume_error = error / removed_;
    return error;
}

namespace {
/// Heights beta of the bulge and the errors of the volume they leave. The volume grows with |beta|: steps stay between
/// the largest height known to be too low and the lowest known to be too high.
class HeightSearch {
 public:
    /// `first`: beta to first order; `beta`: where the search begins.
    HeightSearch(const Cubic& volume, double removed, double first, double beta) noexcept
        : volume_(volume), removed_(removed), first_(first), best_(beta) {}

    /// @return |beta| to try next, after an error at beta was measured; 0 if there is none.
    double next(double beta, double error) noexcept {
        if (std::fabs(error) < best_error_) {
            best_ = beta;
            best_error_ = std::fabs(error);
        }
        (sign() * error * first_ > 0 ? high_ : low_) = std::fabs(beta);
        const double cost = volume_(beta) - removed_ - error;
        fit_power(beta, cost);
        older_ = beta;
        older_cost_ = cost;
        double next = std::fabs(solve(volume_, removed_, cost, beta, power_));
        if (std::isinf(high_)) next = std::min(next, 2 * low_);  // NaN stays
        if (!(next > low_ && next < high_)) next = std::isinf(high_) ? 2 * low_ : 0.5 * (low_ + high_);
        return next > 64 * std::fabs(first_) || next == std::fabs(beta) ? 0 : next;
    }
    /// Earlier measurements took other samples to be near.
    void restart() noexcept {
        low_ = 0;
        high_ = best_error_ = std::numeric_limits<double>::infinity();
    }
    [[nodiscard]] double best() const noexcept { return best_; }
    [[nodiscard]] double best_error() const noexcept { return best_error_; }

 private:
    /// Sign of the error where |beta| is too high, times the sign of beta.
    [[nodiscard]] double sign() const noexcept { return removed_ * first_ > 0 ? 1 : -1; }
    void fit_power(double beta, double cost) noexcept {
        if (older_ == 0 || !(cost * older_cost_ > 0) || older_ == beta) return;
        const double fitted = portable_log(cost / older_cost_) / portable_log(beta / older_);
        if (fitted > 0 && fitted < 8) power_ = fitted;
    }

    const Cubic& volume_;
    const double removed_, first_;
    double low_ = 0, high_ = std::numeric_limits<double>::infinity();
    double older_ = 0, older_cost_ = 0, power_ = kPower;
    double best_, best_error_ = std::numeric_limits<double>::infinity();
};
}  // namespace

double Resolver::first_height(const Cubic& volume, double first) const noexcept {
    double beta = solve(volume, removed_, 0, first, 0);
    // A ring too small for the removed volume may have no root near by: then the gradient's answer and its error count.
    if (!(beta * first > 0) || std::fabs(beta) > 4 * std::fabs(first)) beta = first;
    if (held_ == 0) return beta;
    const double next = solve(volume, removed_, held_, std::copysign(highest_, first), kPower);
    return next * first > 0 && std::fabs(next) < highest_ ? next : beta;
}

double Resolver::measure_near(double beta, const Cubic& rest) noexcept {
    apply(c_.near, beta);
    ++report_.passes;
    return sunk_ + swept(c_.near) + swept_faces() + rest(beta);
}

bool Resolver::finish_at(double beta) noexcept {
    const double error = settle(beta);
    if (std::fabs(error) > kAimed * std::fabs(removed_)) polish(error);
    return std::fabs(report_.volume_error) <= 0.1 * kKept || report_.passes > kMaxPasses;
}

void Resolver::take_all_as_near() noexcept {
    for (std::uint32_t e = 0; e < c_.tile_count; ++e) c_.tile_bits[c_.tiles[e]] |= kTileNear;
    collect(c_.near, kTileBulging, kTileBulging);
    c_.ring.count = 0;
}

void Resolver::bulge() noexcept {
    part_ring();
    list_classes();
    Cubic near, rest;
    cubic(c_.near, near.c);
    cubic_faces(near.c);
    cubic(c_.ring, rest.c);
    const Cubic all{{near.c[0] + rest.c[0], near.c[1] + rest.c[1], near.c[2] + rest.c[2]}};
    const double first = removed_ / all.c[0];
    if (!std::isfinite(first) || removed_ == 0) return;
    report_.first_order_error = (all(first) - removed_) / removed_;
    report_.paper_error = (all(total_) - removed_) / removed_;
    if (o_.bulge == Bulge::Paper) {
        settle(total_);
        return;
    }
    search_height(all, rest, first);
}

void Resolver::search_height(const Cubic& all, Cubic rest, double first) noexcept {
    double beta = first_height(all, first);
    HeightSearch search(all, removed_, first, beta);
    // The cost of a plane is known without moving a sample, too, except for border faces.
    bool known = foreseen();
    double aim = known ? kSolved : kForeseen;
    const auto measure = [&] {
        if (!known) return measure_near(beta, rest);
        ++report_.passes;
        return all(beta) - removed_ - held_back(beta);
    };
    for (double error = measure();;) {
        const double next = search.next(beta, error);
        if (next == 0 || report_.passes >= kMaxPasses) {
            report_.passes = kMaxPasses;
            finish_at(search.best());
            return;
        }
        beta = std::copysign(next, first);
        if (search.best_error() > aim * std::fabs(removed_)) {
            error = measure();
            continue;
        }
        // So near that the step leaves next to nothing.
        if (finish_at(beta)) return;
        // Too few samples to take the rest, or others rest on the obstacle too: nearer first, and all of them.
        known = false;
        error = settle(beta);
        aim *= 1e-2;
        take_all_as_near();
        rest = {};
        search.restart();
    }
}

}  // namespace dgm::detail
