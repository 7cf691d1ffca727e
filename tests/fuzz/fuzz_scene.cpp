// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_scene.cpp
// Scene files. Promises: at least one asset, each with a name of its own and values in their ranges; nothing but
// model::Error is thrown, and it names a place.
#include <set>
#include <string_view>

#include "model/error.h"
#include "scene/scene_file.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm;
    try {
        const scene::Scene scene =
            scene::parse_scene({reinterpret_cast<const char*>(data), size}, "/nonexistent/scene.toml");
        test::require(!scene.assets.empty());
        std::set<std::string> names;
        for (const scene::SceneAsset& asset : scene.assets) {
            test::require(names.insert(asset.name).second);
            test::require(asset.tolerance.value > 0 && asset.reach.value > 0 && !asset.source.empty());
            test::require(asset.view.fov_degrees >= 1 && asset.view.fov_degrees <= 170 && asset.view.rows > 0);
        }
    } catch (const model::Error& error) { test::require(!error.place().empty()); }
    return 0;
}
