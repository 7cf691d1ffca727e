// SPDX-License-Identifier: GPL-3.0-or-later
// cli/info/main.cpp
// dgm-info: what is in a .dgm.
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "info/file_info.h"
#include "info/map_diff.h"
#include "process/exr_apart.h"
#include "process/hdf5_apart.h"
#include "process/json_apart.h"
#include "scene/scene_help.h"
#include "scene/scene_plan.h"
#include "tool/guarded_main.h"
#include "tool/tool.h"

namespace {
constexpr std::array kExamples{
    dgm::tool::Example{"dgm-info stomach.dgm", "charts, layers, and the measured errors"},
    dgm::tool::Example{"dgm-info baked/*.dgm --json", "the same of many files, for programs"},
    dgm::tool::Example{"dgm-info --diff old.dgm new.dgm", "what a change of settings, tool or mesh did to a map"},
    dgm::tool::Example{"dgm-info scene.toml", "what dgm-bake would make of a scene file"}};
constexpr std::array kFiles{dgm::tool::Term{"NAME.dgm", "a map; dgm-export makes one of an EXR image"},
                            dgm::tool::Term{"SCENE.toml", "a scene file, see above"}};
const dgm::tool::Manual kManual{
    .synopsis = "dgm-info [OPTIONS] FILE...\ndgm-info SCENE.toml...\ndgm-info --diff OLD.dgm NEW.dgm",
    .sections = dgm::scene::kSceneSections,
    .examples = kExamples,
    .files = kFiles,
    .environment = {},
    .exit_codes =
        "0    all files were read\n"
        "1    the command line is wrong\n"
        "2    a file cannot be read or written\n"
        "3    a file is no .dgm, or damaged\n"
        "4    internal error\n"
        "5    a file is of a newer version\n"
        "7    --diff: the two differ\n"
        "With several files, that of the worst.",
    .see_also = "dgm-bake(1), dgm-validate(1), dgm-export(1), dgm-edit(1), dgm-bench(1)"};

int print_difference(const std::vector<std::string>& files, bool json, std::string& subject) {
    if (files.size() != 2) throw dgm::model::Error(dgm::model::codes::kUsage, "--diff takes two files");
    std::array<dgm::model::MapSet, 2> maps;
    for (std::size_t k = 0; k < 2; ++k) {
        subject = files[k];
        maps[k] = dgm::info::read_maps(files[k]);
    }
    const dgm::info::MapDifference found = dgm::info::difference(maps[0], maps[1]);
    std::fputs((json ? dgm::info::to_json(found) : dgm::info::to_text(found)).c_str(), stdout);
    return static_cast<int>(found.empty() ? dgm::model::ExitCode::kOk : dgm::model::ExitCode::kDiffers);
}
}  // namespace

static int run_main(int argc, char** argv) {
    CLI::App app("Prints what a .dgm holds: charts, layers, measured errors.");
    std::vector<std::string> files;
    bool json = false, diff = false;
    app.add_option("FILE", files, "maps to read, .dgm or .exr; scene files, to see their plan")
        ->required()
        ->type_name("");
    dgm::tool::Group(app, "What it shows")
        .flag("--diff", diff, "what two files differ in: layers, numbers, how far samples moved");
    dgm::tool::Group(app, dgm::tool::kWhatItTells).flag("--json", json, "JSON for programs, instead of text");

    return dgm::tool::run_tool("dgm-info", argc, argv, app, kManual, [&](std::string& subject) {
        const dgm::bake::Hdf5Apart hdf5;
        const dgm::bake::ExrApart exr;
        const dgm::bake::JsonApart json_parser;
        if (diff) return print_difference(files, json, subject);
        std::vector<dgm::info::FileInfo> infos;
        dgm::model::ExitCode worst = dgm::model::ExitCode::kOk;
        for (const std::string& file : files) {
            subject = file;
            try {
                if (file.ends_with(".toml")) {
                    if (json)
                        throw dgm::model::Error(dgm::model::codes::kUnsupported,
                                                "--json is not available for scene files");
                    std::fputs(dgm::scene::plan_text(dgm::scene::read_scene(file)).c_str(), stdout);
                    continue;
                }
                infos.push_back(dgm::info::read_file_info(file));
                if (!json) std::fputs(dgm::info::to_text(infos.back()).c_str(), stdout);
                if (const auto& fault = infos.back().fault)
                    dgm::tool::print_error(
                        "dgm-info", file,
                        dgm::model::Error(fault->code(), std::string("dgm-validate refuses this map: ") + fault->what(),
                                          fault->place()));
            } catch (const dgm::model::Error& error) {  // the other files are still worth telling about
                dgm::tool::print_error("dgm-info", file, error);
                worst = dgm::model::worse(worst, error.code().exit);
            }
        }
        if (json) std::fputs(dgm::info::to_json(infos).c_str(), stdout);
        return static_cast<int>(worst);
    });
}

int main(int argc, char** argv) {
    return dgm::tool::guarded_main("dgm-info", [&] { return run_main(argc, argv); });
}
