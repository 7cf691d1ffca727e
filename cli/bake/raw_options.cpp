// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/raw_options.cpp
#include "bake/raw_options.h"

#include <array>
#include <string_view>

#include "baking/materials.h"
#include "baking/option_names.h"
#include "scene/scene_help.h"

namespace dgm::bake {
namespace {

constexpr std::array kExamples{
    tool::Example{"dgm-bake stomach.obj", "bakes stomach.dgm, 257 x 257 samples"},
    tool::Example{
        "dgm-bake models/ -o baked/ --report baked/index.html",
        "bakes a whole folder overnight, to look through in the morning; run again, it bakes only what has changed"},
    tool::Example{"dgm-bake 'models/**/*.obj' -o baked/ -j2", "the same for the files that match, two at a time"},
    tool::Example{"dgm-bake stomach.obj --max-error 0.02%", "takes the smallest grid that is as near to the mesh"},
    tool::Example{"dgm-bake chair.obj --texture denim.png --budget 256KiB",
                  "the most accurate chair in denim whose file is not larger"},
    tool::Example{"dgm-bake models/ -o baked/ --shard 2/8 --report part2.json",
                  "bakes the second of eight parts of the folder, on one of eight machines"},
    tool::Example{"dgm-bake --merge-reports part*.json -o all.json", "puts the parts' reports together"},
    tool::Example{"dgm-bake scene.toml -o baked/", "bakes each asset at the smallest size that its scene allows"}};

constexpr std::array kFiles{
    tool::Term{"NAME.dgm, NAME.exr", "a map; an EXR image holds the same and goes back to the bit"},
    tool::Term{"SCENE.toml", "a scene file, see above"},
    tool::Term{"assets/", "beside the --report in HTML: a page for each mesh"},
    tool::Term{".NAME.PID.tmp", "an output that is being written, beside it; renamed when it is whole"}};

template <class E, std::size_t N>
std::string words(const std::array<NamedValue<E>, N>& table) {
    std::string out;
    for (const auto& row : table) out += (out.empty() ? "" : "|") + std::string(row.name);
    return out;
}

std::string words(const auto& names, const char* separator = "|") {
    std::string out;
    for (const std::string_view name : names) out += (out.empty() ? "" : separator) + std::string(name);
    return out;
}

using tool::Group;

void describe_files(CLI::App& app, Raw& raw) {
    const Group group(app, tool::kWhereThingsGo);
    group.text("-o,--output", "FILE|DIR", raw.output,
               "FILE.dgm or FILE.exr for one mesh, or a folder [the current one]");
    group.text("--format", "F,...", raw.format,
               "dgm, exr or both, and meshes beside them: glb, obj, ply [dgm, or what -o FILE ends in]");
    group.text(
        "--report", "FILE", raw.report,
        "write what happened to each mesh, with all errors measured, to this file; FILE.html: a page to look at, with "
        "one for each mesh in the folder assets beside it");
    group.text("--report-format", "json|html", raw.report_format, "of that file [html if it ends in .html, else json]");
    group.flag("--prune", raw.prune,
               "remove maps of ours from the output folder whose mesh is gone from the folders named, or has another "
               "output now; without it they are listed");
    group.text("-M,--depfile", "FILE", raw.depfile,
               "(also -MF FILE) write which files each output was made from, for Make and Ninja");
}

void describe_grid(CLI::App& app, Raw& raw) {
    const Group group(app, "How fine");
    group.text("--size", "MxN", raw.size,
               "samples of the largest chart, MxN or N; auto:N: the best m x n with at most N samples [257x257; long "
               "bodies, tubes and skirts: another m x n]");
    group.text(
        "--max-error", "X", raw.max_error,
        "the smallest grid whose measured error is at most X% of the diagonal, or X in the mesh's units; --size is "
        "the largest grid tried then [auto:4198401]");
    group.text("--max-error-kind", words(kErrorKindNames), raw.max_error_kind, "the error meant [rms]");
    group.text(
        "--budget", "SIZE", raw.budget,
        "the grid with the least error whose .dgm is not larger than SIZE, such as 256KiB; --size is the largest "
        "grid tried then [auto:4198401]");
    group.text("--precision", words(kPrecisionNames), raw.precision, "of positions; u16 takes half the space [f32]");
}

void describe_layers(CLI::App& app, Raw& raw) {
    const Group group(app, "Layers and textures");
    group.text("--layers", "L,...", raw.layers,
               "comma-separated: " + words(kLayerNames, ", ") + " [all that have data]; geometry is always there");
    group.text("--texture", "FILE", raw.texture, "image that replaces the materials' textures");
    group.value("--asset-root", "DIR", raw.asset_roots,
                "folder beside the mesh's from which it may name materials, textures and buffers, such as a shared "
                "library; repeatable");
    group.text("--texture-size", "MxN", raw.texture_size,
               "pixels of the texture layer, MxN or N [two a grid step; one if there is no picture]");
    group.text("--bump-size", "MxN", raw.bump_size, "heights of the bump layer, MxN or N [two a grid step]");
    group.text("--unit", words(kUnitNames), raw.unit,
               "length of a unit of the mesh, for physics [not said: programs have to ask]");
    group.text("--material", words(kMaterialNames) + "|FILE.toml", raw.material,
               "what the body is made of, for physics; needs --unit [not said]");
    group.text("--exr-layout", words(kExrLayoutNames), raw.exr_layout,
               "auto: one part where sizes agree; multipart: one part a layer [auto]");
}

void describe_map(CLI::App& app, Raw& raw) {
    const Group group(app, "How the surface is laid out");
    group.text("--method", words(kMethodNames), raw.method, "auto tries those that fit and keeps the best [auto]");
    group.text("--domain", words(kDomainNames), raw.domain,
               "square: every sample on the surface; free: any shape, with a mask [auto]");
    group.text(
        "--fit", words(kFitNames), raw.fit,
        "sample: samples lie on the surface; l2: they slide to where the error is least; best: more rounds of that, "
        "then for the largest error [l2]");
    Group(app, "Experiments")
        .text("--ablate", "PART,...", raw.ablate,
              "leave parts out, to see what they are worth: " + words(kAblateNames, ", ") + "; the result is worse");
}

void describe_run(CLI::App& app, Raw& raw) {
    const Group group(app, tool::kHowItRuns);
    group.number("-j,--jobs", "N", raw.jobs, "meshes baked at a time, as far as memory reaches [one a core]");
    group.flag("--force", raw.force, "bake what is up to date, too, and replace maps that dgm-edit has painted");
    group.number("--time-limit", "S", raw.time_limit, "seconds one mesh may take [600]");
    group.text("--memory-limit", "SIZE", raw.memory_limit,
               "memory one mesh may take, such as 4GiB; 0: no limit [8GiB]");
    group.flag("--keep-going", raw.keep_going, "bake the others after a failure [the default]");
    group.flag("--stop-on-error", raw.stop_on_error, "start no other mesh after a failure");
    group.flag("--dry-run", raw.dry_run, "print which mesh would become which file, and bake nothing");
    group.text("--shard", "I/N", raw.shard,
               "bake only part I of N, for N machines; a mesh stays in its part when others are added");
    group.flag(
        "--merge-reports", raw.merge_reports,
        "put the reports named as INPUT together into -o FILE, JSON, or .html with a page for each mesh; bake nothing");
}

void describe_messages(CLI::App& app, Raw& raw) {
    const Group group(app, tool::kWhatItTells);
    group.text("--progress", "auto|bar|plain|none", raw.progress, "auto: a bar on a terminal, else plain lines [auto]");
    group.flag("-v,--verbose", raw.verbose, "repairs, warnings, charts and times, too");
    group.flag("-q,--quiet", raw.quiet, "failures only");
}

}  // namespace

tool::Manual manual() {
    return {.synopsis =
                "dgm-bake [OPTIONS] INPUT... [-o FILE|DIR]\n"
                "dgm-bake [OPTIONS] SCENE.toml [-o DIR]\n"
                "dgm-bake --merge-reports REPORT... [-o REPORT]",
            .sections = scene::kSceneSections,
            .examples = kExamples,
            .files = kFiles,
            .environment = {},
            .exit_codes =
                "0    all is baked, or was up to date\n"
                "1    the command line is wrong\n"
                "2    a file cannot be read or written\n"
                "3    a mesh was refused, or took too much time or memory\n"
                "4    internal error, or a library crashed\n"
                "5    something asked for is not supported\n"
                "75   trouble that may pass (full disk, killed worker): run it again\n"
                "130  interrupted: run it again, it goes on where it stopped\n"
                "A batch bakes all it can and returns its worst, in the order 130, 75, 4, 2, 3, 5.",
            .see_also = "dgm-info(1), dgm-validate(1), dgm-export(1), dgm-edit(1), dgm-bench(1)"};
}

void describe(CLI::App& app, Raw& raw) {
    app.description("Bakes meshes into deformable geometry maps.");
    app.option_defaults()->always_capture_default(false);
    app.add_option("INPUT", raw.inputs,
                   "mesh files of any format the importer reads; folders, searched recursively for meshes; "
                   "patterns in quotes, such as 'models/**/*.obj'; or one scene file")
        ->type_name("");
    describe_files(app, raw);
    describe_grid(app, raw);
    describe_layers(app, raw);
    describe_map(app, raw);
    describe_run(app, raw);
    describe_messages(app, raw);
    tool::present(app, "dgm-bake", manual());
}

}  // namespace dgm::bake
