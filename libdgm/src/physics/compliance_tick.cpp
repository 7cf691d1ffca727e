// SPDX-License-Identifier: MIT
// libdgm/src/physics/compliance_tick.cpp
// The haptic side of a Compliance: takes over the newest frame, and solves a tool's contact by projected Gauss-Seidel.
//
// Slots are sequence locks, as in touch/snapshot.cpp, where the memory orders are explained.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "physics/compliance_impl.h"

namespace dgm {
namespace detail {

void physics::hand_out_local(ComplianceImpl& c, std::uint32_t tool) noexcept {
    const std::size_t at = c.slot(tool, c.frame);
    std::uint64_t& sequence = c.sequence[at];
    const std::uint64_t before = __atomic_load_n(&sequence, __ATOMIC_RELAXED);
    __atomic_store_n(&sequence, before + 1, __ATOMIC_RELAXED);
    Word* to = c.words.data() + at * kLocalWords;
    const auto* from = reinterpret_cast<const std::byte*>(&c.local);
    for (std::size_t k = 0; k < kLocalWords; ++k) {
        Word w;
        std::memcpy(&w, from + k * sizeof w, sizeof w);
        __atomic_store_n(to + k, w, __ATOMIC_RELEASE);
    }
    __atomic_store_n(&sequence, before + 2, __ATOMIC_RELEASE);
}

namespace {
using namespace physics;

constexpr int kSweeps = 32;
constexpr float kEnough = 1e-4f;  ///< of the largest force, by which forces change in the last sweep

/// Copies the newest frame of a tool. @return false: there is none, or the writer was quicker; then `to` is spoilt
bool take_newest(const ComplianceImpl& c, std::uint32_t tool, std::uint64_t frame, Local& to) noexcept {
    const std::size_t at = c.slot(tool, frame);
    const std::uint64_t& sequence = c.sequence[at];
    const std::uint64_t before = __atomic_load_n(&sequence, __ATOMIC_ACQUIRE);
    if (before % 2 != 0) return false;
    const Word* from = c.words.data() + at * kLocalWords;
    auto* memory = reinterpret_cast<std::byte*>(&to);
    for (std::size_t k = 0; k < kLocalWords; ++k) {
        const Word w = __atomic_load_n(from + k, __ATOMIC_ACQUIRE);
        std::memcpy(memory + k * sizeof w, &w, sizeof w);
    }
    return __atomic_load_n(&sequence, __ATOMIC_RELAXED) == before && to.frame == frame;
}

/// Gaps and normals at a place of the tool, by column.
struct Contact {
    float gap[kMostColumns] = {};  ///< where forces are those of the reference
    float normal[3][kMostColumns] = {};
    float bend[kMostColumns][kMostColumns];  ///< [of a force on][gap of], m/N
};
void look(const Local& l, const float (&tool)[3], Contact& c) noexcept {
    for (std::uint32_t k = 0; k < l.near; ++k) {
        const float x[3] = {l.place[0][k] - tool[0], l.place[1][k] - tool[1], l.place[2][k] - tool[2]};
        const float length = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]), w = l.weight[k];
        const float by = length > 0 ? 1 / length : 0;
        const std::uint32_t g = l.column[k];
        float gap = length - l.radius;
        for (int a = 0; a < 3; ++a) {
            gap += by * x[a] * l.way[a][k];
            c.normal[a][g] += w * by * x[a];
        }
        c.gap[g] += w * gap;
    }
    for (std::uint32_t f = 0; f < l.columns; ++f)
        for (std::uint32_t g = 0; g < l.columns; ++g)
            c.bend[f][g] = c.normal[0][g] * l.response[0][f][g] + c.normal[1][g] * l.response[1][f][g] +
                           c.normal[2][g] * l.response[2][f][g];
}

/// `force` begins with those of the tick before.
void press(const Local& l, Contact& c, float (&force)[kMostColumns]) noexcept {
    for (std::uint32_t f = 0; f < l.columns; ++f) {
        const float change = force[f] - l.force[f];
        for (std::uint32_t g = 0; g < l.columns; ++g) c.gap[g] += change * c.bend[f][g];
    }
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        float most = 0, changed = 0;
        for (std::uint32_t f = 0; f < l.columns; ++f) {
            const float stiff = l.give[f] + std::max(0.0f, c.bend[f][f]);
            const float wanted = force[f] - (l.give[f] * (force[f] - l.multiplier[f]) + c.gap[f]) / stiff;
            const float change = std::max(0.0f, wanted) - force[f];
            force[f] += change;
            most = std::max(most, force[f]);
            changed = std::max(changed, std::fabs(change));
            for (std::uint32_t g = 0; g < l.columns; ++g) c.gap[g] += change * c.bend[f][g];
        }
        if (changed <= kEnough * most) return;
    }
}

/// Force on the tool at `position`.
Double3 answer(const Local& l, Vec3 position, float (&force)[kMostColumns], std::uint32_t& contacts) noexcept {
    contacts = 0;
    if (l.held == Held::Away) return {};
    const Double3 way = l.scale * (widen(position) - Double3{l.origin[0], l.origin[1], l.origin[2]});
    const float tool[3] = {static_cast<float>(way.x), static_cast<float>(way.y), static_cast<float>(way.z)};
    double sum[3] = {};
    if (l.held == Held::Grasp) {
        contacts = 1;
        for (int a = 0; a < 3; ++a)
            sum[a] = double{l.pull[a] + l.stiffness[3 * a] * tool[0] + l.stiffness[3 * a + 1] * tool[1] +
                            l.stiffness[3 * a + 2] * tool[2]};
        return {sum[0], sum[1], sum[2]};
    }
    Contact c;
    look(l, tool, c);
    press(l, c, force);
    for (std::uint32_t f = 0; f < l.columns; ++f) {
        if (!(force[f] > 0)) continue;
        ++contacts;
        for (int a = 0; a < 3; ++a) sum[a] -= double{force[f]} * double{c.normal[a][f]};
    }
    return {sum[0], sum[1], sum[2]};
}

/// What is left of the last jump.
Double3 fading(const ReaderImpl& r, const ReaderImpl::Felt& f) noexcept {
    return (static_cast<double>(f.left) / static_cast<double>(r.fade + 1)) * f.jump;
}

/// The newest frame becomes the present one. How the force jumps by it is kept, where the reader fades.
void take_over(ReaderImpl& r, ReaderImpl::Felt& f, const ToolInput& tool, std::uint64_t newest) noexcept {
    const Local& old = f.local[f.now];
    Local& fresh = f.local[1 - f.now];
    if (newest == old.frame || !take_newest(*r.from, tool.tool, newest, fresh)) return;
    Double3 before;
    std::uint32_t contacts = 0;
    const bool fades = r.fade > 0 && old.frame > 0 && tool.engaged;
    if (fades) before = answer(old, tool.position, f.force, contacts) + fading(r, f);
    f.now = 1 - f.now;
    std::copy_n(fresh.force, kMostColumns, f.force);
    f.left = 0;
    if (!fades) return;
    f.jump = before - answer(fresh, tool.position, f.force, contacts);
    f.left = r.fade + 1;
}
/// Observes the energy of a tool, and damps it while the body has given more than it got.
Double3 damp(const ReaderImpl& r, ReaderImpl::Felt& f, double scale, const ToolInput& tool, Double3 force) noexcept {
    const Double3 way = scale * (widen(tool.position) - widen(f.position));
    f.energy = f.engaged && tool.engaged ? f.energy - dot(f.answered, way) : 0;
    const double square = dot(way, way);
    if (f.energy < 0 && square > 0 && f.engaged) force = force - std::min(r.damper, -f.energy / square) * way;
    f.engaged = tool.engaged;
    f.position = tool.position;
    f.answered = force;
    return force;
}
}  // namespace
}  // namespace detail

[[gnu::cold]] Result<ComplianceReader> ComplianceReader::create(const Compliance& from,
                                                                const ReaderOptions& options) noexcept {
    if (!detail::is_valid(options.allocator))
        return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    const auto bad = [](const char* why) { return Error{ErrorCode::BadArgument, kNoOffset, why}; };
    if (options.fade > 1000) return bad("the ticks of a fade are not in 0 .. 1000");
    if (!(options.damper >= 0 && options.damper <= 1e6f)) return bad("the damper is not in 0 .. 1e6 N s/m");
    if (!(options.tick >= 0.99e-5f && options.tick <= 1)) return bad("the tick is not in 1e-5 .. 1 s");
    constexpr Error kNoRoom{ErrorCode::OutOfMemory, kNoOffset, "no memory for the reader"};
    auto* impl = detail::create<detail::ReaderImpl>(options.allocator, options.allocator);
    if (impl == nullptr) return kNoRoom;
    ComplianceReader made(impl);
    impl->from = from.impl();
    impl->tools = from.impl()->options.tools;
    impl->fade = options.fade;
    impl->damper = double{options.damper} / double{options.tick};
    if (!impl->felt.allocate(options.allocator, impl->tools)) return kNoRoom;
    return made;
}

ComplianceReader::ComplianceReader(ComplianceReader&& other) noexcept : impl_(std::exchange(other.impl_, nullptr)) {}
ComplianceReader& ComplianceReader::operator=(ComplianceReader&& other) noexcept {
    std::swap(impl_, other.impl_);
    return *this;
}
ComplianceReader::~ComplianceReader() {
    detail::destroy(impl_);
}

Result<void> compliance_tick(ComplianceReader& reader, std::span<const ToolInput> tools,
                             std::span<ComplianceAnswer> answers) noexcept {
    detail::ReaderImpl& r = *reader.impl();
    const auto bad = [](const char* why) { return Error{ErrorCode::BadArgument, kNoOffset, why}; };
    if (answers.size() < tools.size()) return bad("there are fewer answers than tools");
    for (const ToolInput& t : tools) {
        if (t.tool >= r.tools) return bad("a tool's number is beyond those of the compliance");
        if (!detail::is_place(t.position)) return bad("a coordinate of a tool is beyond 1e18");
    }
    const std::uint64_t newest = r.from->newest.load(std::memory_order_acquire);
    for (std::size_t k = 0; k < tools.size(); ++k) {
        const ToolInput& t = tools[k];
        detail::ReaderImpl::Felt& f = r.felt[t.tool];
        if (newest != 0) detail::take_over(r, f, t, newest);
        const detail::physics::Local& l = f.local[f.now];
        ComplianceAnswer out;
        out.frame = l.frame;
        const bool same = (l.held == detail::physics::Held::Grasp) == (t.kind == ToolKind::Grasp);
        detail::Double3 force;
        if (t.engaged && same) force = detail::answer(l, t.position, f.force, out.contacts);
        if (t.engaged && f.left > 0) {
            --f.left;
            force = force + detail::fading(r, f);
        }
        if (r.damper > 0) force = detail::damp(r, f, l.scale, t, force);
        out.force = detail::narrow(force);
        answers[k] = out;
    }
    return {};
}

}  // namespace dgm
