// SPDX-License-Identifier: GPL-3.0-or-later
// formats/path/tool_path.cpp
#include "path/tool_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <locale>
#include <sstream>
#include <string_view>
#include <utility>

#include "model/codes.h"

namespace dgm::formats {
namespace {
Knot parse(const std::string& line, const std::string& place) {
    const auto bad = [&](const std::string& what) { return model::Error(model::codes::kUsage, what, place); };
    std::istringstream words(line);
    words.imbue(std::locale::classic());
    Knot knot;
    std::string kind;
    if (!(words >> knot.seconds >> knot.position.x >> knot.position.y >> knot.position.z >> kind))
        throw bad("a line is SECONDS X Y Z KIND [CAPTION]");
    if (!std::isfinite(knot.seconds) || std::abs(knot.seconds) > 3600) throw bad("a time must be within an hour");
    constexpr std::array<std::pair<const char*, ToolKind>, 4> kKinds{
        {{"touch", ToolKind::Touch}, {"poke", ToolKind::Poke}, {"grasp", ToolKind::Grasp}, {"away", ToolKind::Touch}}};
    const auto* found = std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& k) { return kind == k.first; });
    if (found == kKinds.end()) throw bad("\"" + kind + "\" is none of touch, poke, grasp, away");
    knot.kind = found->second;
    knot.engaged = kind != "away";
    std::getline(words >> std::ws, knot.caption);
    return knot;
}

std::optional<TouchSize> size_in(const std::string& remark) {
    constexpr std::string_view kSize = "Size ", kDepth = ", d_max ";
    const std::size_t at = remark.find(kSize);
    if (at == std::string::npos) return std::nullopt;
    std::istringstream words(remark.substr(at + kSize.size()));
    words.imbue(std::locale::classic());
    TouchSize out;
    std::string between(kDepth.size(), '\0');
    if (!(words >> out.size) || !words.read(between.data(), static_cast<std::streamsize>(between.size())) ||
        between != kDepth || !(words >> out.d_max) || !(out.size > 0 && out.d_max > 0))
        return std::nullopt;
    out.stays = remark.find(", it stays", at) != std::string::npos;
    return out;
}
}  // namespace

ToolPath::ToolPath(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) throw model::Error(model::codes::kReadFailed, "the tool path cannot be read", file.string());
    *this = ToolPath(in, file);
}

ToolPath::ToolPath(std::istream& in, const std::filesystem::path& file) {
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
        const std::size_t start = line.find_first_not_of(" \t\r");
        if (start == std::string::npos) continue;
        if (line[start] == '#') {
            if (!touch_size_) touch_size_ = size_in(line);
            continue;
        }
        const std::string place = file.string() + ":" + std::to_string(number);
        knots_.push_back(parse(line, place));
        if (knots_.size() > 1 && knots_.back().seconds <= knots_[knots_.size() - 2].seconds)
            throw model::Error(model::codes::kUsage, "times must increase", place);
    }
    if (knots_.empty()) throw model::Error(model::codes::kUsage, "the tool path is empty", file.string());
}

Knot ToolPath::at(double seconds) const {
    const auto after = std::upper_bound(knots_.begin(), knots_.end(), seconds,
                                        [](double s, const Knot& knot) { return s < knot.seconds; });
    if (after == knots_.begin()) return knots_.front();
    Knot out = *(after - 1);
    out.caption.clear();
    if (after != knots_.end()) {
        const auto t = static_cast<float>((seconds - out.seconds) / (after->seconds - out.seconds));
        out.position = out.position + t * (after->position - out.position);
    }
    out.seconds = seconds;
    return out;
}

}  // namespace dgm::formats
