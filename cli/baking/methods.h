// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/methods.h
// One table of the methods that lay a component out: the command line, scene files, reports and the bake read it.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "baking/bake_options.h"

namespace dgm::bake {

/// Where a method opens the component.
enum class MethodCut {
    kAny,       ///< each candidate in its own way
    kSearched,  ///< along the cut with the least measured error (cut_search.h)
    kStar,      ///< along the arms of an octahedron (star_cut.h)
    kShortest,  ///< along the shortest cut that opens it, longer where the map demands it (free_chart.h)
    kUvSeams,   ///< where its texture coordinates part
};

struct MethodRow {
    std::string_view name;
    Method value;
    DomainChoice domain;  ///< kAuto: either
    bool needs_uvs;       ///< the source must have texture coordinates
    MethodCut cut;
};

/// In the order in which people read them.
inline constexpr std::array kMethods{
    MethodRow{"auto", Method::kAuto, DomainChoice::kAuto, false, MethodCut::kAny},
    MethodRow{"stretch", Method::kStretch, DomainChoice::kSquare, false, MethodCut::kSearched},
    MethodRow{"sphere", Method::kSphere, DomainChoice::kSquare, false, MethodCut::kStar},
    MethodRow{"mvc", Method::kMvc, DomainChoice::kSquare, false, MethodCut::kSearched},
    MethodRow{"authalic", Method::kAuthalic, DomainChoice::kSquare, false, MethodCut::kSearched},
    MethodRow{"conformal", Method::kConformal, DomainChoice::kSquare, false, MethodCut::kSearched},
    MethodRow{"tutte", Method::kTutte, DomainChoice::kSquare, false, MethodCut::kSearched},
    MethodRow{"lscm", Method::kLscm, DomainChoice::kFree, false, MethodCut::kShortest},
    MethodRow{"arap", Method::kArap, DomainChoice::kFree, false, MethodCut::kShortest},
    MethodRow{"slim", Method::kSlim, DomainChoice::kFree, false, MethodCut::kShortest},
    MethodRow{"uv", Method::kUv, DomainChoice::kFree, true, MethodCut::kUvSeams},
};

/// The table stands in the order of the enum.
[[nodiscard]] constexpr const MethodRow& row_of(Method method) {
    return kMethods[static_cast<std::size_t>(method)];
}
[[nodiscard]] constexpr std::string_view name_of(Method method) {
    return row_of(method).name;
}
/// nullopt for a word that names no method.
[[nodiscard]] constexpr std::optional<Method> method_of(std::string_view name) {
    for (const MethodRow& row : kMethods)
        if (row.name == name) return row.value;
    return std::nullopt;
}
/// True if the method leaves the chart's border free inside the square.
[[nodiscard]] constexpr bool is_free(Method method) {
    return row_of(method).domain == DomainChoice::kFree;
}

/// The words alone, for lists of choices.
[[nodiscard]] constexpr std::array<std::string_view, kMethods.size()> method_names() {
    std::array<std::string_view, kMethods.size()> out{};
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = kMethods[k].name;
    return out;
}
inline constexpr auto kMethodNames = method_names();

[[nodiscard]] constexpr bool methods_are_in_order() {
    for (std::size_t k = 0; k < kMethods.size(); ++k)
        if (static_cast<std::size_t>(kMethods[k].value) != k) return false;
    return true;
}
static_assert(methods_are_in_order());

}  // namespace dgm::bake
