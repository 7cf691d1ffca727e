// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/json_apart.cpp
#include "process/json_apart.h"

#include <fmt/format.h>

#include <utility>

#include "files/nesting.h"
#include "files/regular_file.h"
#include "model/codes.h"
#include "process/apart_answer.h"
#include "process/byte_stream.h"

namespace dgm::bake {
namespace {

using nlohmann::json;
namespace codes = model::codes;
namespace fs = std::filesystem;

constexpr unsigned kMostSeconds = 120;
/// A value takes some ten times the memory of its text.
constexpr std::uint64_t kMostMemory = std::uint64_t{16} << 30, kMostAnswerBytes = std::uint64_t{4} << 30;

JsonApart* current = nullptr;

enum class Request : std::uint8_t { kFile, kText };

/// In the disposable process.
void work(const JsonParser& parse, std::string_view request) {
    ByteReader in(request);
    const auto kind = in.get<Request>();
    const std::string text = in.text();  // or a name
    const auto most_bytes = in.get<std::uint64_t>();
    Sandbox sandbox{.readable = {}, .writable = {}, .cpu_seconds = kMostSeconds};
    if (kind == Request::kFile) sandbox.readable = {text};
    answer_in_sandbox(sandbox, kMostMemory, [&] {
        return send_head(
            encode_json(parse(kind == Request::kFile ? formats::read_small_file(text, most_bytes) : text, text)));
    });
}

std::string request_of(Request kind, const std::string& text, std::uint64_t most_bytes) {
    ByteWriter out;
    out.put(kind);
    out.put(text);
    out.put(most_bytes);
    return out.take();
}

void put(ByteWriter& out, const json& value) {
    const json::value_t kind = value.type();
    out.put(kind);
    switch (kind) {
        case json::value_t::object:
            out.put(std::uint64_t{value.size()});
            for (const auto& [key, entry] : value.items()) {
                out.put(key);
                put(out, entry);
            }
            break;
        case json::value_t::array:
            out.put(std::uint64_t{value.size()});
            for (const json& entry : value) put(out, entry);
            break;
        case json::value_t::string:
            out.put(value.get_ref<const std::string&>());
            break;
        case json::value_t::boolean:
            out.put(value.get<bool>());
            break;
        case json::value_t::number_integer:
            out.put(value.get<std::int64_t>());
            break;
        case json::value_t::number_unsigned:
            out.put(value.get<std::uint64_t>());
            break;
        case json::value_t::number_float:
            out.put(value.get<double>());
            break;
        default:  // null
            break;
    }
}

class Decoder {
 public:
    explicit Decoder(std::string_view bytes) : in_(bytes) {}

    std::optional<json> whole() {
        json out = value(0);
        if (!fits_ || !in_.at_end()) return std::nullopt;
        return out;
    }

 private:
    json value(std::size_t level) {
        const auto kind = in_.get<json::value_t>();
        fits_ = fits_ && in_.ok() && level <= formats::kMostNesting;
        if (!fits_) return {};
        switch (kind) {
            case json::value_t::object:
                return object(level);
            case json::value_t::array: {
                json out = json::array();
                for (auto left = in_.get<std::uint64_t>(); left > 0 && fits_; --left) out.push_back(value(level + 1));
                return out;
            }
            case json::value_t::string:
                return in_.text();
            case json::value_t::boolean:
                return in_.get<std::uint8_t>() != 0;
            case json::value_t::number_integer:
                return in_.get<std::int64_t>();
            case json::value_t::number_unsigned:
                return in_.get<std::uint64_t>();
            case json::value_t::number_float:
                return in_.get<double>();
            case json::value_t::null:
                return {};
            default:
                fits_ = false;
                return {};
        }
    }
    json object(std::size_t level) {
        json out = json::object();
        for (auto left = in_.get<std::uint64_t>(); left > 0 && fits_; --left) {
            std::string key = in_.text();
            out[std::move(key)] = value(level + 1);
        }
        return out;
    }

    ByteReader in_;
    bool fits_ = true;
};

}  // namespace

json parse_json(std::string_view text, const fs::path& file) {
    if (const auto deep = formats::too_deep_json(text, formats::kMostNesting))
        throw model::Error(codes::kReportUnreadable,
                           fmt::format("it is nested too deeply at line {}, column {}", deep->line, deep->column),
                           file.string());
    json out = json::parse(text, nullptr, false);
    if (out.is_discarded())
        throw model::Error(codes::kReportUnreadable, "it is not JSON; was its writer interrupted?", file.string());
    return out;
}

JsonApart::JsonApart(JsonParser parse)
    : server_({.work = [parse = std::move(parse)](std::string_view request) { work(parse, request); },
               .prepare = {},
               .seconds = kMostSeconds}) {
    current = this;
}

JsonApart::~JsonApart() {
    current = nullptr;
}

std::string encode_json(const json& value) {
    ByteWriter out;
    put(out, value);
    return out.take();
}

std::optional<json> decode_json(std::string_view bytes) {
    return Decoder(bytes).whole();
}

json read_json(const fs::path& file, std::uint64_t most_bytes) {
    if (current == nullptr) return parse_json(formats::read_small_file(file, most_bytes), file);
    ApartAnswer answer(current->server_, request_of(Request::kFile, file.native(), most_bytes));
    if (const std::optional<std::string> bytes = answer.head(kMostAnswerBytes))
        if (std::optional<json> value = decode_json(*bytes)) return std::move(*value);
    throw model::Error(codes::kReportUnreadable, answer.failure("the JSON parser", kMostSeconds), file.string());
}

json read_map_report(const std::string& text) {
    if (formats::too_deep_json(text, formats::kMostNesting)) return nullptr;  // looked at without a parser
    if (current == nullptr) {
        json out = json::parse(text, nullptr, false);
        return out.is_discarded() ? json(nullptr) : out;
    }
    try {
        ApartAnswer answer(current->server_, request_of(Request::kText, text, 0));
        if (const std::optional<std::string> bytes = answer.head(kMostAnswerBytes))
            if (std::optional<json> value = decode_json(*bytes)) return std::move(*value);
    } catch (const model::Error& e) {
        if (e.code().number != codes::kReportUnreadable.number) throw;
    }
    return nullptr;
}

}  // namespace dgm::bake
