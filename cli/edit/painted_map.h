// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/painted_map.h
// A map and what an edit changes of it: number by number, so that only painted samples get other bits.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "edit/map_parts.h"
#include "edit/rounding.h"
#include "model/map_set.h"

namespace dgm::edit {

/// What an edit does to one part of one chart.
struct PartEdit {
    std::size_t chart = 0, layer = 0;  ///< by their numbers
    MapPart part;
    std::uint32_t numbers = 1;     ///< of one sample of the layer
    double unit = 1;               ///< of the layer's numbers
    std::filesystem::path source;  ///< the file that it came from
    bool is_trusted = false;       ///< nobody knows which samples were changed
    std::vector<char> changed;     ///< one a sample
    std::uint64_t samples = 0;     ///< that were changed by the edit itself
    double largest = 0;            ///< change of a number; of bump in source units
    std::uint64_t clamped = 0;     ///< numbers beyond 0..1
    std::uint64_t outside = 0;     ///< samples off the surface, which were left as they were
    std::uint64_t joined = 0;      ///< seam copies that took the number of the painted one
    std::uint64_t padded = 0;      ///< texels beyond the surface that took the colour of a painted one
    [[nodiscard]] bool is_empty() const { return samples == 0 && !is_trusted; }
};

class PaintedMap {
 public:
    /// `maps` must outlive it.
    PaintedMap(const model::MapSet& maps, const PartChoice& choice);

    /// The part that a number of a layer's samples belongs to; null if it was not asked for. The pointer stays good.
    PartEdit* edit_of(std::size_t chart, std::size_t layer, std::uint32_t number, const std::filesystem::path& source);

    /// Takes one number, as stored, if it is not what a file of that rounding holds of the map's own. One of a part
    /// that may not be edited is only counted. @return whether it was changed
    /// @throws model::Error kNotFinite; kBadValue for a height beyond what the layer holds
    bool offer(PartEdit& edit, std::uint32_t number, std::size_t sample, double saved, const Rounding& rounding);

    /// The same for a number that is known to be another than the map's.
    void put(PartEdit& edit, std::uint32_t number, std::size_t sample, double saved);

    /// Counts a change of a part that may not be edited.
    void note(PartEdit& edit, std::size_t sample, double change) { mark(edit, sample, change); }

    /// For a layer whose bytes are another painter's, and the map's own are lost: all of it counts as painted.
    void trust(std::size_t chart, std::size_t layer, const std::filesystem::path& source);

    /// After the last number: refuses what may not be edited, leaves samples off the surface, joins seam copies,
    /// colours the padding of textures. @throws model::Error kEditForbidden: names each part, with figures
    void finish();

    [[nodiscard]] const model::MapSet& original() const { return original_; }
    [[nodiscard]] const model::MapSet& maps() const { return maps_; }
    [[nodiscard]] model::MapSet& maps() { return maps_; }
    [[nodiscard]] const PartChoice& choice() const { return choice_; }
    /// Chart by chart, in the order of layers and numbers; those that were looked at.
    [[nodiscard]] std::vector<const PartEdit*> edits() const;
    /// True if no number was changed.
    [[nodiscard]] bool is_unchanged() const;

 private:
    void leave_outside(PartEdit& edit);
    void join_copies(PartEdit& edit);
    void colour_padding(PartEdit& edit);
    [[nodiscard]] double stored(const PartEdit& edit, std::uint32_t number, std::size_t sample) const;
    void store(const PartEdit& edit, std::uint32_t number, std::size_t sample, double value);
    void mark(PartEdit& edit, std::size_t sample, double change);

    const model::MapSet& original_;
    const PartChoice& choice_;
    model::MapSet maps_;
    std::map<std::pair<std::pair<std::size_t, std::size_t>, std::uint32_t>, PartEdit> edits_;
};

/// Factor of a layer's numbers for people: attribute `scale` of bump, else 1.
[[nodiscard]] double unit_of(const model::Layer& layer);

/// "/charts/0/deformation[4][5]": a sample of a layer.
[[nodiscard]] std::string sample_place(std::size_t chart, const model::Layer& layer, std::size_t sample);

}  // namespace dgm::edit
