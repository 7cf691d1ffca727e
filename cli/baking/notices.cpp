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

/// "3 non-manifold edges taken apart", "1 non-manifold edge taken apart": the first noun of `kind` goes by the count.
std::string counted_repair(std::uint64_t count, const std::string& kind) {
    constexpr std::array<std::array<std::string_view, 2>, 10> kNouns{{{"faces", "face"},
                                                                      {"edges", "edge"},
                                                                      {"vertices", "vertex"},
                                                                      {"components", "component"},
                                                                      {"corners", "corner"},
                                                                      {"elements", "element"},
                                                                      {"statements", "statement"},
                                                                      {"coordinates", "coordinate"},
                                                                      {"normals", "normal"},
                                                                      {"lines", "line"}}};
    std::string out = kind;
    std::size_t first = std::string::npos;
    std::array<std::string_view, 2> noun;
    for (const auto& row : kNouns)
        if (const std::size_t at = kind.find(row[0]); count == 1 && at < first) {
            first = at;
            noun = row;
        }
    if (first != std::string::npos) out.replace(first, noun[0].size(), noun[1]);
    return fmt::format("{} {}", count, out);
}

}  // namespace

std::vector<Notice> notices(const Repaired& source) {
    std::vector<Notice> out;
    const std::size_t components = source.components.size();
    for (const std::string& warning : source.facts.warnings) out.push_back({{}, "warning: " + warning});
    for (const std::string& remark : source.facts.remarks) out.push_back({remark, "note: " + remark});
    if (components > 1)
        out.push_back(
            {"several components: one chart each", fmt::format("note: {} components: one chart each", components)});
    for (const auto& [kind, count] : source.facts.repairs)
        if (std::find(kOrdinaryRepairs.begin(), kOrdinaryRepairs.end(), kind) == kOrdinaryRepairs.end())
            out.push_back({"repaired: " + kind, "note: repaired: " + counted_repair(count, kind)});
    std::uint64_t loops = 0, open = 0, genus = 0;
    for (const model::TriMesh& component : source.components) {
        const Topology topology = measure_topology(component);
        loops += topology.boundary_loops;
        open += topology.boundary_loops > 0 ? 1 : 0;
        if (!topology.oriented) continue;  // crosscaps are no handles
        genus += static_cast<std::uint64_t>(std::max<std::int64_t>(0, topology.genus));
    }
    if (loops > 0)
        out.push_back(
            {"open border (fine for cloth, odd for an organ)",
             fmt::format("note: open border ({} loop{}{}): fine for cloth, odd for an organ", loops,
                         loops == 1 ? "" : "s",
                         components > 1 ? fmt::format(" on {} of {} components", open, components) : std::string())});
    if (genus > 0)
        out.push_back({"handles like that of a cup (cut open)",
                       fmt::format("note: {} handle{} like that of a cup: the cut has to open {}", genus,
                                   genus == 1 ? "" : "s", genus == 1 ? "it" : "each")});
    return out;
}

}  // namespace dgm::bake
