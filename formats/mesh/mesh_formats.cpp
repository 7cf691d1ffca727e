// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/mesh_formats.cpp
// The importers are those of assimp 5.2.5 as Debian 12 packages it; "tested" means tests/unit/formats imports a file
// of the format and compares every corner.
#include "mesh/mesh_formats.h"

#include <algorithm>
#include <array>
#include <string>
#include <system_error>

#include "mesh/text_input.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

constexpr std::array<std::string_view, 12> kTaken{".obj", ".3ds",  ".ply", ".stl", ".off", ".dae",
                                                  ".fbx", ".gltf", ".glb", ".x3d", ".lwo", ".3mf"};

struct LeftOut {
    std::string_view extension, why;
};
constexpr std::string_view kUntested = "its importer is not tested here: name the file to bake it",
                           kNoImporter = "there is no importer for it: export it as GLB, FBX or OBJ",
                           kOldBlender = "only files of Blender before 2.8 can be read: export it as GLB, FBX or OBJ";
/// Extensions that other files have, too (.x, .raw, .mesh, .ac), stand in neither list.
constexpr std::array kLeftOut{
    LeftOut{".blend", kOldBlender}, LeftOut{".abc", kNoImporter},    LeftOut{".c4d", kNoImporter},
    LeftOut{".3dm", kNoImporter},   LeftOut{".iges", kNoImporter},   LeftOut{".igs", kNoImporter},
    LeftOut{".ma", kNoImporter},    LeftOut{".max", kNoImporter},    LeftOut{".mb", kNoImporter},
    LeftOut{".skp", kNoImporter},   LeftOut{".sldprt", kNoImporter}, LeftOut{".usd", kNoImporter},
    LeftOut{".usda", kNoImporter},  LeftOut{".usdc", kNoImporter},   LeftOut{".usdz", kNoImporter},
    LeftOut{".wrl", kNoImporter},   LeftOut{".ztl", kNoImporter},    LeftOut{".step", kNoImporter},
    LeftOut{".stp", kNoImporter},   LeftOut{".amf", kUntested},      LeftOut{".ase", kUntested},
    LeftOut{".b3d", kUntested},     LeftOut{".cob", kUntested},      LeftOut{".dxf", kUntested},
    LeftOut{".ifc", kUntested},     LeftOut{".iqm", kUntested},      LeftOut{".irrmesh", kUntested},
    LeftOut{".lws", kUntested},     LeftOut{".lxo", kUntested},      LeftOut{".md2", kUntested},
    LeftOut{".md3", kUntested},     LeftOut{".md5mesh", kUntested},  LeftOut{".ms3d", kUntested},
    LeftOut{".nff", kUntested},     LeftOut{".ogex", kUntested},     LeftOut{".pmx", kUntested},
    LeftOut{".q3o", kUntested},     LeftOut{".sib", kUntested},      LeftOut{".smd", kUntested},
    LeftOut{".x3db", kUntested},    LeftOut{".xgl", kUntested},      LeftOut{".zae", kUntested},
    LeftOut{".zgl", kUntested}};

}  // namespace

std::size_t mesh_rank(const std::filesystem::path& path) {
    const std::string extension = lower_case(path.extension().string());
    return static_cast<std::size_t>(std::find(kTaken.begin(), kTaken.end(), extension) - kTaken.begin());
}

bool has_mesh_extension(const std::filesystem::path& path) {
    return mesh_rank(path) < kTaken.size();
}

std::string_view why_left_out(const std::filesystem::path& path) {
    const std::string extension = lower_case(path.extension().string());
    for (const LeftOut& row : kLeftOut)
        if (row.extension == extension) return row.why;
    return {};
}

void check_map_name(const std::filesystem::path& path) {
    namespace fs = std::filesystem;
    std::error_code error;
    if (fs::is_directory(path, error)) {
        fs::recursive_directory_iterator it(path, fs::directory_options::skip_permission_denied, error);
        for (; !error && it != fs::recursive_directory_iterator(); it.increment(error))
            if (it->path().extension() == ".dgm" || it->path().extension() == ".exr")
                throw model::Error(model::codes::kReadFailed, "this is a folder", path.string())
                    .with_hint("name the maps in it: " + (path / "*.dgm").string());
        throw model::Error(model::codes::kFileMissing, "the folder holds no maps", path.string())
            .with_hint("bake into it, such as: dgm-bake models/ -o " + path.string());
    }
    if (!fs::is_regular_file(path, error) || (!has_mesh_extension(path) && why_left_out(path).empty())) return;
    throw model::Error(model::codes::kNotDgm, "this is a mesh, not a map: bake it first", path.string())
        .with_hint("dgm-bake " + path.string() + " -o " + path.stem().string() + ".dgm");
}

}  // namespace dgm::formats
