// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/main.cpp
// dgm-export: from .dgm or .exr to meshes, pictures and each other.
#include <array>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "export/export_files.h"
#include "export/plain_maps.h"
#include "process/hdf5_apart.h"
#include "process/mesh_import.h"
#include "tool/tool.h"

namespace {
using dgm::exporter::ExportOptions;
using dgm::exporter::PlainMapOptions;

/// Two numbers with `separator` between them and nothing else. @throws CLI::ValidationError
template <class Number>
std::pair<Number, Number> parse_pair(const std::string& option, std::string_view text, char separator,
                                     const std::string& example) {
    std::pair<Number, Number> out{};
    const std::size_t middle = text.find(separator);
    const auto whole = [](std::string_view part, Number& number) {
        const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
        return error == std::errc{} && end == part.data() + part.size();
    };
    if (middle == std::string_view::npos || !whole(text.substr(0, middle), out.first) ||
        !whole(text.substr(middle + 1), out.second))
        throw CLI::ValidationError(option, "\"" + std::string(text) + "\" is not like " + example);
    return out;
}

/// @throws model::Error kUsage
void check_outputs(const std::string& output, const std::string& maps_folder, const PlainMapOptions& map_options) {
    if (output.empty() == maps_folder.empty())
        throw dgm::model::Error(dgm::model::codes::kUsage, "one of -o and --maps says where to write");
    if (map_options.power_of_two && maps_folder.empty())
        throw dgm::model::Error(dgm::model::codes::kUsage, "--power-of-two goes with --maps");
}

int write_plain_maps(const dgm::model::MapSet& maps, const std::filesystem::path& input, const std::string& folder,
                     const PlainMapOptions& map_options) {
    dgm::exporter::export_plain_maps(maps, folder, input.stem().string(), map_options);
    std::printf("%s\n", folder.c_str());
    return 0;
}

constexpr std::array kExamples{
    dgm::tool::Example{"dgm-export stomach.dgm -o stomach.ply", "the surface as a mesh; .obj brings MTL and textures"},
    dgm::tool::Example{"dgm-export stomach.dgm -o stomach.glb", "glTF for engines, with texture and normal map"},
    dgm::tool::Example{"dgm-export stomach.dgm -o stomach.exr", "lossless, and back again: -o stomach.dgm"},
    dgm::tool::Example{"dgm-export stomach.dgm --maps maps", "pictures for engines: position, normal, texture, ..."},
    dgm::tool::Example{"dgm-export stomach.dgm -o layers.png --sheet", "all layers as pictures on one sheet"},
    dgm::tool::Example{"dgm-export stomach.dgm -o compare.png --source stomach.obj",
                       "source, reconstruction, grid and error side by side"}};
constexpr std::array kFiles{
    dgm::tool::Term{"NAME.dgm, NAME.exr", "a map; read, or written without loss"},
    dgm::tool::Term{"NAME.mtl, NAME*.png", "beside an OBJ: its materials and textures"},
    dgm::tool::Term{"DIR/LAYER.exr, .png, maps.json", "plain maps (--maps), and what their numbers mean"},
    dgm::tool::Term{".NAME.*", "a folder beside the output, for what is being written; removed at the end"}};
const dgm::tool::Manual kManual{.synopsis =
                                    "dgm-export [OPTIONS] FILE -o OUTPUT\n"
                                    "dgm-export [OPTIONS] FILE --maps DIR",
                                .sections = {},
                                .examples = kExamples,
                                .files = kFiles,
                                .environment = {},
                                .exit_codes =
                                    "0    the file is written\n"
                                    "1    the command line is wrong\n"
                                    "2    a file cannot be read or written\n"
                                    "3    the input is damaged, or no geometry map\n"
                                    "4    internal error, or a library crashed\n"
                                    "5    the input is of a newer version, or the output of an unknown kind",
                                .see_also = "dgm-bake(1), dgm-info(1), dgm-validate(1), dgm-bench(1)"};

}  // namespace

int main(int argc, char** argv) {
    if (const auto exit_code = dgm::bake::import_worker(argc, argv)) return *exit_code;
    CLI::App app("Writes a geometry map as a mesh (obj, ply, glb), a picture (png) or the other container (exr, dgm).");
    std::string input, output, size, view, up = "y", exr_layout = "auto", source, maps_folder;
    std::uint32_t chart = 0;
    ExportOptions options;
    PlainMapOptions map_options;
    using dgm::tool::Group;
    app.add_option("FILE", input, "the .dgm or .exr to read")->required()->type_name("");
    const Group where(app, dgm::tool::kWhereThingsGo), mesh(app, "Meshes"), picture(app, "Pictures");
    where.text("-o,--output", "FILE", output, "its ending says what is written: .obj .ply .glb .exr .dgm .png");
    where.text("--maps", "DIR", maps_folder,
               "folder for plain maps: an EXR or PNG a layer, and a JSON that describes them");
    CLI::Option* chart_option = where.number("--chart", "N", chart, "only this chart, counted from 0 [all]");
    where.text("--exr-layout", "auto|multipart", exr_layout, "EXR: multipart for one part a layer [auto]")
        ->check(CLI::IsMember({"auto", "multipart"}));
    mesh.number("--lod", "K", options.lod, "OBJ, PLY, GLB: K x K quads become one; borders stay closed [1]");
    mesh.text("--up", "y|z", up, "GLB, PNG: which axis of the source points up [y]")->check(CLI::IsMember({"y", "z"}));
    Group(app, "Plain maps")
        .flag("--power-of-two", map_options.power_of_two, "raise each side to the next power of two");
    picture.text("--layer", "NAME", options.layer, "PNG: the picture of this layer");
    picture.flag("--sheet", options.sheet, "PNG: all layers of each chart on one sheet");
    picture.text("--source", "MESH", source, "PNG: source, reconstruction, grid and error side by side");
    picture.text("--size", "WxH", size, "PNG: width and height in pixels");
    picture.text("--view", "YAW,PITCH", view, "PNG: direction in degrees [the view that shows most]");

    return dgm::tool::run_tool("dgm-export", argc, argv, app, kManual, [&](std::string& subject) {
        const dgm::bake::Hdf5Apart hdf5;
        try {
            if (chart_option->count() > 0) options.chart = chart;
            options.up = up == "z" ? dgm::render::UpAxis::kZ : dgm::render::UpAxis::kY;
            if (!size.empty()) {
                const auto [width, height] = parse_pair<std::uint32_t>("--size", size, 'x', "1280x960");
                options.width = width, options.height = height;
            }
            if (!view.empty()) {
                const auto [yaw, pitch] = parse_pair<double>("--view", view, ',', "30,20");
                if (!(std::abs(yaw) <= 3600 && std::abs(pitch) <= 90))
                    throw CLI::ValidationError("--view", "the pitch must be within -90..90 degrees");
                options.view = dgm::render::View{yaw, pitch, options.up};
            }
        } catch (const CLI::ValidationError& error) {
            throw dgm::model::Error(dgm::model::codes::kUsage, error.what());
        }
        check_outputs(output, maps_folder, map_options);
        options.source = source;
        options.read_mesh = [](const std::filesystem::path& path) { return dgm::bake::import_apart(path); };
        options.multipart = exr_layout == "multipart";
        subject = input;
        const dgm::model::MapSet maps = dgm::exporter::read_maps(input);
        map_options.chart = options.chart;
        if (!maps_folder.empty()) return write_plain_maps(maps, input, maps_folder, map_options);
        dgm::exporter::export_maps(maps, output, options, [&](const std::string& warning) {
            std::fprintf(stderr, "dgm-export: %s: warning: %s\n", source.c_str(), warning.c_str());
        });
        std::printf("%s\n", output.c_str());
        return 0;
    });
}
