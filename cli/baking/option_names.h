// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/option_names.h
// The words for the values of BakeOptions: one table for the command line, the worker protocol, reports and hashes.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "baking/bake_options.h"
#include "baking/methods.h"
#include "model/layer_names.h"

namespace dgm::bake {

template <class E>
struct NamedValue {
    std::string_view name;
    E value;
};

inline constexpr std::array kFitNames{NamedValue<Fit>{"sample", Fit::kSample}, NamedValue<Fit>{"l2", Fit::kL2},
                                      NamedValue<Fit>{"best", Fit::kBest}};
inline constexpr std::array kPrecisionNames{NamedValue<Precision>{"f32", Precision::kF32},
                                            NamedValue<Precision>{"u16", Precision::kU16},
                                            NamedValue<Precision>{"auto", Precision::kAuto}};
inline constexpr std::array kDomainNames{NamedValue<DomainChoice>{"auto", DomainChoice::kAuto},
                                         NamedValue<DomainChoice>{"square", DomainChoice::kSquare},
                                         NamedValue<DomainChoice>{"free", DomainChoice::kFree}};
inline constexpr std::array kErrorKindNames{NamedValue<ErrorKind>{"rms", ErrorKind::kRms},
                                            NamedValue<ErrorKind>{"hausdorff", ErrorKind::kHausdorff}};
inline constexpr std::array kExrLayoutNames{NamedValue<ExrLayout>{"auto", ExrLayout::kAuto},
                                            NamedValue<ExrLayout>{"multipart", ExrLayout::kMultipart}};

/// Layers that --layers may name, in file order. `collision` brings `cover`; the tables beside the layers (seams,
/// diagonals, mask, border_*) belong to the geometry and are always there.
inline constexpr std::array<std::string_view, 7> kLayerNames{
    model::layers::kGeometry,  model::layers::kNormal,      model::layers::kTexture, model::layers::kBump,
    model::layers::kCollision, model::layers::kDeformation, model::layers::kContact};

/// Steps that --ablate may leave out, for experiments.
inline constexpr std::array<std::string_view, 10> kAblateNames{"cut-search", "newton",      "diagonals",  "curvature",
                                                               "directions", "hidden-cuts", "other-cuts", "free-charts",
                                                               "refinement", "remaps"};

/// The word for `value`; empty for a value outside the table.
template <class Row, std::size_t N>
[[nodiscard]] constexpr std::string_view name_of(const std::array<Row, N>& table, decltype(Row::value) value) {
    for (const Row& row : table)
        if (row.value == value) return row.name;
    return {};
}

/// The value for a word, nullopt if the table does not have it.
template <class Row, std::size_t N>
[[nodiscard]] constexpr std::optional<decltype(Row::value)> value_of(const std::array<Row, N>& table,
                                                                     std::string_view name) {
    for (const Row& row : table)
        if (row.name == name) return row.value;
    return std::nullopt;
}

}  // namespace dgm::bake
