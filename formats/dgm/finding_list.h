// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/finding_list.h
// Collects the findings of a reader, or throws the first.
#pragma once
#include <optional>
#include <string>
#include <utility>

#include "dgm/dgm_reader.h"

namespace dgm::formats {

/// Thrown to end a check once there are enough findings.
struct EnoughFindings {};

class FindingList {
 public:
    /// @param throws  the first finding becomes a model::Error, rather than an entry
    explicit FindingList(bool throws) : throws_(throws) {}

    void add(const model::Code& code, std::string message, std::string place,
             std::optional<double> measured = std::nullopt, std::optional<double> limit = std::nullopt) {
        if (throws_) throw model::Error(code, message, place);
        findings_.push_back({&code, Severity::kError, std::move(message), std::move(place), measured, limit});
        if (findings_.size() >= kMaxFindings) throw EnoughFindings();
    }
    /// Adds an error that a library or a helper has thrown.
    void add(const model::Error& error) { add(error.code(), error.what(), error.place()); }

    [[nodiscard]] bool throws() const { return throws_; }
    [[nodiscard]] std::size_t size() const { return findings_.size(); }
    [[nodiscard]] FileFindings take() { return std::move(findings_); }

 private:
    static constexpr std::size_t kMaxFindings = 100;
    bool throws_;
    FileFindings findings_;
};

}  // namespace dgm::formats
