// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/program/export_batch.cpp
#include "export/program/export_batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <system_error>

#include "batch/file_pattern.h"
#include "exr/exr_files.h"
#include "files/folder_list.h"
#include "files/io_failure.h"
#include "model/codes.h"
#include "model/shortage.h"
#include "validate/validation.h"
#include "worker/output_files.h"

namespace dgm::exporter {
namespace {
namespace fs = std::filesystem;
namespace codes = model::codes;

struct Found {
    fs::path source;
    fs::path stem;   ///< output path without extension, before collisions are settled
    fs::path group;  ///< folder name that tells it from its namesakes
};

bool is_map(const fs::path& file) {
    const std::string extension = lower_extension(file);
    return extension == ".dgm" || extension == ".exr";
}

fs::path true_path(const fs::path& path) {
    std::error_code error;
    fs::path out = fs::weakly_canonical(path, error);
    return error ? fs::absolute(path).lexically_normal() : out;
}

fs::path folder_name(const fs::path& folder) {
    const fs::path full = true_path(folder.empty() ? fs::path(".") : folder);
    return (full.has_filename() ? full : full.parent_path()).filename();
}

/// Where the inputs lead, and what of them leads nowhere.
struct Search {
    std::vector<Found> found;
    std::vector<std::pair<std::size_t, ExportJob>> refused;  ///< and how many maps were found before
    std::set<fs::path> seen;                                 ///< canonical
    bool many = false;                                       ///< a folder or a pattern is among the inputs

    void add(const fs::path& source, fs::path stem, const fs::path& group) {
        if (seen.insert(true_path(source)).second) found.push_back({source, stem.replace_extension(), group});
    }
    void refuse(const fs::path& input, const model::Error& error) {
        refused.emplace_back(found.size(), ExportJob{input, {}, {}, error});
    }
    void add_below(const fs::path& folder, const std::vector<fs::path>& files, const fs::path& input,
                   const char* nothing) {
        many = true;
        std::size_t taken = 0;
        for (const fs::path& relative : files) {
            if (!is_map(relative) || formats::is_exr_side_file(folder / relative)) continue;
            ++taken;
            add(folder / relative, relative, folder_name(folder));
        }
        if (taken == 0) refuse(input, {codes::kFileMissing, nothing});
    }
    void try_add(const fs::path& input) {
        try {
            add_input(input);
        } catch (const model::Error& error) { refuse(input, error); }
    }
    void add_input(const fs::path& input) {
        const fs::file_status status = formats::look_at(input);
        if (fs::is_directory(status))
            return add_below(input, formats::files_below(input), input, "the folder holds no maps");
        if (!fs::exists(status) && bake::is_pattern(input.native())) {
            const auto [folder, matches] = bake::files_matching(input);
            return add_below(folder, matches, input, "no map (.dgm, .exr) matches the pattern");
        }
        if (!fs::exists(status)) return refuse(input, {codes::kFileMissing, "there is no such file or folder"});
        add(input, input.filename(), folder_name(input.parent_path()));
    }
};

/// Output paths without extension. robe.exr beside robe.dgm keeps its own; namesakes go below their groups.
std::vector<fs::path> settled_stems(const std::vector<Found>& found) {
    const auto place = [](const Found& f) { return true_path(f.source).replace_extension(); };
    std::set<fs::path> dgm;
    for (const Found& f : found)
        if (lower_extension(f.source) == ".dgm") dgm.insert(place(f));
    std::vector<fs::path> out;
    for (const Found& f : found) {
        fs::path& stem = out.emplace_back(f.stem);
        if (lower_extension(f.source) != ".dgm" && dgm.contains(place(f))) stem += f.source.extension();
    }
    std::map<fs::path, std::size_t> count;
    for (const fs::path& stem : out) ++count[stem];
    for (std::size_t k = 0; k < out.size(); ++k)
        if (count[out[k]] > 1) out[k] = found[k].group / out[k];
    std::map<fs::path, std::size_t> owner;
    for (std::size_t k = 0; k < out.size(); ++k)
        if (const auto [other, is_new] = owner.try_emplace(out[k], k); !is_new)
            throw model::Error(
                codes::kUsage,
                fmt::format("{} and {} would both become {}; export them into different folders",
                            found[other->second].source.string(), found[k].source.string(), out[k].string()));
    return out;
}

/// The only output, if -o names one.
std::optional<fs::path> only_output(const ExportRequest& request, const Search& search) {
    std::error_code ignored;
    const bool folder =
        request.output.empty() || request.output.back() == '/' || fs::is_directory(request.output, ignored);
    const std::vector<std::string>& known = known_extensions();
    const bool names_file =
        !folder && std::find(known.begin(), known.end(), lower_extension(request.output)) != known.end();
    if (folder && request.formats.empty())
        throw model::Error(codes::kUsage,
                           request.output.empty()
                               ? "say what to write: -o FILE, --maps DIR, or --format glb for every input"
                               : "-o is a folder: say what to write with --format, such as --format glb");
    if (folder || (!names_file && !request.formats.empty())) return std::nullopt;
    if (!request.formats.empty())
        throw model::Error(codes::kUsage, "-o names a file, and --format goes with a folder; leave one out");
    if (search.found.empty()) return request.output;  // nothing to write: the inputs' faults are reported
    if (lower_extension(request.output) != ".html" && (search.many || request.inputs.size() > 1))
        throw model::Error(codes::kUsage,
                           "one output file cannot hold several maps; name a folder with -o, and what to write with "
                           "--format",
                           request.output);
    return request.output;
}

void check_inputs_kept(const ExportPlan& plan, const std::set<fs::path>& inputs) {
    for (const ExportJob& job : plan.jobs)
        for (const fs::path& output : job.outputs)
            if (inputs.contains(true_path(output)))
                throw model::Error(codes::kUsage, "the output would overwrite an input", output.string());
}

/// `options` without what a file of this kind knows nothing of.
ExportOptions options_of_kind(ExportOptions options, const std::string& extension) {
    const ExportOptions none;
    const bool glb = extension == ".glb", mesh = glb || extension == ".obj" || extension == ".ply";
    if (!glb) options.quantize = options.compress = false;
    if (!glb && options.lods.size() > 1) options.lods = none.lods;
    if (!mesh) {
        options.lods = none.lods;
        options.power_of_two = false;
    }
    if (extension != ".exr") options.multipart = false;
    if (extension == ".png") return options;
    options.layer.clear(), options.source.clear();
    options.sheet = false;
    options.width = options.height = std::nullopt;
    options.view = std::nullopt;
    return options;
}

/// What dgm-validate refuses is not passed on to programs that check less.
model::MapSet read_sound_maps(const fs::path& file) {
    model::MapSet maps = read_maps(file);
    if (const std::optional<model::Error> error = validate::first_error(maps)) throw *error;
    return maps;
}

std::vector<NamedMaps> maps_of(const ExportJob& job) {
    std::vector<NamedMaps> out{{job.source.stem().string(), read_sound_maps(job.source)}};
    for (const fs::path& other : job.others) out.push_back({other.stem().string(), read_sound_maps(other)});
    return out;
}

/// The error of the exception at hand. Call it in a catch block alone.
model::Error caught() {
    try {
        throw;
    } catch (const model::Error& error) { return error; } catch (const std::exception& error) {
        return model::error_of(error);
    }
}
}  // namespace

ExportPlan plan_exports(const ExportRequest& request) {
    Search search;
    for (const std::string& input : request.inputs) search.try_add(input);
    ExportPlan plan;
    if (const std::optional<fs::path> file = only_output(request, search)) {
        plan.folder = file->has_parent_path() ? file->parent_path() : fs::path(".");
        for (const Found& f : search.found) {
            if (plan.jobs.empty())
                plan.jobs.push_back({f.source, {*file}, {}, {}});
            else
                plan.jobs[0].others.push_back(f.source);
        }
    } else {
        plan.folder = request.output.empty() ? fs::path(".") : fs::path(request.output);
        const std::vector<fs::path> stems = settled_stems(search.found);
        for (std::size_t k = 0; k < stems.size(); ++k) {
            ExportJob& job = plan.jobs.emplace_back(ExportJob{search.found[k].source, {}, {}, {}});
            const fs::path stem = request.output.empty() ? stems[k] : plan.folder / stems[k];
            for (const std::string& format : request.formats) job.outputs.push_back(fs::path(stem).concat(format));
        }
        plan.make_folder = !stems.empty();
    }
    check_inputs_kept(plan, search.seen);
    for (std::size_t k = search.refused.size(); k-- > 0;)
        plan.jobs.insert(plan.jobs.begin() + static_cast<std::ptrdiff_t>(search.refused[k].first),
                         search.refused[k].second);
    return plan;
}

ExportOutcome run_exports(const ExportPlan& plan, const ExportOptions& options, const ExportListener& listener) {
    ExportOutcome outcome;
    bake::OutputFolders folders;
    const auto fail = [&](const ExportJob& job, const model::Error& error) {
        listener.on_failure(job.source, error);
        outcome.exit = model::worse(outcome.exit, error.code().exit);
        outcome.failures.emplace_back(job.source, error);
    };
    if (plan.make_folder) folders.make(plan.folder);
    for (const ExportJob& job : plan.jobs) {
        try {
            if (job.refusal) throw *job.refusal;
            if (!job.others.empty()) {
                export_page(maps_of(job), job.outputs[0], options);
                listener.on_written(job.outputs[0]);
                ++outcome.exported;
                continue;
            }
            const model::MapSet maps = read_sound_maps(job.source);
            for (const fs::path& output : job.outputs) {
                folders.make_below(plan.folder, output);
                export_maps(maps, output,
                            job.outputs.size() > 1 ? options_of_kind(options, lower_extension(output)) : options,
                            listener.on_warning);
                listener.on_written(output);
            }
            ++outcome.exported;
        } catch (...) { fail(job, caught()); }
    }
    return outcome;
}

std::string failure_list(const ExportOutcome& outcome) {
    const std::size_t all = outcome.exported + outcome.failures.size();
    if (outcome.failures.empty()) return {};
    std::string out = fmt::format("dgm-export: {} of {} maps failed:\n", outcome.failures.size(), all);
    for (const auto& [source, error] : outcome.failures)
        out += fmt::format("  {}: {}: {}\n", source.string(), error.code().id(), error.what());
    return out;
}

std::string summary_line(const ExportOutcome& outcome) {
    const std::size_t all = outcome.exported + outcome.failures.size();
    std::string out = fmt::format("{} map{}: {} exported", all, all == 1 ? "" : "s", outcome.exported);
    if (!outcome.failures.empty()) out += fmt::format(", {} failed", outcome.failures.size());
    return out;
}

}  // namespace dgm::exporter
