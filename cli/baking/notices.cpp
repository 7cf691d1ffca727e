// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/notices.cpp
#include "baking/notices.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "geometry/metrics/map_metrics.h"

namespace dgm::bake {
namespace {

/// Exporters split vertices along texture seams and leave unused ones behind: that says nothing about the model.
constexpr std::array<std::string_view, 4> kOrdinaryRepairs{"open vertices welded", "unused vertices left out",
                                                           "zero-height faces flipped away",
                                                           "zero-height faces collapsed"};

}  // namespace

std::vector<std::string> notices(const Repaired& source) {
    std::vector<std::string> out;
    for (const std::string& warning : source.facts.warnings) out.push_back("warning: " + warning);
    for (const auto& [kind, count] : source.facts.repairs)
        if (std::find(kOrdinaryRepairs.begin(), kOrdinaryRepairs.end(), kind) == kOrdinaryRepairs.end())
            out.push_back(fmt::format("note: repaired: {} {}", count, kind));
    std::uint64_t loops = 0, open = 0, genus = 0;
    for (const model::TriMesh& component : source.components) {
        const Topology topology = measure_topology(component.positions.size(), component.faces);
        loops += topology.boundary_loops;
        open += topology.boundary_loops > 0 ? 1 : 0;
        genus += static_cast<std::uint64_t>(std::max<std::int64_t>(0, topology.genus));
    }
    if (loops > 0)
        out.push_back(fmt::format(
            "note: open border ({} loop{}{}): fine for cloth, odd for an organ", loops, loops == 1 ? "" : "s",
            source.components.size() > 1 ? fmt::format(" on {} of {} components", open, source.components.size())
                                         : std::string()));
    if (genus > 0)
        out.push_back(fmt::format("note: {} handle{} like that of a cup: the cut has to open {}", genus,
                                  genus == 1 ? "" : "s", genus == 1 ? "it" : "each"));
    return out;
}

}  // namespace dgm::bake
