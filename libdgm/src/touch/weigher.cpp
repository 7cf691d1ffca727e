// SPDX-License-Identifier: MIT
// libdgm/src/touch/weigher.cpp
// Turns a distance on the surface into a weight: kernels with a direction, and painted stiffness.
#include <cmath>

#include "touch/patch.h"
#include "touch/state_impl.h"
#include "touch/table_impl.h"

namespace dgm::detail {
namespace {

/// Unit tangents of the rest surface at the contact: u along +i, v a quarter turn from it towards +j.
void tangents(const StateImpl& s, std::uint32_t contact, Vec3& u, Vec3& v) noexcept {
    const ConstPlanes p = StateImpl::fixed(s.rest);
    const Vec3 n = StateImpl::at(s.rest_normal, contact);
    Vec3 e{};
    if (contact < s.tables.grid) {
        const std::uint32_t i = contact / s.tables.cols, step = s.tables.cols;
        const std::uint32_t before = i > 0 && s.usable(contact - step) ? contact - step : contact;
        const std::uint32_t after = i + 1 < s.tables.rows && s.usable(contact + step) ? contact + step : contact;
        e = StateImpl::at(p, after) - StateImpl::at(p, before);
    }
    e = e - dot(e, n) * n;
    if (!(dot(e, e) > 0)) {
        e = std::fabs(n.x) < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
        e = e - dot(e, n) * n;
    }
    u = (1 / std::sqrt(dot(e, e))) * e;
    v = {n.y * u.z - n.z * u.y, n.z * u.x - n.x * u.z, n.x * u.y - n.y * u.x};
}
}  // namespace

Weigher::Weigher(const StateImpl& state, const TableImpl& table, const Contact& contact) noexcept
    : s_(state),
      t_(table),
      contact_(StateImpl::at(state.rest, contact.sample)),
      even_(table.mirrored && state.stiffness.empty()) {
    if (!table.mirrored) tangents(state, contact.sample, u_, v_);
}

float Weigher::at(std::uint32_t sample, float distance) const noexcept {
    if (!(distance < static_cast<float>(t_.options.reach))) return 0;
    if (even_) return t_.profile(distance);
    float r2 = distance * distance;
    if (!t_.mirrored && distance > 0) {
        // The direction is that of the straight line to the sample, laid into the tangent plane.
        const Vec3 e = StateImpl::at(s_.rest, sample) - contact_;
        const double x = dot(e, u_), y = dot(e, v_), flat2 = x * x + y * y;
        if (flat2 > 0) r2 = static_cast<float>((t_.a * x * x + t_.b * x * y + t_.c * y * y) / flat2 * r2);
    }
    const float stiffness = s_.stiffness.empty() || sample >= s_.tables.grid ? 1 : s_.stiffness[sample];
    if (stiffness == 0) return r2 == 0 ? t_.profile(0) : 0;
    return t_.profile(std::sqrt(stiffness == 1 ? r2 : r2 / stiffness));
}

}  // namespace dgm::detail
