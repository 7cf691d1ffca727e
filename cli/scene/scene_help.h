// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/scene_help.h
// Explains scene files in the help and man pages of the programs that read them; docs/scenes.md says more.
#pragma once
#include <array>

#include "tool/help.h"

namespace dgm::scene {

inline constexpr std::array kSceneKeys{
    tool::Term{"source", "mesh file, from the folder of the scene file; every asset has one"},
    tool::Term{"name", "of the output, below the output folder [the source's]"},
    tool::Term{"tolerance",
               "distance between source and reconstruction: \"0.05%\" of the diagonal, \"0.2\" in the mesh's units, or "
               "\"1px\" at distance [\"0.05%\"]"},
    tool::Term{"tolerance_kind", "\"rms\", or \"hausdorff\" for the largest distance [\"rms\"]"},
    tool::Term{"distance", "the nearest that a viewer comes, in the mesh's units"},
    tool::Term{"fov", "vertical field of view in degrees [60]"},
    tool::Term{"resolution", "rows of the picture [1080]"},
    tool::Term{"touched", "tools press into it: brings collision, deformation and contact [false]"},
    tool::Term{"footprint", "\"surface\", \"geodesic\" or \"grid\": what a tick is timed with [\"surface\"]"},
    tool::Term{"reach", "radius of a touch, \"5%\" or in the mesh's units [\"5%\"]"},
    tool::Term{"contact", "it is set down on things, or things on it [false]"},
    tool::Term{"lit", "normals are needed [true]"},
    tool::Term{"textured", "colours are needed [true]"},
    tool::Term{"detail", "bump: the shape between the samples, for shading [false]"},
    tool::Term{"layers", "exactly these layers, whatever the keys above ask for"},
    tool::Term{"texture_budget", "bytes of the texture layers of all charts, such as \"64KiB\""},
    tool::Term{"fabric", "a picture instead of the source's textures"},
    tool::Term{"budget", "bytes of the asset's file; in [scene], of all files together"},
    tool::Term{"tick_budget", "in [scene]: microseconds of a haptic tick, of each touched asset"},
    tool::Term{"largest", "the largest grid that is tried [\"1025x1025\"]"},
    tool::Term{"method", "as the option of dgm-bake [\"auto\"]"},
    tool::Term{"domain", "as the option of dgm-bake [\"auto\"]"},
    tool::Term{"fit", "as the option of dgm-bake [\"best\"]"},
    tool::Term{"unit", "length of a unit of the mesh, for physics: \"mm\", \"cm\" or \"m\""},
    tool::Term{"material",
               "for physics: \"tissue\", \"cotton\", \"denim\", \"satin\" or a material file, from the folder of the "
               "scene file; needs unit"},
    tool::Term{"precision", "as the option of dgm-bake [the smaller one that holds the tolerance]"}};

inline constexpr std::array kSceneSections{tool::Section{
    "Scene files",
    "A TOML file says what a scene needs of each asset. dgm-bake SCENE.toml bakes for each the smallest grid that "
    "holds its "
    "tolerance; dgm-info SCENE.toml shows the plan and bakes nothing. [defaults] holds for all assets; options of the "
    "command line that change a map are refused.",
    "[scene]\n"
    "budget = \"4MiB\"\n"
    "[defaults]\n"
    "tolerance = \"0.05%\"\n"
    "[[asset]]\n"
    "source = \"stomach.obj\"\n"
    "touched = true",
    kSceneKeys, "docs/scenes.md"}};

}  // namespace dgm::scene
