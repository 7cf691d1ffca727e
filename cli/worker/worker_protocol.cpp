// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/worker_protocol.cpp
#include "worker/worker_protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "baking/materials.h"
#include "baking/option_names.h"
#include "model/codes.h"
#include "process/worker_io.h"
#include "worker/material_json.h"

namespace dgm::bake {
namespace {

using nlohmann::json;

std::string line_of(const json& object) {
    return object.dump(-1, ' ', false, json::error_handler_t::replace) + '\n';
}

[[noreturn]] void malformed() {
    throw model::Error(model::codes::kInternal, "the worker was given a malformed job");
}

std::string text_at(const json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_string()) malformed();
    return found->get<std::string>();
}

std::uint64_t number_at(const json& object, const char* key, std::uint64_t limit) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_number_unsigned() || found->get<std::uint64_t>() > limit) malformed();
    return found->get<std::uint64_t>();
}

constexpr std::uint64_t kMaxU32 = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t kMaxU64 = std::numeric_limits<std::uint64_t>::max();

GridSize size_at(const json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_object()) malformed();
    return {static_cast<std::uint32_t>(number_at(*found, "rows", kMaxU32)),
            static_cast<std::uint32_t>(number_at(*found, "cols", kMaxU32))};
}

double real_at(const json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_number()) malformed();
    return found->get<double>();
}

bool flag_at(const json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_boolean()) malformed();
    return found->get<bool>();
}

template <class Table>
auto choice_at(const Table& table, const json& object, const char* key) {
    const auto value = value_of(table, text_at(object, key));
    if (!value) malformed();
    return *value;
}

json to_object(const GridSize& size) {
    return {{"rows", size.rows}, {"cols", size.cols}};
}

json to_object(const BakeOptions& options) {
    json out{{"size", to_object(options.size)},
             {"method", name_of(options.method)},
             {"domain", name_of(kDomainNames, options.domain)},
             {"fit", name_of(kFitNames, options.fit)},
             {"precision", name_of(kPrecisionNames, options.precision)},
             {"layers", options.layers},
             {"texture", encode_path(options.texture)},
             {"exr_layout", name_of(kExrLayoutNames, options.exr_layout)}};
    if (options.texture_size) out["texture_size"] = to_object(*options.texture_size);
    if (options.bump_size) out["bump_size"] = to_object(*options.bump_size);
    if (options.texture_bytes) out["texture_bytes"] = *options.texture_bytes;
    if (options.texel_length) out["texel_length"] = *options.texel_length;
    if (options.metres_per_unit) out["metres_per_unit"] = *options.metres_per_unit;
    out["material_file"] = encode_path(options.material_file);
    if (options.material) out["material"] = material_json(*options.material);
    out["ablate"] = options.ablate;
    json roots = json::array();
    for (const std::filesystem::path& root : options.asset_roots) roots.push_back(encode_path(root));
    out["asset_roots"] = std::move(roots);
    if (options.any_aspect) out["any_aspect"] = true;
    if (options.auto_samples) out["auto_samples"] = *options.auto_samples;
    if (options.budget_bytes) out["budget_bytes"] = *options.budget_bytes;
    if (options.max_error)
        out["max_error"] = {{"value", options.max_error->value},
                            {"percent", options.max_error->percent},
                            {"kind", name_of(kErrorKindNames, options.max_error->kind)}};
    return out;
}

std::vector<std::string> texts_at(const json& object, const char* key) {
    const auto list = object.find(key);
    if (list == object.end() || !list->is_array()) malformed();
    std::vector<std::string> out;
    for (const json& text : *list) {
        if (!text.is_string()) malformed();
        out.push_back(text.get<std::string>());
    }
    return out;
}

BakeOptions options_from(const json& object) {
    BakeOptions out;
    out.size = size_at(object, "size");
    out.method = choice_at(kMethods, object, "method");
    out.domain = choice_at(kDomainNames, object, "domain");
    out.fit = choice_at(kFitNames, object, "fit");
    out.precision = choice_at(kPrecisionNames, object, "precision");
    out.exr_layout = choice_at(kExrLayoutNames, object, "exr_layout");
    out.texture = decode_path(text_at(object, "texture"));
    if (object.contains("texture_size")) out.texture_size = size_at(object, "texture_size");
    if (object.contains("bump_size")) out.bump_size = size_at(object, "bump_size");
    if (object.contains("texture_bytes")) out.texture_bytes = number_at(object, "texture_bytes", kMaxU64);
    if (object.contains("texel_length")) out.texel_length = real_at(object, "texel_length");
    out.material_file = decode_path(text_at(object, "material_file"));
    if (object.contains("metres_per_unit")) out.metres_per_unit = real_at(object, "metres_per_unit");
    if (const auto material = object.find("material"); material != object.end()) {
        if (!material->is_object()) malformed();
        out.material.emplace();
        for (const MaterialKey& key : kMaterialKeys)
            *out.material.*key.field = static_cast<float>(real_at(*material, std::string(key.name).c_str()));
    }
    if (object.contains("any_aspect")) out.any_aspect = flag_at(object, "any_aspect");
    if (object.contains("auto_samples")) out.auto_samples = number_at(object, "auto_samples", kMaxU64);
    if (object.contains("budget_bytes")) out.budget_bytes = number_at(object, "budget_bytes", kMaxU64);
    if (const auto goal = object.find("max_error"); goal != object.end()) {
        if (!goal->is_object()) malformed();
        out.max_error = {real_at(*goal, "value"), flag_at(*goal, "percent"), choice_at(kErrorKindNames, *goal, "kind")};
    }
    out.layers = texts_at(object, "layers");
    out.ablate = texts_at(object, "ablate");
    for (const std::string& root : texts_at(object, "asset_roots")) out.asset_roots.push_back(decode_path(root));
    return out;
}

WorkerMessage message_from(const json& object) {
    const std::string type = text_at(object, "type");
    if (type == "out-of-memory") return OutOfMemoryMessage{};
    if (type == "progress") {
        const auto share = object.find("share");
        if (share == object.end() || !share->is_number()) malformed();
        return ProgressMessage{text_at(object, "stage"), std::clamp(share->get<double>(), 0.0, 1.0)};
    }
    if (type == "notice") return NoticeMessage{{text_at(object, "kind"), text_at(object, "text")}};
    if (type == "result") {
        ResultMessage result{report_from_json(text_at(object, "report")), {}};
        if (object.contains("inputs"))
            for (const std::string& input : texts_at(object, "inputs")) result.inputs.push_back(decode_path(input));
        return result;
    }
    if (type != "error") malformed();
    const model::Code* code = code_of(number_at(object, "code", kMaxU32));
    model::Error error(code != nullptr ? *code : model::codes::kInternal, text_at(object, "message"),
                       text_at(object, "place"));
    error.with_stage(text_at(object, "stage"));
    error.with_hint(text_at(object, "hint"));
    return ErrorMessage{std::move(error)};
}

json encoded(const std::vector<std::filesystem::path>& paths) {
    json out = json::array();
    for (const std::filesystem::path& path : paths) out.push_back(encode_path(path));
    return out;
}

struct Encoder {
    json operator()(const ProgressMessage& m) const {
        return {{"type", "progress"}, {"stage", m.stage}, {"share", m.share}};
    }
    json operator()(const NoticeMessage& m) const {
        return {{"type", "notice"}, {"kind", m.notice.kind}, {"text", m.notice.text}};
    }
    json operator()(const ResultMessage& m) const {
        return {{"type", "result"}, {"report", to_json(m.report, true)}, {"inputs", encoded(m.inputs)}};
    }
    json operator()(const ErrorMessage& m) const {
        return {{"type", "error"},           {"code", static_cast<std::uint64_t>(m.error.code().number)},
                {"message", m.error.what()}, {"place", m.error.place()},
                {"stage", m.error.stage()},  {"hint", m.error.hint()}};
    }
    json operator()(const OutOfMemoryMessage&) const { return {{"type", "out-of-memory"}}; }
};

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return -1;
}

}  // namespace

std::string encode_path(const std::filesystem::path& path) {
    std::string out;
    for (const char c : path.native()) {
        if (c > ' ' && c < '\x7f' && c != '%')
            out += c;
        else
            out += fmt::format("%{:02x}", static_cast<unsigned char>(c));
    }
    return out;
}

std::filesystem::path decode_path(std::string_view text) {
    std::string out;
    for (std::size_t k = 0; k < text.size(); ++k) {
        if (text[k] != '%') {
            out += text[k];
            continue;
        }
        if (text.size() - k < 3) malformed();
        const int high = hex_digit(text[k + 1]), low = hex_digit(text[k + 2]);
        if (high < 0 || low < 0) malformed();
        out += static_cast<char>(16 * high + low);
        k += 2;
    }
    return out;
}

std::string encode(const WorkerJob& job) {
    return line_of({{"source", encode_path(job.source)},
                    {"options", to_object(job.options)},
                    {"dgm", encode_path(job.dgm)},
                    {"exr", encode_path(job.exr)},
                    {"exports", encoded(job.exports)},
                    {"wants_inputs", job.wants_inputs},
                    {"memory_bytes", job.memory_bytes},
                    {"threads", job.threads},
                    {"cpu_seconds", job.cpu_seconds}});
}

JobLimits decode_limits(std::string_view text) {
    const json object = json::parse(text, nullptr, false);
    if (!object.is_object()) malformed();
    return {number_at(object, "memory_bytes", kMaxU64), static_cast<std::uint32_t>(number_at(object, "threads", 4096))};
}

bool is_page_job(std::string_view text) {
    const json object = json::parse(text, nullptr, false);
    return object.is_object() && object.contains("page");
}

WorkerJob decode_job(std::string_view text) {
    const json object = json::parse(text, nullptr, false);
    if (!object.is_object()) malformed();
    const auto options = object.find("options");
    if (options == object.end() || !options->is_object()) malformed();
    WorkerJob job;
    job.source = decode_path(text_at(object, "source"));
    job.options = options_from(*options);
    job.dgm = decode_path(text_at(object, "dgm"));
    job.exr = decode_path(text_at(object, "exr"));
    for (const std::string& output : texts_at(object, "exports")) job.exports.push_back(decode_path(output));
    job.wants_inputs = flag_at(object, "wants_inputs");
    job.options.write_dgm = !job.dgm.empty();
    job.options.write_exr = !job.exr.empty();
    job.options.scratch = job.dgm;
    const JobLimits limits = decode_limits(text);
    job.memory_bytes = limits.memory_bytes;
    job.threads = limits.threads;
    job.cpu_seconds = static_cast<std::uint32_t>(number_at(object, "cpu_seconds", kMaxU32));
    return job;
}

std::string encode(const WorkerMessage& message) {
    return line_of(std::visit(Encoder{}, message));
}

std::optional<WorkerMessage> decode_message(std::string_view line) {
    const json object = json::parse(line, nullptr, false);
    if (!object.is_object()) return std::nullopt;
    try {
        return message_from(object);
    } catch (const model::Error&) { return std::nullopt; }
}

}  // namespace dgm::bake
