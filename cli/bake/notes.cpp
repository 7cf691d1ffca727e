// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/notes.cpp
#include "bake/notes.h"

#include <fmt/format.h>

#include <algorithm>

#include "batch/report_text.h"

namespace dgm::bake {

void Notes::add(std::size_t asset, const Notice& notice) {
    auto place = std::find_if(kinds_.begin(), kinds_.end(), [&](const auto& row) { return row.first == notice.kind; });
    if (place == kinds_.end()) place = kinds_.insert(place, {notice.kind, {}});
    place->second.insert(asset);
}

std::string Notes::line(std::size_t assets) const {
    std::string out;
    for (const auto& [kind, those] : kinds_)
        out += fmt::format("{}{} on {} of {} meshes", out.empty() ? "notes: " : "; ", printable(kind), those.size(),
                           assets);
    return out.empty() ? out : out + "; -v tells which";
}

}  // namespace dgm::bake
