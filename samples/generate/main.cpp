// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/main.cpp
// dgm-make-samples OUTDIR: writes every sample asset. The same bytes on every run.
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>

#include "fabrics.h"
#include "model/codes.h"
#include "organs.h"
#include "upholstery.h"

namespace dgm::samples {
namespace {
namespace fs = std::filesystem;
using model::Vec3d;

constexpr int kFabricTexture = 512;
constexpr int kClothTexture = 2048;  // threads are finer than skin

fs::path subfolder(const fs::path& root, const char* name) {
    fs::path path = root / name;
    std::error_code failure;
    fs::create_directories(path, failure);
    if (failure)
        throw model::Error(model::codes::kWriteFailed, "cannot make the folder: " + failure.message(), path.string());
    return path;
}

void report(const fs::path& path, const PolyMesh& mesh) {
    std::printf("%s: %zu vertices, %zu polygons\n", path.c_str(), mesh.positions.size(), mesh.polygons.size());
}

MaterialText material(const char* name, double bump_scale, double shininess) {
    return {name, "colour.png", bump_scale > 0 ? "bump.png" : "", bump_scale, shininess};
}

void write_cushion(const fs::path& root) {
    const fs::path folder = subfolder(root, "cushion");
    const Picture linen = make_striped_linen(1024, 512);
    write_colour_png(linen, folder / "colour.png");
    write_relief_png(linen, folder / "bump.png");
    write_colour_png(make_gingham(1024, 512), folder / "cover.png");
    const PolyMesh cushion = make_cushion(), cover = make_cushion_cover();
    const MaterialText linen_material = material("linen", 0.05, 10);
    const MaterialText gingham_material{"gingham", "cover.png", "", 0, 10};
    write_obj({{"cushion", cushion}}, linen_material, folder / "cushion.obj");
    write_3ds({{"cushion", cushion}}, linen_material, folder / "cushion.3ds");
    write_obj({{"cover", cover}}, gingham_material, folder / "cover.obj");
    report(folder / "cushion.obj", cushion);
    report(folder / "cover.obj", cover);
}

void write_sheet(const Picture& denim, const fs::path& root) {
    const fs::path folder = subfolder(root, "sheet");
    write_colour_png(denim, folder / "colour.png");
    const PolyMesh sheet = make_sheet();
    write_obj({{"sheet", sheet}}, material("denim", 0, 5), folder / "sheet.obj");
    report(folder / "sheet.obj", sheet);
}

void write_skirt(const fs::path& root) {
    const fs::path folder = subfolder(root, "skirt");
    write_colour_png(make_gingham(512, 256), folder / "colour.png");
    const PolyMesh skirt = make_skirt();
    write_obj({{"skirt", skirt}}, material("gingham", 0, 10), folder / "skirt.obj");
    report(folder / "skirt.obj", skirt);
}

void write_chair(const Picture& satin, const fs::path& root) {
    const fs::path folder = subfolder(root, "chair");
    write_colour_png(satin, folder / "colour.png");
    const MaterialText m = material("satin", 0, 80);
    const PolyMesh seat = make_chair_seat();
    PolyMesh back = make_chair_back();
    write_obj({{"seat", seat}}, m, folder / "seat.obj");
    write_obj({{"back", back}}, m, folder / "back.obj");
    for (Vec3d& p : back.positions) p += Vec3d{0, 30, 40};  // behind the seat and clear of it
    quantise(back);
    write_obj({{"seat", seat}, {"back", back}}, m, folder / "chair.obj");
    report(folder / "seat.obj", seat);
    report(folder / "back.obj", back);
}

/// stomach/stomach_CLOTH.obj: the stomach once more, in that cloth.
void dress(const PolyMesh& stomach, const Picture& cloth, const std::string& name, const fs::path& root) {
    const fs::path folder = subfolder(root, "stomach");
    const std::string picture = name + ".png";
    write_colour_png(dress_stomach(stomach, cloth, kClothTexture), folder / picture);
    const fs::path obj = folder / ("stomach_" + name + ".obj");
    write_obj({{"stomach", stomach}}, {name.c_str(), picture.c_str(), "", 0, 5}, obj);
    report(obj, stomach);
}

void write_all(const fs::path& root) {
    const Textured stomach = make_stomach(kOrganTexture);
    const fs::path stomach_obj = write_organ(stomach, subfolder(root, "stomach"));
    write_3ds({{stomach.name, stomach.mesh}}, organ_material(stomach), fs::path(stomach_obj).replace_extension(".3ds"));
    report(stomach_obj, stomach.mesh);
    const Textured liver = make_liver(kOrganTexture);
    report(write_organ(liver, subfolder(root, "liver")), liver.mesh);
    write_cushion(root);
    const Picture denim = make_denim(kFabricTexture), satin = make_satin(kFabricTexture);
    dress(stomach.mesh, denim, "denim", root);
    dress(stomach.mesh, satin, "satin", root);
    write_sheet(denim, root);
    write_skirt(root);
    write_chair(satin, root);
    const fs::path fabrics = subfolder(root, "fabrics");
    write_colour_png(denim, fabrics / "denim.png");
    write_colour_png(satin, fabrics / "satin.png");
}
}  // namespace
}  // namespace dgm::samples

int main(int argc, char** argv) {
    using dgm::model::ExitCode;
    const std::string argument = argc == 2 ? argv[1] : "";
    if (argument == "-h" || argument == "--help") {
        std::puts("usage: dgm-make-samples OUTDIR\nWrites the sample meshes and textures into OUTDIR.");
        return static_cast<int>(ExitCode::kOk);
    }
    if (argument.empty() || argument.front() == '-') {
        std::fputs("usage: dgm-make-samples OUTDIR\n", stderr);
        return static_cast<int>(ExitCode::kUsage);
    }
    try {
        dgm::samples::write_all(argument);
    } catch (const dgm::model::Error& e) {
        std::fprintf(stderr, "dgm-make-samples: %s: %s: %s\n", e.place().c_str(), e.code().id().c_str(), e.what());
        return static_cast<int>(e.code().exit);
    }
    return static_cast<int>(ExitCode::kOk);
}
