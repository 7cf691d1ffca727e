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
/// What the tool does, and after a colon its number if it is not the first. False: neither.
bool parse_kind(std::string_view word, Knot& knot) {
    constexpr std::array<std::pair<std::string_view, ToolKind>, 4> kKinds{
        {{"touch", ToolKind::Touch}, {"poke", ToolKind::Poke}, {"grasp", ToolKind::Grasp}, {"away", ToolKind::Touch}}};
    const std::size_t colon = word.find(':');
    const std::string_view name = word.substr(0, colon);
    const auto* found = std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& k) { return name == k.first; });
    if (found == kKinds.end()) return false;
    knot.kind = found->second;
    knot.engaged = name != "away";
    if (colon == std::string_view::npos) return true;
    const std::string_view number = word.substr(colon + 1);
    if (number.size() != 1 || number.front() < '1' || number.front() > static_cast<char>('0' + kMostTools))
        return false;
    knot.tool = static_cast<std::uint32_t>(number.front() - '1');
    return true;
}

Knot parse(const std::string& line, const std::string& place) {
    const auto bad = [&](const std::string& what) { return model::Error(model::codes::kUsage, what, place); };
    std::istringstream words(line);
    words.imbue(std::locale::classic());
    Knot knot;
    std::string kind;
    if (!(words >> knot.seconds >> knot.position.x >> knot.position.y >> knot.position.z >> kind))
        throw bad("a line is SECONDS X Y Z KIND [CAPTION]");
    if (!std::isfinite(knot.seconds) || std::abs(knot.seconds) > 3600) throw bad("a time must be within an hour");
    if (!parse_kind(kind, knot))
        throw bad("\"" + kind + "\" is none of touch, poke, grasp, away, nor one of them for tool 1 to 4 (grasp:2)");
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
        add(parse(line, place), place);
    }
    if (knots_.empty()) throw model::Error(model::codes::kUsage, "the tool path is empty", file.string());
}

void ToolPath::add(Knot knot, const std::string& place) {
    if (knot.tool >= tracks_.size()) tracks_.resize(knot.tool + 1);
    std::vector<std::size_t>& track = tracks_[knot.tool];
    if (!track.empty() && knot.seconds <= knots_[track.back()].seconds)
        throw model::Error(model::codes::kUsage, "times of a tool must increase", place);
    if (!knots_.empty() && knot.seconds < knots_.back().seconds)
        throw model::Error(model::codes::kUsage, "times must not go back", place);
    track.push_back(knots_.size());
    knots_.push_back(std::move(knot));
}

Knot ToolPath::at(double seconds, std::uint32_t tool) const {
    Knot out;
    out.tool = tool;
    out.engaged = false;
    const std::vector<std::size_t>& track = tracks_[tool];
    if (track.empty()) return out;
    const auto after = std::upper_bound(track.begin(), track.end(), seconds,
                                        [&](double s, std::size_t k) { return s < knots_[k].seconds; });
    if (after == track.begin()) {
        out.kind = knots_[*after].kind;
        out.position = knots_[*after].position;
    } else {
        out = knots_[*(after - 1)];
        out.caption.clear();
        if (after != track.end()) {
            const Knot& next = knots_[*after];
            const auto t = static_cast<float>((seconds - out.seconds) / (next.seconds - out.seconds));
            out.position = out.position + t * (next.position - out.position);
        }
    }
    out.seconds = seconds;
    return out;
}

}  // namespace dgm::formats
