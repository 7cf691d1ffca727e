// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/make_tool_corpus.cpp
// make_tool_corpus FOLDER: writes the seeds of corpus/dgm, exr and message: whole files of the writers, kept small.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>

#include "dgm/dgm_writer.h"
#include "exr/exr_writer.h"
#include "model/codes.h"
#include "unit/validate/validation_maps.h"
#include "worker/worker_protocol.h"

namespace {
namespace fs = std::filesystem;
using namespace dgm;

void write_text(const fs::path& path, std::string text) {
    if (!text.empty() && text.back() == '\n') text.pop_back();  // a message as its reader gets it
    std::ofstream(path, std::ios::binary) << text;
}

void write_all(const fs::path& folder) {
    for (const char* part : {"dgm", "exr", "message"}) fs::create_directories(folder / part);
    const model::MapSet both = test::good_maps();
    for (std::size_t k = 0; k < both.charts.size(); ++k) {
        model::MapSet one = both;
        one.charts = {both.charts[k]};
        const std::string name = k == 0 ? "square" : "free";
        formats::write_dgm(one, folder / "dgm" / (name + ".dgm"));
        // Layers of another size stand in files of their own; a seed is one file.
        std::erase_if(one.charts[0].layers, [](const auto& l) { return l.name == "texture" || l.name == "bump"; });
        formats::write_exr(one, folder / "exr" / (name + ".exr"));
        formats::write_exr(one, folder / "exr" / (name + "_multipart.exr"), {formats::ExrLayout::kMultipart});
    }
    const fs::path messages = folder / "message";
    write_text(messages / "progress", encode(bake::WorkerMessage{bake::ProgressMessage{"fit", 0.25}}));
    write_text(messages / "memory", encode(bake::WorkerMessage{bake::OutOfMemoryMessage{}}));
    write_text(messages / "error", encode(bake::WorkerMessage{bake::ErrorMessage{
                                       model::Error(model::codes::kImportFailed, "no sense in line 3", "a.obj:3")}}));
    bake::BakeReport report;
    report.source_name = "tube.obj";
    report.repairs = {{"welded vertices", 16}};
    report.warnings = {"texture missing: skin.png"};
    report.charts.resize(1);
    report.charts[0].candidates.push_back({"arap", 61.5, "higher error", 0.5});
    report.search.emplace();
    report.search->trials.push_back({33, 33, 0.1, 0.2, 4096, "holds", 0.1});
    report.times.push_back({"fit", 0.5, 0.4});
    write_text(messages / "result", encode(bake::WorkerMessage{bake::ResultMessage{report, {}}}));
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 1;
    try {
        write_all(argv[1]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "make_tool_corpus: %s\n", error.what());
        return 1;
    }
    return 0;
}
