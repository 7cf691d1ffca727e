// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/finding_list.h
// The list that the checks write into.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dgm/dgm_reader.h"

namespace dgm::validate {

using formats::Finding;
using formats::Severity;

/// Figures of a finding: what was measured, and what it may be at most or at least.
struct Figures {
    std::optional<double> measured, limit;
};

/// Findings in the order of the checks. A check reports the first offender and the number of them, not each of a
/// million samples.
class FindingList {
 public:
    void error(const model::Code& code, std::string place, std::string message, Figures figures = {}) {
        add(code, Severity::kError, std::move(place), std::move(message), figures);
    }
    void warning(const model::Code& code, std::string place, std::string message, Figures figures = {}) {
        add(code, Severity::kWarning, std::move(place), std::move(message), figures);
    }
    void note(const model::Code& code, std::string place, std::string message, Figures figures = {}) {
        add(code, Severity::kNote, std::move(place), std::move(message), figures);
    }
    void append(std::vector<Finding> findings);
    [[nodiscard]] bool has_errors() const;
    [[nodiscard]] std::size_t size() const { return findings_.size(); }
    [[nodiscard]] std::vector<Finding> take() { return std::move(findings_); }

 private:
    void add(const model::Code& code, Severity severity, std::string place, std::string message, Figures figures);
    std::vector<Finding> findings_;
};

/// "/charts/2/normal", the HDF5 path of a layer; "/charts/2" for an empty name.
[[nodiscard]] std::string layer_path(std::size_t chart, const std::string& layer);

/// Flat element index to "[3][4][0]" in a row-major array of this shape.
[[nodiscard]] std::string element_text(std::span<const std::uint64_t> shape, std::size_t index);

}  // namespace dgm::validate
