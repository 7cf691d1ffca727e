// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/free_methods.cpp
#include "geometry/parameterize/free_methods.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <string>

#include "geometry/mesh/triangle.h"
#include "geometry/parameterize/check_disk.h"
#include "geometry/parameterize/coarse_descent.h"
#include "geometry/parameterize/flat_map.h"
#include "geometry/parameterize/flip_repair.h"
#include "geometry/parameterize/free_maps.h"
#include "geometry/parameterize/slim.h"

namespace dgm::bake {
namespace {
enum class Method { kLscm, kArap, kSlim };

constexpr std::size_t kDescentSteps = 100;
constexpr double kTolerance = 1e-5;      // of the descent
constexpr double kFineTolerance = 1e-4;  // of a disk whose coarse level has been descended

[[noreturn]] void fail(const std::string& what) {
    throw model::Error(model::codes::kMapInvalid, what);
}

/// Centroid at the origin, and the surface's area if `rescale`. False if the map has no area or is not finite.
bool normalise(const DiskView& disk, std::vector<Vec2d>& uv, bool rescale) {
    double surface = 0, map = 0;
    Vec2d centre;
    for (const Face& f : disk.faces) {
        const double a = signed_area(uv[f[0]], uv[f[1]], uv[f[2]]);
        surface += face_area({disk.positions[f[0]], disk.positions[f[1]], disk.positions[f[2]]});
        map += a;
        centre = centre + (uv[f[0]] + uv[f[1]] + uv[f[2]]) * (a / 3);
    }
    if (!(map > 0)) return false;
    centre = centre * (1 / map);
    const double scale = rescale ? std::sqrt(surface / map) : 1;
    for (Vec2d& p : uv) p = (p - centre) * scale;
    return std::all_of(uv.begin(), uv.end(), [](Vec2d p) { return std::isfinite(p.x) && std::isfinite(p.y); });
}

class FreeParameterizer final : public Parameterizer {
 public:
    FreeParameterizer(Method method, std::string_view name) : method_(method), name_(name) {}

    [[nodiscard]] std::string_view name() const override { return name_; }
    [[nodiscard]] bool fixed_border() const override { return false; }

    [[nodiscard]] std::vector<Vec2d> solve(const DiskView& given, const model::Progress& progress) const override {
        progress.update(name_, 0);
        DiskView disk = given;
        disk.border_uv = {};
        try {
            check_disk(disk, false);
            std::vector<Vec2d> uv = solve_disk(disk, progress);
            progress.update(name_, 1);
            return uv;
        } catch (const std::bad_alloc&) {
            throw model::Error(model::codes::kWorkerMemory, std::string(name_) + " ran out of memory");
        }
    }

 private:
    /// Large disks go the long way on a coarse level.
    [[nodiscard]] std::vector<Vec2d> descend(const DiskView& disk, std::vector<Vec2d> start,
                                             const model::Progress& progress) const {
        const auto on_level = [&](const DiskView& coarse) -> std::optional<std::vector<Vec2d>> {
            std::optional<std::vector<Vec2d>> uv = flip_free_start(coarse, progress);
            if (uv) uv = descend_from(coarse, std::move(*uv), kTolerance, progress);
            return uv;
        };
        if (auto coarse = map_coarsely(disk, start, on_level, progress))
            return descend_from(disk, std::move(*coarse), kFineTolerance, progress);
        return descend_from(disk, std::move(start), kTolerance, progress);
    }

    /// The symmetric Dirichlet energy unfolds the crowded start quickly; the ARAP energy, which hardly counts small
    /// faces, would stay near it.
    [[nodiscard]] std::vector<Vec2d> descend_from(const DiskView& disk, std::vector<Vec2d> start, double tolerance,
                                                  const model::Progress& progress) const {
        SlimOptions options;
        options.iterations = kDescentSteps;
        options.tolerance = tolerance;
        if (method_ != Method::kArap) return descend_flip_free(disk, std::move(start), options, progress);
        options.tolerance = std::max(tolerance, 1e-3);
        start = descend_flip_free(disk, std::move(start), options, progress);
        options.energy = FlipFreeEnergy::kArap;
        options.tolerance = tolerance;
        return descend_flip_free(disk, std::move(start), options, progress);
    }

    [[nodiscard]] std::vector<Vec2d> solve_disk(const DiskView& disk, const model::Progress& progress) const {
        if (std::optional<std::vector<Vec2d>> flat = flat_needle_map(disk.positions, disk.faces))
            return std::move(*flat);
        std::optional<std::vector<Vec2d>> uv = direct(disk, progress);
        if (uv && count_not_positive(disk.faces, *uv) > 0) {
            const RepairShape shape = method_ == Method::kArap ? RepairShape::kIsometric : RepairShape::kConformal;
            if (auto repaired = repair_flips(disk, *uv, shape, progress)) uv = std::move(repaired);
        }
        if (uv && count_not_positive(disk.faces, *uv) == 0) return std::move(*uv);
        std::optional<std::vector<Vec2d>> start = flip_free_start(disk, progress);
        if (!start) {
            if (!uv) fail(std::string(name_) + ": no map without flips was found");
            return std::move(*uv);
        }
        std::vector<Vec2d> descended = descend(disk, std::move(*start), progress);
        std::vector<Vec2d> centred = descended;
        if (normalise(disk, centred, rescales()) && count_not_positive(disk.faces, centred) == 0) return centred;
        return descended;
    }

    /// The map of least energy, flips or not; nothing where there is none, or where flips are out of the question.
    [[nodiscard]] std::optional<std::vector<Vec2d>> direct(const DiskView& disk,
                                                           const model::Progress& progress) const {
        if (method_ == Method::kSlim) return std::nullopt;
        std::optional<std::vector<Vec2d>> uv;
        try {
            uv = method_ == Method::kArap ? arap_map(disk, harmonic_disk_map(disk, progress), {}, progress)
                                          : lscm_map(disk, LscmWeight::kArea, progress);
        } catch (const model::Error& e) {
            if (e.code().number != model::codes::kMapInvalid.number) throw;
        }
        if (uv && !normalise(disk, *uv, rescales())) uv.reset();
        return uv;
    }
    [[nodiscard]] bool rescales() const { return method_ == Method::kLscm; }

    Method method_;
    std::string_view name_;
};
}  // namespace

std::unique_ptr<Parameterizer> make_free_parameterizer(std::string_view method) {
    if (method == "lscm") return std::make_unique<FreeParameterizer>(Method::kLscm, "lscm");
    if (method == "arap") return std::make_unique<FreeParameterizer>(Method::kArap, "arap");
    if (method == "slim") return std::make_unique<FreeParameterizer>(Method::kSlim, "slim");
    return nullptr;
}

}  // namespace dgm::bake
