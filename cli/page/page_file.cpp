// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/page_file.cpp
#include "page/page_file.h"

#include <fmt/format.h>

#include <string_view>

#include "model/codes.h"
#include "page/markup.h"
#include "page/packed_mesh.h"
#include "page/page_map.h"
#include "page/page_parts.h"

namespace dgm::page {
namespace {
std::span<const std::byte> bytes_of(std::string_view text) {
    return std::as_bytes(std::span(text));
}

/// Replaces @KEY@ in `text`, which is not searched again where a value went in.
std::string filled(std::string_view text, std::span<const std::pair<std::string_view, std::string>> values) {
    std::string out;
    while (!text.empty()) {
        const std::pair<std::string_view, std::string>* first = nullptr;
        std::size_t at = text.size();
        for (const auto& value : values)
            if (const std::size_t found = text.find(value.first); found < at) at = found, first = &value;
        out += text.substr(0, at);
        if (first == nullptr) break;
        out += first->second;
        text.remove_prefix(at + first->first.size());
    }
    return out;
}

std::string data_element(const std::string& attributes, std::span<const std::byte> bytes) {
    return fmt::format("<script type=\"text/plain\" {}>{}</script>\n", attributes, base64(bytes));
}

std::string values_element(std::size_t map, const PagedValues& values) {
    return data_element(
        fmt::format("class=\"values\" data-map=\"{}\" data-chart=\"{}\" data-name=\"{}\" data-low=\"{}\" "
                    "data-high=\"{}\" data-diverging=\"{:d}\"",
                    map, values.chart, attribute_text(values.name), values.low, values.high, values.diverging),
        bytes_of(deflated(std::as_bytes(std::span(values.codes)))));
}

std::string source_element(std::size_t map, const PagedSource& source) {
    const PackedMesh packed = packed_mesh(source.positions, source.faces);
    std::vector<std::byte> bytes = packed.bytes;
    const auto codes = std::as_bytes(std::span(source.codes));
    bytes.insert(bytes.end(), codes.begin(), codes.end());
    return data_element(
        fmt::format("class=\"source\" data-map=\"{}\" data-vertices=\"{}\" data-faces=\"{}\" data-low=\"{},{},{}\" "
                    "data-step=\"{}\" data-values=\"{}\"",
                    map, source.positions.size(), source.faces.size(), packed.low.x, packed.low.y, packed.low.z,
                    packed.step, attribute_text(source.values)),
        bytes_of(deflated(bytes)));
}

std::string body_attributes(const PageSettings& settings) {
    std::string out = fmt::format("data-up=\"{}\"", settings.z_is_up ? "z" : "y");
    if (settings.view) out += fmt::format(" data-view=\"{},{}\"", (*settings.view)[0], (*settings.view)[1]);
    if (!settings.look.empty()) out += fmt::format(" data-look=\"{}\"", attribute_text(settings.look));
    if (settings.cover) out += " data-cover=\"1\"";
    return settings.framed ? out + " class=\"framed\"" : out;
}
}  // namespace

bool can_make_pages() {
    return !page_module().empty();
}

std::string page_file(const PageSettings& settings, std::span<const PagedMap> maps,
                      const std::filesystem::path& scratch) {
    if (!can_make_pages())
        throw model::Error(model::codes::kUnsupported,
                           "this build of dgm-export writes no pages: it was made without the runtime for WebAssembly "
                           "(DGM_PAGE)")
            .with_hint("run scripts/install_packages, and build with -DDGM_PAGE=ON; dgm-export writes .glb, too");
    // One program, in strict mode, with no name that others see.
    const std::string script = fmt::format("\"use strict\";\n(() => {{{}}})();\n", page_script());
    std::string data = data_element("id=\"script\"", bytes_of(deflated(bytes_of(script))));
    data += data_element("id=\"module\"", bytes_of(deflated(bytes_of(page_module()))));
    for (std::size_t k = 0; k < maps.size(); ++k) {
        const PagedMap& map = maps[k];
        const PackedMap packed = packed_map(*map.maps, scratch);
        data += data_element(fmt::format("class=\"map\" data-name=\"{}\" data-grids=\"{}\" data-facts=\"{}\"",
                                         attribute_text(map.name), packed.grids, attribute_text(map.facts)),
                             bytes_of(deflated(packed.bytes)));
        for (const PagePicture& picture : page_pictures(*map.maps))
            data += data_element(fmt::format("class=\"picture\" data-map=\"{}\" data-chart=\"{}\" data-type=\"{}\"", k,
                                             picture.chart, picture.type),
                                 picture.bytes);
        for (const PagedValues& values : map.values) data += values_element(k, values);
        if (map.source) data += source_element(k, *map.source);
    }
    for (const PagedPath& path : settings.paths)
        data += data_element(fmt::format("class=\"path\" data-name=\"{}\"", attribute_text(path.name)),
                             bytes_of(path.text));
    if (!settings.still.empty()) data += data_element("class=\"still\"", settings.still);
    const std::pair<std::string_view, std::string> values[] = {{"@TITLE@", attribute_text(settings.title)},
                                                               {"@BODY@", body_attributes(settings)},
                                                               {"@STYLE@", std::string(page_style())},
                                                               {"@DATA@", data}};
    return filled(page_html(), values);
}

}  // namespace dgm::page
