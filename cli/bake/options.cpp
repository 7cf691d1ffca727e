// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/options.cpp
#include "bake/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <thread>

#include "bake/raw_options.h"
#include "baking/materials.h"
#include "baking/option_names.h"
#include "baking/option_text.h"
#include "model/codes.h"
#include "model/layer_names.h"
#include "scene/material_file.h"
#include "tool/help.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;

constexpr std::uint32_t kMaxTextureSide = 16384;
constexpr double kMaxSeconds = 1e7;
constexpr unsigned kMaxShards = 1'000'000;

[[noreturn]] void wrong(const std::string& message) {
    throw model::Error(codes::kUsage, message);
}

template <class Names>
[[noreturn]] void unknown_word(std::string_view option, std::string_view what, const std::string& word,
                               const Names& names) {
    wrong(fmt::format("{}: {}", option, tool::unknown_word(what, word, {names.begin(), names.end()})));
}

template <class E, std::size_t N>
E choice(std::string_view option, const std::array<NamedValue<E>, N>& table, const std::string& word) {
    if (const auto value = value_of(table, word)) return *value;
    std::array<std::string_view, N> names;
    std::transform(table.begin(), table.end(), names.begin(), [](const auto& row) { return row.name; });
    unknown_word(option, "value", word, names);
}

std::vector<std::string> split_list(std::string_view option, std::string_view text) {
    std::vector<std::string> out;
    for (;;) {
        const std::size_t comma = text.find(',');
        out.emplace_back(text.substr(0, comma));
        if (out.back().empty()) wrong(fmt::format("{}: an empty name in the list", option));
        if (comma == std::string_view::npos) return out;
        text.remove_prefix(comma + 1);
    }
}

/// "auto:66049": the number.
std::uint64_t parse_auto_size(const std::string& text) {
    constexpr std::uint64_t kLeast = std::uint64_t{kMinSide} * kMinSide, kMost = std::uint64_t{kMaxSide} * kMaxSide;
    const std::string_view digits = std::string_view(text).substr(text.find(':') + 1);
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size() || value < kLeast || value > kMost)
        wrong(fmt::format("--size: \"{}\" is not a number of samples; write auto:N, N from {} to {}", text, kLeast,
                          kMost));
    return value;
}

/// "0.05%", or "0.5" in source units.
ErrorGoal parse_max_error(const std::string& text) {
    const Quantity read =
        parse_quantity("--max-error", text, {"%"}, "0.05% (of the diagonal) or 0.2 (in the mesh's units)");
    return {read.value, read.unit == "%"};
}

void set_formats(const Raw& raw, CommandLine& out) {
    std::string text = raw.format;
    const std::string extension = std::filesystem::path(raw.output).extension().string();
    std::error_code ignored;
    const bool names_file = (extension == ".dgm" || extension == ".exr") && !out.plan.output_is_folder &&
                            !std::filesystem::is_directory(raw.output, ignored);
    if (text.empty()) text = names_file ? extension.substr(1) : "dgm";
    out.bake.write_dgm = out.bake.write_exr = false;
    constexpr std::array<std::string_view, 5> kFormats{"dgm", "exr", "glb", "obj", "ply"};
    for (const std::string& format : split_list("--format", text)) {
        if (format == "dgm")
            out.bake.write_dgm = true;
        else if (format == "exr")
            out.bake.write_exr = true;
        else if (std::find(kFormats.begin(), kFormats.end(), format) == kFormats.end())
            unknown_word("--format", "format", format, kFormats);
        else if (std::find(out.plan.exports.begin(), out.plan.exports.end(), "." + format) == out.plan.exports.end())
            out.plan.exports.push_back("." + format);
    }
    if (!out.bake.write_dgm && !out.bake.write_exr)
        wrong(
            fmt::format("--format {0}: meshes are made of a map, which stays beside them and knows what is up to date; "
                        "write --format dgm,{0}",
                        text));
    if (names_file && !(extension == ".dgm" ? out.bake.write_dgm : out.bake.write_exr))
        wrong(fmt::format("-o names a {} file, but --format asks for {}", extension, text));
    out.plan.write_dgm = out.bake.write_dgm;
    out.plan.write_exr = out.bake.write_exr;
}

void set_layers(const std::string& text, BakeOptions& bake) {
    const std::vector<std::string> asked = split_list("--layers", text);
    for (const std::string& name : asked)
        if (std::find(kLayerNames.begin(), kLayerNames.end(), name) == kLayerNames.end())
            unknown_word("--layers", "layer", name, kLayerNames);
    for (const std::string_view name : kLayerNames)  // in file order, once each
        if (name == model::layers::kGeometry || std::find(asked.begin(), asked.end(), name) != asked.end())
            bake.layers.emplace_back(name);
}

void set_grid(const Raw& raw, BakeOptions& bake) {
    if (!raw.max_error.empty()) bake.max_error = parse_max_error(raw.max_error);
    if (!raw.max_error_kind.empty()) {
        if (!bake.max_error) wrong("--max-error-kind says which error --max-error means; it needs one");
        bake.max_error->kind = choice("--max-error-kind", kErrorKindNames, raw.max_error_kind);
    }
    if (!raw.budget.empty()) {
        bake.budget_bytes = parse_bytes("--budget", raw.budget, "256KiB or 1MB");
        if (*bake.budget_bytes == 0) wrong("--budget: nothing fits into 0 bytes");
        if (!bake.write_dgm) wrong("--budget is the size of the .dgm; add dgm to --format");
    }
    if (raw.size.starts_with("auto:"))
        bake.auto_samples = parse_auto_size(raw.size);
    else if (!raw.size.empty())
        bake.size = parse_size("--size", raw.size, kMinSide, kMaxSide);
    else if (bake.max_error || bake.budget_bytes)
        bake.auto_samples = kLargestSearched;
    else
        bake.any_aspect = true;
}

/// Format of the report: as asked, else by the file's extension.
void set_report(const Raw& raw, const std::string& file, CommandLine& out) {
    constexpr std::array kReportFormats{NamedValue<bool>{"json", false}, NamedValue<bool>{"html", true}};
    out.report = file;
    const std::string extension = out.report.extension().string();
    constexpr std::array<std::string_view, 4> kKnown{"", ".json", ".html", ".htm"};
    if (raw.report_format.empty() && std::find(kKnown.begin(), kKnown.end(), extension) == kKnown.end())
        wrong(
            fmt::format("--report: \"{}\" does not say what to write; end it in .json or .html, or add "
                        "--report-format json or html",
                        file));
    out.html_report = raw.report_format.empty() ? extension == ".html" || extension == ".htm"
                                                : choice("--report-format", kReportFormats, raw.report_format);
    if (!raw.report_format.empty() && file.empty())
        wrong("--report-format says what --report FILE is written in; name a file with --report");
}

/// "2/8"
Shard parse_shard(const std::string& text) {
    Shard out{0, 0};
    const char* const end = text.data() + text.size();
    const auto number = std::from_chars(text.data(), end, out.number);
    const bool slash = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
    const auto count = slash ? std::from_chars(number.ptr + 1, end, out.count) : number;
    if (!slash || count.ec != std::errc() || count.ptr != end || out.number < 1 || out.number > out.count ||
        out.count > kMaxShards)
        wrong(fmt::format("--shard: \"{}\" is no part of a batch; write I/N, such as 1/8 up to 8/8, N at most {}", text,
                          kMaxShards));
    return out;
}

/// Files are written aside, read back and renamed, which a stream cannot be.
void refuse_stream(std::string_view option, const std::string& file, std::string_view instead) {
    if (file == "-") wrong(fmt::format("{} -: it cannot go to standard output; {}", option, instead));
}

/// How many at a time and how long, and what is told meanwhile.
void set_run(const Raw& raw, CommandLine& out) {
    constexpr std::array kProgressNames{NamedValue<ProgressStyle>{"auto", ProgressStyle::kAuto},
                                        NamedValue<ProgressStyle>{"bar", ProgressStyle::kBar},
                                        NamedValue<ProgressStyle>{"plain", ProgressStyle::kPlain},
                                        NamedValue<ProgressStyle>{"none", ProgressStyle::kNone}};
    out.progress = choice("--progress", kProgressNames, raw.progress);
    if (raw.jobs < 0 || raw.jobs > 1024) wrong("-j: write a number from 1 to 1024, or 0 for one a core");
    out.batch.jobs = raw.jobs > 0 ? static_cast<unsigned>(raw.jobs) : std::max(1U, std::thread::hardware_concurrency());
    if (!(raw.time_limit > 0 && raw.time_limit <= kMaxSeconds))
        wrong(fmt::format("--time-limit: write seconds, more than 0 and at most {:.0f}", kMaxSeconds));
    out.batch.time_limit_seconds = raw.time_limit;
    out.batch.memory_bytes = parse_bytes("--memory-limit", raw.memory_limit, "512MiB or 4GiB, 0 for no limit");
    out.batch.stop_on_error = raw.stop_on_error;
    out.verbose = raw.verbose;
    out.quiet = raw.quiet;
}

void set_asset_roots(const Raw& raw, BakeOptions& bake) {
    for (const std::string& root : raw.asset_roots) {
        if (!std::filesystem::is_directory(root)) wrong(fmt::format("--asset-root: {} is not a folder", root));
        bake.asset_roots.emplace_back(root);
    }
}

/// A preset's name, or a file.
void set_material(const Raw& raw, BakeOptions& bake) {
    if (!raw.unit.empty()) bake.metres_per_unit = choice("--unit", kUnitNames, raw.unit);
    if (raw.material.empty()) return;
    if (!bake.metres_per_unit) wrong("--material needs the length of a unit of the mesh: add --unit mm, cm or m");
    bake.material = value_of(kMaterialNames, raw.material);
    if (bake.material) return;
    std::array<std::string_view, kMaterialNames.size()> names;
    std::transform(kMaterialNames.begin(), kMaterialNames.end(), names.begin(),
                   [](const auto& row) { return row.name; });
    if (!raw.material.ends_with(".toml")) unknown_word("--material", "material", raw.material, names);
    bake.material_file = raw.material;
    bake.material = scene::read_material(bake.material_file);
}

CommandLine to_merge(const Raw& raw) {
    CommandLine out;
    set_asset_roots(raw, out.bake);
    if (raw.inputs.empty())
        wrong("--merge-reports: name the reports, for instance: --merge-reports a.json b.json -o all.json");
    for (const std::string& input : raw.inputs) out.to_merge.emplace_back(input);
    set_report(raw, raw.output.empty() ? raw.report : raw.output, out);
    set_run(raw, out);
    return out;
}

/// A scene file says what is baked; what the command line says beside it is how and where to.
void check_scene(const Raw& raw, const std::vector<std::string>& given) {
    constexpr std::array<std::string_view, 18> kHow{
        "--output",  "--jobs",   "--time-limit",    "--memory-limit",  "--keep-going", "--stop-on-error",
        "--dry-run", "--report", "--report-format", "--progress",      "--verbose",    "--quiet",
        "--force",   "--shard",  "--depfile",       "--merge-reports", "--asset-root", "INPUT"};
    if (raw.inputs.size() > 1) wrong("a scene file is baked by itself: name no other inputs");
    for (const std::string& option : given)
        if (std::find(kHow.begin(), kHow.end(), option) == kHow.end())
            wrong(fmt::format("{} is not allowed with a scene file; set it in {}", option, raw.inputs.front()));
    const std::string extension = std::filesystem::path(raw.output).extension().string();
    if (extension == ".dgm" || extension == ".exr") wrong("-o: a scene goes into a folder");
}

/// @param given  long names of the options on the command line
CommandLine checked(const Raw& raw, const std::vector<std::string>& given) {
    CommandLine out;
    for (const std::string& input : raw.inputs) {
        if (input.empty()) wrong("an input has no name");
        out.plan.inputs.emplace_back(input);
    }
    refuse_stream("-o", raw.output, "name a file or a folder, such as -o out.dgm or -o baked/");
    refuse_stream("--report", raw.report, "name a file, such as --report report.json");
    refuse_stream("--depfile", raw.depfile, "name a file, such as --depfile maps.d");
    if (raw.keep_going && raw.stop_on_error) wrong("--keep-going and --stop-on-error contradict each other");
    if (raw.verbose && raw.quiet) wrong("-v and -q contradict each other");
    if (raw.merge_reports) return to_merge(raw);
    if (raw.inputs.empty()) wrong(tool::missing_argument("INPUT", manual()));
    if (std::any_of(raw.inputs.begin(), raw.inputs.end(), [](const std::string& i) { return i.ends_with(".toml"); })) {
        check_scene(raw, given);
        out.scene = raw.inputs.front();
    }
    if (!raw.shard.empty()) out.shard = parse_shard(raw.shard);
    out.batch.shares_folders = out.shard.has_value();
    out.batch.force = raw.force;
    out.depfile = raw.depfile;
    out.plan.output = raw.output;
    out.plan.output_is_folder = !raw.output.empty() && raw.output.back() == '/';
    set_formats(raw, out);
    set_grid(raw, out.bake);
    const std::optional<Method> method = method_of(raw.method);
    if (!method) unknown_word("--method", "method", raw.method, kMethodNames);
    out.bake.method = *method;
    out.bake.domain = choice("--domain", kDomainNames, raw.domain);
    const DomainChoice only = row_of(*method).domain;
    if (only != DomainChoice::kAuto && out.bake.domain != DomainChoice::kAuto && only != out.bake.domain)
        wrong(fmt::format("--method {} lays charts out in the {} domain only; leave out --domain {}", raw.method,
                          name_of(kDomainNames, only), raw.domain));
    out.bake.fit = choice("--fit", kFitNames, raw.fit);
    out.bake.precision = choice("--precision", kPrecisionNames, raw.precision);
    out.bake.exr_layout = choice("--exr-layout", kExrLayoutNames, raw.exr_layout);
    if (!raw.layers.empty()) set_layers(raw.layers, out.bake);
    out.bake.texture = raw.texture;
    set_asset_roots(raw, out.bake);
    if (!raw.texture_size.empty())
        out.bake.texture_size = parse_size("--texture-size", raw.texture_size, 1, kMaxTextureSide);
    if (!raw.bump_size.empty()) out.bake.bump_size = parse_size("--bump-size", raw.bump_size, 2, kMaxTextureSide);
    set_material(raw, out.bake);
    if (!raw.ablate.empty()) out.bake.ablate = split_list("--ablate", raw.ablate);
    for (const std::string& part : out.bake.ablate)
        if (std::find(kAblateNames.begin(), kAblateNames.end(), part) == kAblateNames.end())
            unknown_word("--ablate", "part", part, kAblateNames);
    set_report(raw, raw.report, out);
    set_run(raw, out);
    out.dry_run = raw.dry_run;
    out.prune = raw.prune;
    const std::string_view ending = std::filesystem::path(raw.output).extension().native();
    if (out.prune && (raw.output.empty() || (!out.plan.output_is_folder && (ending == ".dgm" || ending == ".exr"))))
        wrong("--prune looks through the folder of the outputs; name it with -o");
    return out;
}

}  // namespace

std::variant<CommandLine, Answer> parse_command_line(int argc, const char* const* argv) {
    Raw raw;
    CLI::App app;
    describe(app, raw);
    // -MF is how compilers call it, and build files therefore; CLI11 would read it as -M with the value F.
    std::vector<const char*> arguments(argv, argv + argc);
    for (std::size_t k = 1; k < arguments.size() && std::string_view(arguments[k]) != "--"; ++k)
        if (std::string_view(arguments[k]) == "-MF") arguments[k] = "--depfile";
    try {
        app.parse(argc, arguments.data());
    } catch (const CLI::CallForHelp&) { return app.help(); } catch (const CLI::CallForVersion& version) {
        return std::string(version.what()) + '\n';
    } catch (const CLI::ExtrasError&) {
        wrong(tool::unknown_option(app, app.remaining().front()));
    } catch (const CLI::ParseError& error) { wrong(error.what()); }
    std::vector<std::string> given;
    for (const CLI::Option* option : app.get_options())
        if (option->count() > 0)
            given.push_back(option->get_lnames().empty() ? option->get_name() : "--" + option->get_lnames().front());
    return checked(raw, given);
}

}  // namespace dgm::bake
