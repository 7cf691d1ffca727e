// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/program/main.cpp
// dgm-export: from .dgm or .exr to meshes, pictures and each other.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "export/export_files.h"
#include "export/plain_maps.h"
#include "export/program/export_batch.h"
#include "files/output_file.h"
#include "process/exr_apart.h"
#include "process/hdf5_apart.h"
#include "process/image_apart.h"
#include "process/json_apart.h"
#include "process/mesh_import.h"
#include "tool/guarded_main.h"
#include "tool/tool.h"

namespace {
using dgm::exporter::ExportOptions;

/// CLI11 fills it in: plain text, checked afterwards.
struct CommandLine {
    std::vector<std::string> inputs, asset_roots, paths;
    std::string output, maps, formats, size, view, up = "y", exr_layout = "auto", source, lod = "1", lod_mode;
    std::uint32_t chart = 0;
    bool blank = false;
    CLI::Option* chart_option = nullptr;
    ExportOptions options;
};

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

/// "1,4,16". @throws CLI::ValidationError
std::vector<std::uint32_t> parse_levels(std::string_view text) {
    std::vector<std::uint32_t> out;
    for (std::string_view rest = text;; rest.remove_prefix(1)) {
        const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), out.emplace_back());
        rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
        if (error != std::errc{} || (!rest.empty() && rest.front() != ','))
            throw CLI::ValidationError("--lod", "\"" + std::string(text) + "\" is not like 4 or 1,4,16");
        if (rest.empty()) return out;
    }
}

/// "glb,obj" as extensions. @throws model::Error kUsage
std::vector<std::string> parse_formats(std::string_view text) {
    std::vector<std::string> words, out;
    for (const std::string& extension : dgm::exporter::known_extensions()) words.push_back(extension.substr(1));
    while (!text.empty()) {
        const std::string_view word = text.substr(0, text.find(','));
        text.remove_prefix(std::min(text.size(), word.size() + 1));
        if (std::find(words.begin(), words.end(), word) == words.end())
            throw dgm::model::Error(dgm::model::codes::kUsage,
                                    "--format: " + dgm::tool::unknown_word("format", word, words));
        out.push_back("." + std::string(word));
    }
    return out;
}

constexpr std::array kExamples{
    dgm::tool::Example{"dgm-export stomach.dgm -o stomach.ply", "the surface as a mesh; .obj brings MTL and textures"},
    dgm::tool::Example{"dgm-export stomach.dgm -o stomach.glb", "glTF for engines, with texture and normal map"},
    dgm::tool::Example{"dgm-export baked/ -o web/ --format glb --quantize --compress",
                       "every map of a folder, small, for a page"},
    dgm::tool::Example{"dgm-export robe.dgm -o robe.glb --lod 1,4,16", "three levels of detail in one file"},
    dgm::tool::Example{"dgm-export stomach.dgm liver.dgm -o organs.html",
                       "one page to touch both, from disk, in a browser"},
    dgm::tool::Example{"dgm-export cushion.dgm cover.dgm --cover -o cushion.html",
                       "a cushion, pressed through its cover"},
    dgm::tool::Example{"dgm-export stomach.dgm -o stomach.exr", "lossless, and back again: -o stomach.dgm"},
    dgm::tool::Example{"dgm-export stomach.dgm --maps maps", "pictures for engines: an EXR or PNG a layer, and a JSON"},
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
                                    "dgm-export [OPTIONS] FILE... -o PAGE.html\n"
                                    "dgm-export [OPTIONS] FILE --maps DIR\n"
                                    "dgm-export [OPTIONS] FILE|DIR... [-o DIR] --format F,...",
                                .sections = {},
                                .examples = kExamples,
                                .files = kFiles,
                                .environment = {},
                                .exit_codes =
                                    "0    all files are written\n"
                                    "1    the command line is wrong\n"
                                    "2    a file cannot be read or written\n"
                                    "3    the input is damaged, or no geometry map\n"
                                    "4    internal error, or a library crashed\n"
                                    "5    the input is of a newer version, or the output of an unknown kind\n"
                                    "With several inputs all others are exported, and the code is that of the worst.",
                                .see_also = "dgm-bake(1), dgm-edit(1), dgm-info(1), dgm-validate(1), dgm-bench(1)"};

void describe(CLI::App& app, CommandLine& line) {
    using dgm::tool::Group;
    app.add_option("FILE", line.inputs,
                   "the .dgm or .exr to read; several, folders and patterns with --format or for a page")
        ->type_name("");
    const Group where(app, dgm::tool::kWhereThingsGo), mesh(app, "Meshes"), picture(app, "Pictures");
    where.text("-o,--output", "FILE|DIR", line.output,
               "its ending says what is written: .obj .ply .glb .exr .dgm .png .html; with --format a folder");
    where.text(
        "--format", "F,...", line.formats,
        "obj, ply, glb, exr, dgm, png, html: each input goes into the folder -o [the current one] under its own name");
    where.flag("--blank", line.blank, "HTML: a page without maps, on which .dgm files are dropped; takes no FILE");
    where.text("--maps", "DIR", line.maps,
               "folder for plain maps: an EXR or PNG a layer, and a JSON that describes them");
    line.chart_option = where.number("--chart", "N", line.chart, "only this chart, counted from 0 [all]");
    where.text("--exr-layout", "auto|multipart", line.exr_layout, "EXR: multipart for one part a layer [auto]")
        ->check(CLI::IsMember({"auto", "multipart"}));
    where.flag("--power-of-two", line.options.power_of_two,
               "OBJ, PLY, GLB: sides of textures become the nearest powers of two; plain maps: the next ones");
    mesh.text("--lod", "K,...", line.lod,
              "OBJ, PLY, GLB: K x K quads become one; borders stay closed; GLB: several, such as 1,4,16 [1]");
    mesh.text("--lod-mode", "msft|nodes", line.lod_mode,
              "GLB: where further levels go: extension MSFT_lod, or nodes beside the first [msft]")
        ->check(CLI::IsMember({"msft", "nodes"}));
    mesh.flag("--quantize", line.options.quantize,
              "GLB: KHR_mesh_quantization, half the bytes a vertex; positions to 1/131070 of the size");
    mesh.flag("--compress", line.options.compress, "GLB: EXT_meshopt_compression, lossless; best with --quantize");
    mesh.text("--up", "y|z", line.up, "GLB, PNG, HTML: which axis of the source points up [y]")
        ->check(CLI::IsMember({"y", "z"}));
    mesh.value("--path", "FILE", line.paths,
               "HTML: a recorded tool path (docs/touch.md) that the page plays; repeatable");
    mesh.flag("--cover", line.options.cover, "HTML: the second map lies over the first one, and both are pressed");
    picture.text("--layer", "NAME", line.options.layer, "PNG: the picture of this layer");
    picture.flag("--sheet", line.options.sheet, "PNG: all layers of each chart on one sheet");
    picture.text("--source", "MESH", line.source,
                 "PNG: source, reconstruction, grid and error side by side; HTML: the source beside the map");
    picture.value("--asset-root", "DIR", line.asset_roots,
                  "folder beside the mesh's from which it may name files, as for dgm-bake; repeatable");
    picture.text("--size", "WxH", line.size, "PNG: width and height in pixels");
    picture.text("--view", "YAW,PITCH", line.view, "PNG: direction in degrees [the view that shows most]");
}

/// @throws CLI::ValidationError
void set_levels(CommandLine& line) {
    ExportOptions& options = line.options;
    options.lods = parse_levels(line.lod);
    // A mode makes sense of several levels only: the one that was asked for comes beside the full surface.
    if (!line.lod_mode.empty() && options.lods.size() == 1 && options.lods[0] > 1)
        options.lods.insert(options.lods.begin(), 1);
    if (!line.lod_mode.empty() && options.lods.size() == 1)
        throw CLI::ValidationError("--lod-mode", "name the levels with --lod, such as --lod 1,4,16");
    if (line.lod_mode == "nodes") options.lod_mode = dgm::exporter::LodMode::kNodes;
}

/// @throws CLI::ValidationError
void set_options(CommandLine& line) {
    ExportOptions& options = line.options;
    if (line.chart_option->count() > 0) options.chart = line.chart;
    options.up = line.up == "z" ? dgm::render::UpAxis::kZ : dgm::render::UpAxis::kY;
    if (!line.size.empty()) {
        const auto [width, height] = parse_pair<std::uint32_t>("--size", line.size, 'x', "1280x960");
        options.width = width;
        options.height = height;
    }
    if (!line.view.empty()) {
        const auto [yaw, pitch] = parse_pair<double>("--view", line.view, ',', "30,20");
        if (!(std::abs(yaw) <= 3600 && std::abs(pitch) <= 90))
            throw CLI::ValidationError("--view", "the pitch must be within -90..90 degrees");
        options.view = dgm::render::View{yaw, pitch, options.up};
    }
    set_levels(line);
    options.source = line.source;
    options.paths.assign(line.paths.begin(), line.paths.end());
    dgm::bake::ImportLimits limits;
    limits.asset_roots.assign(line.asset_roots.begin(), line.asset_roots.end());
    options.read_report = dgm::bake::read_map_report;
    options.read_mesh = [limits](const std::filesystem::path& path) { return dgm::bake::import_apart(path, limits); };
    options.multipart = line.exr_layout == "multipart";
}

/// Plain maps of the one input. @throws model::Error
int write_plain_maps(const CommandLine& line, std::string& subject) {
    if (!line.output.empty() || !line.formats.empty() || line.inputs.size() != 1)
        throw dgm::model::Error(dgm::model::codes::kUsage, "--maps takes one file, and neither -o nor --format");
    subject = line.inputs[0];
    const dgm::exporter::PlainMapOptions options{.chart = line.options.chart,
                                                 .power_of_two = line.options.power_of_two};
    const std::filesystem::path input = subject;
    dgm::exporter::export_plain_maps(dgm::exporter::read_maps(input), line.maps, input.stem().string(), options);
    std::printf("%s\n", dgm::model::printable(line.maps).c_str());
    return 0;
}

/// A page that has no map yet. @throws model::Error
int write_blank_page(const CommandLine& line) {
    const std::filesystem::path output = line.output;
    if (!line.inputs.empty() || !line.formats.empty() || dgm::exporter::lower_extension(output) != ".html")
        throw dgm::model::Error(dgm::model::codes::kUsage, "--blank takes -o NAME.html, and neither FILE nor --format");
    dgm::exporter::export_page({}, output, line.options);
    std::printf("%s\n", line.output.c_str());
    return 0;
}

int run(CommandLine& line, std::string& subject) {
    try {
        set_options(line);
    } catch (const CLI::ValidationError& error) { throw dgm::model::Error(dgm::model::codes::kUsage, error.what()); }
    if (line.blank) return write_blank_page(line);
    if (line.inputs.empty())
        throw dgm::model::Error(dgm::model::codes::kUsage, dgm::tool::missing_argument("FILE", kManual));
    if (!line.maps.empty()) return write_plain_maps(line, subject);
    const dgm::exporter::ExportPlan plan =
        dgm::exporter::plan_exports({line.inputs, line.output, parse_formats(line.formats)});
    const std::array<std::filesystem::path, 1> mesh{line.source};
    for (const dgm::exporter::ExportJob& job : plan.jobs)
        for (const std::filesystem::path& output : job.outputs)
            dgm::formats::refuse_input_as_output(output, mesh, "output");
    if (plan.jobs.size() == 1) subject = plan.jobs[0].source.string();
    const dgm::exporter::ExportListener listener{
        [](const std::filesystem::path& output) {
            std::printf("%s\n", dgm::model::printable(output.string()).c_str());
        },
        [](const std::filesystem::path& source, const dgm::model::Error& error) {
            dgm::tool::print_error("dgm-export", source.string(), error);
        },
        [&](const std::string& warning) {
            std::fprintf(stderr, "dgm-export: %s: warning: %s\n", dgm::model::printable(line.source).c_str(),
                         dgm::model::printable(warning).c_str());
        }};
    const dgm::exporter::ExportOutcome outcome = dgm::exporter::run_exports(plan, line.options, listener);
    if (plan.jobs.size() > 1) {
        std::fputs(dgm::model::printable_lines(dgm::exporter::failure_list(outcome)).c_str(), stderr);
        std::printf("%s\n", dgm::model::printable(dgm::exporter::summary_line(outcome)).c_str());
    }
    return static_cast<int>(outcome.exit);
}
}  // namespace

static int run_main(int argc, char** argv) {
    if (const auto exit_code = dgm::bake::import_worker(argc, argv)) return *exit_code;
    CLI::App app(
        "Writes a geometry map as a mesh (obj, ply, glb), a picture (png), a page to touch (html) or the other "
        "container (exr, dgm).");
    CommandLine line;
    describe(app, line);
    return dgm::tool::run_tool("dgm-export", argc, argv, app, kManual, [&](std::string& subject) {
        const dgm::bake::Hdf5Apart hdf5;
        const dgm::bake::ExrApart exr;
        const dgm::bake::ImageApart images;
        const dgm::bake::JsonApart json;
        return run(line, subject);
    });
}

int main(int argc, char** argv) {
    return dgm::tool::guarded_main("dgm-export", [&] { return run_main(argc, argv); });
}
