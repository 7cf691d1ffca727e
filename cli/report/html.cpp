// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/html.cpp
#include "report/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/entities.h"
#include "page/markup.h"
#include "report/page_parts.h"

namespace dgm::report {
namespace {
using nlohmann::json;

std::string data_uri(std::string_view type, std::span<const std::byte> bytes) {
    return fmt::format("data:image/{};base64,{}", type, page::base64(bytes));
}

bool is_plain(unsigned char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-' || c == '.' ||
           c == '_' || c == '~';
}
}  // namespace

std::string escaped(std::string_view text) {
    // The JSON writer is who replaces what is not UTF-8.
    const std::string valid =
        json::parse(json(std::string(text)).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
    std::string out;
    out.reserve(valid.size());
    for (const char c : valid) {
        if (const std::string_view entity = model::entity_of(c); !entity.empty())
            out += entity;
        else if (c != '\n' && (static_cast<unsigned char>(c) < 0x20 || c == '\x7f'))
            out += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
        else
            out += c;
    }
    return out;
}

std::string attribute_value(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (const char c : text) {
        if (c == '&')
            out += "&amp;";
        else if (c == '"')
            out += "&quot;";
        else
            out += c;
    }
    return out;
}

std::string script_json(const json& value) {
    std::string out;
    for (const char c : value.dump(-1, ' ', true, json::error_handler_t::replace)) {
        if (c == '<' || c == '>' || c == '&')
            out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
        else
            out += c;
    }
    return out;
}

std::string link_segment(std::string_view name) {
    std::string out;
    for (const char c : name)
        out += is_plain(static_cast<unsigned char>(c)) ? std::string(1, c)
                                                       : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    return out;
}

std::string photo_uri(const formats::Image& image, int quality) {
    return data_uri("jpeg", formats::encode_jpeg(image, quality));
}

std::string picture_uri(const formats::Image& image, std::size_t most) {
    const std::vector<std::byte> exact = formats::encode_png(image);
    if (exact.size() <= most) return data_uri("png", exact);
    const std::vector<std::byte> near = formats::encode_jpeg(image, 92);
    return near.size() < exact.size() ? data_uri("jpeg", near) : data_uri("png", exact);
}

std::string number_text(double value) {
    if (std::isnan(value)) return "unknown";
    return fmt::format("{:.3g}", value);
}

std::string length_text(double value, double diagonal) {
    if (!(diagonal > 0)) return number_text(value);
    return fmt::format("{:.3g} ({:.2g} %)", value, 100 * value / diagonal);
}

std::string counted(std::uint64_t count, std::string_view noun) {
    return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string page_start(std::string_view title, std::string_view head) {
    return fmt::format(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n{}"
        "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
        "<meta name=\"color-scheme\" content=\"light dark\">\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data: blob:; style-src "
        "'unsafe-inline'; script-src 'unsafe-inline' 'wasm-unsafe-eval'\">\n"
        "<link rel=\"icon\" href=\"data:,\">\n"
        "<title>{}</title>\n<style>\n{}</style>\n</head>\n",
        head, escaped(title), kStyle);
}

}  // namespace dgm::report
