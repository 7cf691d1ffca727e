// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/scene_plan.h
// Turns the demands of a scene into bakes, and counts the bytes that each choice saves against one size for all.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <dgm/layout.h>

#include "baking/bake_options.h"
#include "batch/batch_plan.h"
#include "scene/scene_file.h"

namespace dgm::scene {

/// The tolerance as the bake is asked for it: pixels become source units, value * 2 d tan(fov / 2) / rows.
[[nodiscard]] bake::ErrorGoal error_goal(const SceneAsset& asset);

/// Layers (docs/design.md section 4) that the asset's wishes need, in file order. Geometry always; normal if lit;
/// texture if textured; bump if detail; collision and deformation if touched; contact if touched or in contact.
[[nodiscard]] std::vector<std::string> needed_layers(const SceneAsset& asset);

/// The options of the bake: the smallest grid that holds the tolerance, or the largest in the budget if there is only
/// that, in the smaller precision that the tolerance allows.
[[nodiscard]] bake::BakeOptions bake_options(const SceneAsset& asset);

/// One job an asset, into `folder`. An asset whose source is not there is a refusal.
/// @throws model::Error kUsage if an output would overwrite a source
[[nodiscard]] bake::BatchPlan plan_batch(const Scene& scene, const std::filesystem::path& folder);

/// One line a wish: "tolerance 1.5 px at 20: 0.0321 units rms", "layers geometry, normal: not touched, no contact".
[[nodiscard]] std::vector<std::string> describe(const SceneAsset& asset);

/// Every asset with its wishes, a few lines each.
[[nodiscard]] std::string plan_text(const Scene& scene);

/// Bytes that each step from "everything at 257 x 257, f32" to the asset's file saves. The steps are taken one after
/// the other, so that they add up.
struct Saving {
    std::string choice;      ///< "grid 65x65", "precision u16", "without bump, contact", "texture 128x128"
    std::int64_t bytes = 0;  ///< negative: it costs
};

struct Savings {
    std::uint64_t one_size = 0;  ///< bytes of the baseline's layers
    std::uint64_t bytes = 0;     ///< of the layers as baked
    std::vector<Saving> steps;   ///< one_size - bytes in parts; steps of nothing are left out
};

/// A baked layer of a chart, as the file's index has it.
struct BakedLayer {
    std::string name;
    layout::ElementType type = layout::ElementType::kU8;
    std::vector<std::uint64_t> shape;
    std::uint64_t bytes = 0;
};
struct BakedChart {
    std::uint32_t rows = 0, cols = 0;
    std::vector<BakedLayer> layers;
    [[nodiscard]] const BakedLayer* find(std::string_view name) const;
};

/// The baseline is computed, not baked: docs/design.md section 4 has the size of each layer, smaller charts get fewer
/// samples as they did, textures two pixels a grid step where the asset has a texture, bump (2m-1) x (2n-1).
[[nodiscard]] Savings savings(const std::vector<BakedChart>& charts);

}  // namespace dgm::scene
