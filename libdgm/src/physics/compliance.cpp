// SPDX-License-Identifier: MIT
// libdgm/src/physics/compliance.cpp
// Computes how a body gives way near its tools, and publishes it.
//
// What is known of a column from the frame before is where its search begins.
#include <algorithm>
#include <cmath>

#include "physics/compliance_impl.h"
#include "physics/linear.h"

namespace dgm {
namespace detail {
namespace {
using namespace physics;

constexpr std::uint32_t kNew = 4;    ///< times the cycles of a column that is not known yet
constexpr std::uint32_t kMoved = 2;  ///< the same, where a neighbour is known
constexpr Error kNoRoom{ErrorCode::OutOfMemory, kNoOffset, "no memory for the compliance"};

struct Near {
    std::uint32_t sample, column;
    Double3 place, normal;  ///< from the tool, metres; out of the tool
    double gap, stiffness, multiplier;
};

/// A tool's column around one of its samples, and where it is kept.
struct Group {
    std::uint32_t sample, kept;
    bool known;
};

/// One frame of one tool.
class Maker {
 public:
    Maker(ComplianceImpl& c, PhysicsImpl& p, const StateImpl& s, const StepOptions& o, const ToolInput& tool,
          ComplianceReport& report) noexcept
        : c_(c), p_(p), s_(s), o_(o), tool_(tool), report_(report), local_(c.local) {}
    void make() noexcept {
        local_.origin[0] = double{tool_.position.x};
        local_.origin[1] = double{tool_.position.y};
        local_.origin[2] = double{tool_.position.z};
        local_.scale = p_.scale;
        local_.radius = static_cast<float>(double{o_.tool_radius} * p_.scale);
        if (!tool_.engaged) return;
        if (tool_.kind == ToolKind::Grasp)
            make_grasp();
        else
            make_touch();
    }

 private:
    [[nodiscard]] Double3 place(std::uint32_t k) const noexcept {
        const Double3 x = widen(StateImpl::at(s_.rest, k)) - widen(tool_.position);
        return p_.scale * x + Double3{p_.at[0][k], p_.at[1][k], p_.at[2][k]};
    }
    /// Multiplier of a sample at the tool, or 0.
    [[nodiscard]] double multiplier(std::uint32_t k) const noexcept {
        const Array<Touching>& list = p_.touching[p_.touching_now];
        const auto before = [&](const Touching& t, int) {
            return t.obstacle != tool_.tool ? t.obstacle < tool_.tool : t.sample < k;
        };
        const Touching* end = list.begin() + p_.touching_count;
        const Touching* at = std::lower_bound(list.begin(), end, 0, before);
        return at != end && at->obstacle == tool_.tool && at->sample == k ? at->multiplier : 0;
    }
    /// Keeps the nearest ones, by gap.
    void keep(const Near& n) noexcept {
        std::uint32_t at = count_;
        if (count_ == kMostNear) {
            if (near_[count_ - 1].multiplier > 0 && !(near_[count_ - 1].gap <= n.gap)) ++report_.left_out;
            if (near_[count_ - 1].gap <= n.gap) {
                report_.left_out += n.multiplier > 0 ? 1 : 0;
                return;
            }
            at = count_ - 1;
        } else {
            ++count_;
        }
        for (; at > 0 && near_[at - 1].gap > n.gap; --at) near_[at] = near_[at - 1];
        near_[at] = n;
    }
    void find_near() noexcept {
        const Level& l = p_.fine();
        double fastest = 0;
        for (const float* v : p_.velocity.p)
            for (std::uint32_t k = 0; k < l.grid; ++k) fastest = std::max(fastest, std::fabs(double{v[k]}));
        const double radius = double{o_.tool_radius} * p_.scale;
        const double reach = 2 * double{s_.mean_step} * p_.scale + 2 * fastest * double{p_.options.dt};
        for (std::uint32_t k = 0; k < l.grid; ++k) {
            if (l.own[k] == 0 || p_.free[k] == 0) continue;
            const Double3 x = place(k);
            const double square = dot(x, x), most = radius + reach;
            if (!(square < most * most) || !(square > 0)) continue;
            const double length = std::sqrt(square);
            keep({k, 0, x, (1 / length) * x, length - radius, double{p_.grip[k]}, multiplier(k)});
        }
        // Each its own column, if those that touch leave room.
        std::uint32_t touching = 0;
        for (std::uint32_t k = 0; k < count_; ++k) touching += near_[k].multiplier > 0 ? 1 : 0;
        count_ = std::min(count_, std::max(c_.options.columns, 2 * touching));
    }
    /// Groups around samples as far from each other as can be, the nearest to the tool first.
    void form_groups() noexcept {
        double far[kMostNear];
        std::fill(far, far + count_, std::numeric_limits<double>::infinity());
        const std::uint32_t most = std::min(c_.options.columns, count_);
        for (std::uint32_t next = 0; groups_ < most; ++groups_) {
            group_[groups_] = {near_[next].sample, kNone, false};
            for (std::uint32_t k = 0; k < count_; ++k) {
                const Double3 way = near_[k].place - near_[next].place;
                const double square = dot(way, way);
                if (!(square < far[k])) continue;
                far[k] = square;
                near_[k].column = groups_;
            }
            next = static_cast<std::uint32_t>(std::max_element(far, far + count_) - far);
        }
    }
    /// Where each group's column is kept: known ones stay, others take the place that was not used for longest.
    void find_columns() noexcept {
        Column* kept = c_.columns_of(tool_.tool);
        for (std::uint32_t g = 0; g < groups_; ++g)
            for (std::uint32_t k = 0; k < c_.known; ++k)
                if (kept[k].sample == group_[g].sample) {
                    group_[g] = {group_[g].sample, k, true};
                    kept[k].used = c_.frame;
                }
        for (std::uint32_t g = 0; g < groups_; ++g) {
            if (group_[g].known) continue;
            std::uint32_t oldest = 0;
            for (std::uint32_t k = 1; k < c_.known; ++k)
                if (kept[k].used < kept[oldest].used) oldest = k;
            kept[oldest] = {group_[g].sample, c_.frame, 0};
            group_[g].kept = oldest;
        }
    }
    /// Shares of the group's force: those that samples have now, and some for those that are near.
    void weigh_groups() noexcept {
        double sum[kMostColumns] = {}, inverse[kMostColumns] = {};
        std::uint32_t members[kMostColumns] = {};
        for (std::uint32_t k = 0; k < count_; ++k) ++members[near_[k].column];
        for (std::uint32_t k = 0; k < count_; ++k) sum[near_[k].column] += near_[k].multiplier;
        for (std::uint32_t k = 0; k < count_; ++k) {
            const std::uint32_t g = near_[k].column;
            const double pressed = sum[g] > 0 ? near_[k].multiplier / sum[g] : 0, even = 1.0 / members[g];
            const double weight = sum[g] > 0 ? 0.8 * pressed + 0.2 * even : even;
            local_.weight[k] = static_cast<float>(weight);
            inverse[g] += weight * weight / near_[k].stiffness;
        }
        for (std::uint32_t g = 0; g < groups_; ++g) {
            local_.give[g] = static_cast<float>(inverse[g]);
            local_.multiplier[g] = local_.force[g] = static_cast<float>(sum[g]);
        }
    }
    /// A column that is not known begins as the nearest one that is. @return false: there is none
    bool begin_at_neighbour(std::uint32_t g, const Field& to) noexcept {
        const Column* kept = c_.columns_of(tool_.tool);
        const Double3 here = place(group_[g].sample);
        double best = std::numeric_limits<double>::infinity();
        std::uint32_t nearest = kNone;
        for (std::uint32_t j = 0; j < groups_; ++j) {
            const Double3 way = place(group_[j].sample) - here;
            if (kept[group_[j].kept].renewed == 0 || !(dot(way, way) < best)) continue;
            best = dot(way, way);
            nearest = group_[j].kept;
        }
        if (nearest == kNone) return false;
        const Field from = c_.field(tool_.tool, nearest);
        for (int c = 0; c < 3; ++c) std::copy(from.p[c], from.p[c] + p_.fine().count(), to.p[c]);
        return true;
    }
    void solve_columns(const Linear& linear) noexcept {
        Column* kept = c_.columns_of(tool_.tool);
        for (std::uint32_t left = c_.options.renewed, k = 0; k < groups_; ++k) {
            // The oldest first; those that are not known are older than all.
            std::uint32_t g = kNone;
            for (std::uint32_t j = 0; j < groups_; ++j)
                if (kept[group_[j].kept].renewed != c_.frame &&
                    (g == kNone || kept[group_[j].kept].renewed < kept[group_[g].kept].renewed))
                    g = j;
            if (g == kNone || (group_[g].known && left == 0)) return;
            left -= group_[g].known ? 1 : 0;
            const Field to = c_.field(tool_.tool, group_[g].kept);
            std::uint32_t cycles = c_.options.cycles;
            if (!group_[g].known) cycles *= begin_at_neighbour(g, to) ? kMoved : kNew;
            linear.begin_empty();
            for (std::uint32_t n = 0; n < count_; ++n)
                if (near_[n].column == g) linear.push(near_[n].sample, double{local_.weight[n]} * near_[n].normal);
            linear.solve(to, cycles, cycles < c_.options.cycles * kNew);
            kept[group_[g].kept].renewed = c_.frame;
            ++report_.columns;
        }
    }
    void make_touch() noexcept {
        find_near();
        if (count_ == 0) return;
        local_.held = Held::Touch;
        form_groups();
        find_columns();
        weigh_groups();
        const Linear linear(p_, s_, o_, tool_.tool);
        const Field way = c_.field(tool_.tool, c_.known);
        begin_at_inertia(way);
        linear.begin_unbalanced();
        for (std::uint32_t k = 0; k < count_; ++k) linear.push(near_[k].sample, near_[k].multiplier * near_[k].normal);
        linear.solve(way, c_.options.cycles * kNew, true);
        solve_columns(linear);
        local_.near = count_;
        local_.columns = groups_;
        report_.samples += count_;
        for (std::uint32_t k = 0; k < count_; ++k) {
            const Near& n = near_[k];
            const double x[3] = {n.place.x, n.place.y, n.place.z};
            local_.column[k] = n.column;
            for (int c = 0; c < 3; ++c) {
                local_.place[c][k] = static_cast<float>(x[c]);
                local_.way[c][k] = way.p[c][n.sample];
                for (std::uint32_t g = 0; g < groups_; ++g)
                    local_.response[c][g][n.column] +=
                        local_.weight[k] * c_.field(tool_.tool, group_[g].kept).p[c][n.sample];
            }
        }
    }
    void begin_at_inertia(const Field& way) const noexcept {
        for (int c = 0; c < 3; ++c) { std::copy(p_.inertial.p[c], p_.inertial.p[c] + p_.fine().count(), way.p[c]); }
    }
    /// Three columns, of moves of the tool along the axes, and where it is now.
    void make_grasp() noexcept {
        bool any = false;
        const auto each = [&](auto f) {
            for (std::uint32_t k = 0; k < p_.grasped_count; ++k)
                if (p_.grasped[k].tool == tool_.tool && p_.free[p_.grasped[k].sample] != 0) f(p_.grasped[k]);
        };
        each([&](const Grasped&) { any = true; });
        if (!any) return;
        local_.held = Held::Grasp;
        local_.columns = 1;
        const Linear linear(p_, s_, o_, tool_.tool);
        const auto aim = [&](const Grasped& g) { return g.offset - place(g.sample); };
        const Field way = c_.field(tool_.tool, c_.known);
        begin_at_inertia(way);
        linear.begin_unbalanced();
        each([&](const Grasped& g) { linear.push(g.sample, g.multiplier + g.stiffness * aim(g)); });
        linear.solve(way, c_.options.cycles * kNew, true);
        Double3 pull;
        each([&](const Grasped& g) {
            pull = pull - g.multiplier - g.stiffness * (aim(g) - point(way, g.sample));
            ++report_.samples;
        });
        const double sum[3] = {pull.x, pull.y, pull.z};
        Column* kept = c_.columns_of(tool_.tool);
        for (std::uint32_t c = 0; c < 3; ++c) {
            local_.pull[c] = static_cast<float>(sum[c]);
            const Double3 e{c == 0 ? 1.0 : 0.0, c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0};
            const Field moved = c_.field(tool_.tool, c);
            const bool known = kept[c].sample == kGrasp;
            linear.begin_empty();
            each([&](const Grasped& g) { linear.push(g.sample, g.stiffness * e); });
            linear.solve(moved, c_.options.cycles * (known ? 1 : kNew), known);
            kept[c] = {kGrasp, c_.frame, c_.frame};
            Double3 force;
            each([&](const Grasped& g) { force = force - g.stiffness * (e - point(moved, g.sample)); });
            const double row[3] = {force.x, force.y, force.z};
            for (std::uint32_t a = 0; a < 3; ++a) local_.stiffness[3 * a + c] = static_cast<float>(row[a]);
            ++report_.columns;
        }
    }
    static constexpr std::uint32_t kGrasp = kNone - 1;

    ComplianceImpl& c_;
    PhysicsImpl& p_;
    const StateImpl& s_;
    const StepOptions& o_;
    const ToolInput& tool_;
    ComplianceReport& report_;
    Local& local_;
    Near near_[kMostNear] = {};
    Group group_[kMostColumns] = {};
    std::uint32_t count_ = 0, groups_ = 0;
};

bool fits(const ComplianceImpl& c, const PhysicsImpl& p, const StateImpl& s) noexcept {
    return c.rows == p.rows && c.cols == p.cols && c.total == p.total && s.tables.rows == p.rows &&
           s.tables.cols == p.cols && s.total() == p.total;
}
}  // namespace
}  // namespace detail

[[gnu::cold]] Result<Compliance> Compliance::create(const State& state, const Physics& physics,
                                                    const ComplianceOptions& o) noexcept {
    const detail::PhysicsImpl& p = *physics.impl();
    const detail::StateImpl& s = *state.impl();
    const auto bad = [](const char* why) { return Error{ErrorCode::BadArgument, kNoOffset, why}; };
    if (!detail::is_valid(o.allocator)) return bad("the allocator is half empty");
    if (o.tools < 1 || o.tools > detail::physics::kMostTools) return bad("the number of tools is not in 1 .. 8");
    if (o.columns < 1 || o.columns > detail::physics::kMostColumns)
        return bad("the number of columns is not in 1 .. 32");
    if (o.cycles < 1 || o.cycles > 1000) return bad("the number of cycles is not in 1 .. 1000");
    if (p.rows != s.tables.rows || p.cols != s.tables.cols || p.total != s.total())
        return bad("the physics was made for a state of another size");
    const std::uint32_t known = std::max(3u, 2 * o.columns);
    const std::uint64_t plane = p.fine().count(), floats = std::uint64_t{o.tools} * (known + 1) * 3 * plane;
    const std::uint64_t words = std::uint64_t{o.tools} * detail::physics::kSlots * detail::physics::kLocalWords;
    if (4 * floats + words * sizeof(detail::physics::Word) + sizeof(detail::ComplianceImpl) > o.max_bytes)
        return detail::over_max_bytes();
    auto* impl = detail::create<detail::ComplianceImpl>(o.allocator, o.allocator);
    if (impl == nullptr) return detail::kNoRoom;
    Compliance made(impl);
    impl->options = o;
    impl->rows = p.rows;
    impl->cols = p.cols;
    impl->total = p.total;
    impl->known = known;
    impl->plane = static_cast<std::size_t>(plane);
    if (!impl->fields.allocate(o.allocator, floats) || !impl->words.allocate(o.allocator, words) ||
        !impl->columns.allocate(o.allocator, std::uint64_t{o.tools} * known) ||
        !impl->sequence.allocate(o.allocator, std::uint64_t{o.tools} * detail::physics::kSlots))
        return detail::kNoRoom;
    return made;
}

Result<ComplianceReport> Compliance::publish(const State& state, Physics& physics, const StepOptions& options,
                                             std::span<const ToolInput> tools) noexcept {
    detail::ComplianceImpl& c = *impl_;
    detail::PhysicsImpl& p = *physics.impl();
    const detail::StateImpl& s = *state.impl();
    const auto bad = [](const char* why) { return Error{ErrorCode::BadArgument, kNoOffset, why}; };
    if (!detail::fits(c, p, s)) return bad("the compliance was made for a physics of another size");
    if (auto r = detail::physics::check_step(p, s, options); !r) return r.error();
    if (auto r = detail::physics::check_tools(options, tools, 0); !r) return r.error();
    if (options.tool_layer != 0)
        return Error{ErrorCode::Unsupported, kNoOffset, "compliances have no soft layer under tools"};
    if (detail::physics::kFriction && options.friction != 0)
        return Error{ErrorCode::Unsupported, kNoOffset, "compliances have no friction"};
    for (const ToolInput& t : tools)
        if (t.tool >= c.options.tools) return bad("a tool's number is beyond those of the compliance");
    if (!detail::physics::mark_pins(p, options.pins)) return bad("a sample or a copy of it is pinned twice");
    detail::physics::hold_pins(p, options.pins);
    ComplianceReport report;
    report.frame = ++c.frame;
    const double pressure = p.pressure;
    for (std::uint32_t number = 0; number < c.options.tools; ++number) {
        c.local = {};
        c.local.frame = c.frame;
        for (const ToolInput& t : tools)
            if (t.tool == number && p.solver.sound) detail::Maker(c, p, s, options, t, report).make();
        detail::physics::hand_out_local(c, number);
    }
    p.pressure = pressure;
    detail::physics::release_pins(p, options.pins);
    c.newest.store(c.frame, std::memory_order_release);
    return report;
}

Compliance::Compliance(Compliance&& other) noexcept : impl_(std::exchange(other.impl_, nullptr)) {}
Compliance& Compliance::operator=(Compliance&& other) noexcept {
    std::swap(impl_, other.impl_);
    return *this;
}
Compliance::~Compliance() {
    detail::destroy(impl_);
}

}  // namespace dgm
