// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/local_repair.h
// Repairs the inverted faces of a fitted grid, then fits again around the samples that had to move.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/fit/fit_state.h"
#include "geometry/fit/search_repair.h"

namespace dgm::bake {

/// More inverted faces mean that the source has no distinct sides: what repairs them one by one takes long and fails.
inline constexpr std::size_t kMostAtAPrice = 100;

/// Sampling and fitting leave a few inverted faces. The cheapest means come first: samples one by one
/// (vertex_repair.h), then patches (patch_repair.h) and a search (search_repair.h), as the measure of inverted faces
/// (metrics/turned_faces.h) finds them. Remembers the faces that no means could repair, and the effort spent.
class LocalRepair {
 public:
    /// @param fit  must outlive the object
    /// @param patch_effort  FitOptions::patch_effort; searches have the same share of their tries
    explicit LocalRepair(FitState& fit, std::size_t patch_effort = kPatchEffort);

    /// Repairs inverted faces where others do not invert for them; fit.kept and fit.matches follow.
    void repair();
    /// The same with faces that rounding may invert. Call it last: it costs some accuracy, and rounding may invert
    /// none.
    void repair_nearly();
    /// The last resort, where faces are inverted still: a long search in which samples may leave the source, on the
    /// border too, then patches that may cost what they like until the faces around them are fitted again. Fewer
    /// inverted faces may raise the error by 2 dB. If that does not do, or if there are more than kMostAtAPrice of
    /// them, all stays as it was.
    void repair_at_a_price();

 private:
    /// The last three at a price, each dearer than the one before.
    enum class Means { kCheap, kLongSearch, kDearPatches, kDearPlaces };

    [[nodiscard]] bool is_at_a_price() const { return means_ != Means::kCheap; }
    [[nodiscard]] SearchEffort search_effort() const;
    [[nodiscard]] std::vector<std::uint32_t> inverted_now() { return fit_.inverted.faces({}, nearly_); }
    bool try_means(bool all_means);
    bool move_vertices();
    bool move_patches();
    bool search_places(const std::vector<std::uint32_t>& left);
    [[nodiscard]] std::vector<char> held_while_searching(const std::vector<std::uint32_t>& left) const;
    void refit_around(const std::vector<Vec3d>& before, bool patches_moved);

    FitState& fit_;
    std::size_t most_patch_effort_;
    std::optional<std::vector<std::uint32_t>> unrepaired_;  // inverted faces that the last repair has left
    std::size_t patch_effort_;
    std::size_t short_tries_;  ///< of a search that is not at a price
    std::size_t long_tries_;   ///< that searches at a price may yet make
    Means means_ = Means::kCheap;
    bool nearly_ = false;  // repairs faces that rounding may invert, too
};

}  // namespace dgm::bake
