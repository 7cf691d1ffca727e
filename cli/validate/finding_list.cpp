// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/finding_list.cpp
#include "validate/finding_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace dgm::validate {

void FindingList::add(const model::Code& code, Severity severity, std::string place, std::string message,
                      Figures figures) {
    findings_.push_back({&code, severity, std::move(message), std::move(place), figures.measured, figures.limit});
}

void FindingList::append(std::vector<Finding> findings) {
    findings_.insert(findings_.end(), std::make_move_iterator(findings.begin()),
                     std::make_move_iterator(findings.end()));
}

bool FindingList::has_errors() const {
    return std::any_of(findings_.begin(), findings_.end(),
                       [](const Finding& f) { return f.severity == Severity::kError; });
}

std::string layer_path(std::size_t chart, const std::string& layer) {
    return layer.empty() ? fmt::format("/charts/{}", chart) : fmt::format("/charts/{}/{}", chart, layer);
}

std::string element_text(std::span<const std::uint64_t> shape, std::size_t index) {
    std::string text;
    for (auto extent = shape.rbegin(); extent != shape.rend(); ++extent) {
        if (*extent == 0) return {};
        text = fmt::format("[{}]{}", index % *extent, text);
        index /= *extent;
    }
    return text;
}

}  // namespace dgm::validate
