// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/main.cpp
// dgm-edit: puts painted layers back into a .dgm.
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include "edit/edit_map.h"
#include "process/exr_apart.h"
#include "process/hdf5_apart.h"
#include "process/image_apart.h"
#include "process/json_apart.h"
#include "tool/guarded_main.h"
#include "tool/tool.h"

namespace {
using dgm::tool::Example;
using dgm::tool::Term;

constexpr std::array kExamples{
    Example{"dgm-edit stomach.dgm --from painted.exr", "what was painted in the layers of dgm-export -o painted.exr"},
    Example{"dgm-edit stomach.dgm --from maps/", "the pictures of dgm-export --maps maps, EXR or PNG"},
    Example{"dgm-edit stomach.dgm --from maps/stomach_stiffness.png", "one of them"},
    Example{"dgm-edit stomach.dgm --from painted.dgm -o new.dgm", "layers of a copy that h5py has changed"},
    Example{"dgm-edit painted.dgm --repair", "the same where the map as it was is lost"},
    Example{"dgm-edit new.dgm --from old.dgm --layer stiffness --layer mobility",
            "paint of an earlier bake of the same size"},
    Example{"dgm-edit stomach.dgm --from painted.exr --dry-run", "how many samples would change, and by how much"}};
constexpr std::array kFiles{Term{"NAME.dgm", "a map; read, and written aside before it is replaced"},
                            Term{"NAME.exr, NAME.LAYER.exr", "layers as dgm-export writes them"},
                            Term{"DIR/NAME_maps.json", "says what plain maps hold, and in which range"}};
const dgm::tool::Manual kManual{.synopsis =
                                    "dgm-edit [OPTIONS] MAP.dgm --from FILE|DIR\n"
                                    "dgm-edit [OPTIONS] MAP.dgm --repair",
                                .sections = {},
                                .examples = kExamples,
                                .files = kFiles,
                                .environment = {},
                                .exit_codes =
                                    "0    the edit is in the map, or there was none\n"
                                    "1    the command line is wrong\n"
                                    "2    a file cannot be read or written\n"
                                    "3    the edit changes what may not be edited, does not fit, or a file is damaged\n"
                                    "4    internal error\n"
                                    "5    the map is of a newer version\n"
                                    "75   the disk is full, or failed for the moment\n"
                                    "Unless the code is 0, no file has changed.",
                                .see_also = "dgm-export(1), dgm-bake(1), dgm-validate(1), dgm-info(1)"};

struct CommandLine {
    std::string map, from, output;
    dgm::edit::EditOptions options;
};

void describe(CLI::App& app, CommandLine& line) {
    using dgm::tool::Group;
    app.add_option("MAP.dgm", line.map, "the map to change")->required()->type_name("");
    const Group what(app, "What it takes"), where(app, dgm::tool::kWhereThingsGo);
    what.text("--from", "FILE|DIR", line.from,
              "what was painted: an EXR of layers, plain maps (a folder or one picture), or a .dgm");
    what.value("--layer", "NAME", line.options.layers,
               "only this one, such as stiffness, mobility, bump or texture; several times for several [all]")
        ->allow_extra_args(false);  // or it would take MAP.dgm for another one
    what.flag("--repair", line.options.repair,
              "trust the layers of MAP.dgm that differ from their hashes, such as by h5py");
    where.text("-o,--output", "FILE", line.output, "the new map [MAP.dgm itself]");
    where.flag("--dry-run", line.options.dry_run, "tell what would change, and write nothing");
}

int run(CommandLine& line, std::string& subject) {
    namespace codes = dgm::model::codes;
    if (line.from.empty() == !line.options.repair)
        throw dgm::model::Error(codes::kUsage,
                                line.from.empty()
                                    ? "--from is required; for instance: dgm-edit stomach.dgm --from painted.exr"
                                    : "--repair goes without --from");
    if (!line.output.empty() && !line.output.ends_with(".dgm"))
        throw dgm::model::Error(codes::kUsage, "the output \"" + line.output + "\" must end in .dgm");
    subject = line.map;
    line.options.map = line.map;
    line.options.source = line.from;
    line.options.output = line.output;
    const dgm::edit::EditOutcome outcome = dgm::edit::edit_map(line.options);
    std::fputs(outcome.lines.c_str(), stdout);
    const std::string& output = line.output.empty() ? line.map : line.output;
    if (outcome.is_written)
        std::printf("%s\n", output.c_str());
    else
        std::printf("%s: %s\n", output.c_str(), outcome.is_changed ? "would be written" : "nothing to change");
    return 0;
}
}  // namespace

static int run_main(int argc, char** argv) {
    CLI::App app("Puts painted layers back into a geometry map: stiffness, mobility, bump, texture.");
    CommandLine line;
    describe(app, line);
    return dgm::tool::run_tool("dgm-edit", argc, argv, app, kManual, [&](std::string& subject) {
        const dgm::bake::Hdf5Apart hdf5;
        const dgm::bake::ExrApart exr;
        const dgm::bake::ImageApart images;
        const dgm::bake::JsonApart json;
        return run(line, subject);
    });
}

int main(int argc, char** argv) {
    return dgm::tool::guarded_main("dgm-edit", [&] { return run_main(argc, argv); });
}
