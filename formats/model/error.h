// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/error.h
// The one exception type of the offline side, and the exit codes of docs/design.md section 8.
//
// Codes are numbered by subject and never reused: 1xxx container and index, 2xxx layers and their values, 3xxx source
// mesh and bake, 4xxx reconstruction against source, 5xxx files and system, 6xxx usage, 9xxx internal.
#pragma once
#include <exception>
#include <string>
#include <utility>

namespace dgm::model {

enum class ExitCode : int {
    kOk = 0,
    kUsage = 1,
    kIo = 2,
    kInvalid = 3,
    kInternal = 4,
    kUnsupported = 5,
    kDiffers = 7,
    kTransient = 75,
    kInterrupted = 130,
};

/// The more serious of two, what a run over several files returns: interrupted, transient, internal, I/O, invalid,
/// unsupported, ok. Transient stands before what running again cannot mend, so that a cluster does run it again; codes
/// that only one program uses (usage, differs) rank with internal.
[[nodiscard]] constexpr ExitCode worse(ExitCode a, ExitCode b) {
    constexpr auto rank = [](ExitCode exit) {
        switch (exit) {
            case ExitCode::kOk:
                return 0;
            case ExitCode::kUnsupported:
                return 1;
            case ExitCode::kInvalid:
                return 2;
            case ExitCode::kIo:
                return 3;
            case ExitCode::kTransient:
                return 5;
            case ExitCode::kInterrupted:
                return 6;
            default:
                return 4;
        }
    };
    return rank(b) > rank(a) ? b : a;
}

/// A row of the code table in model/codes.h.
struct Code {
    int number;        ///< 1003
    const char* name;  ///< "HASH_MISMATCH"
    ExitCode exit;
    const char* title;  ///< what is wrong: one line, no trailing stop
    const char* hint;   ///< what to do about it, whatever the cause; Error::with_hint says more
    const char* why;    ///< why it matters
    /// "DGM1003"
    [[nodiscard]] std::string id() const { return "DGM" + std::to_string(number); }
};

/// Thrown by formats and geometry; caught by the batch loop and by main() alone. what() is the message for people:
/// what was wrong, with figures. `place` is a path, an HDF5 path, or FILE:LINE; stages add their name with
/// with_stage().
class Error : public std::exception {
 public:
    Error(const Code& code, std::string message, std::string place = {})
        : code_(&code), message_(std::move(message)), place_(std::move(place)) {}

    [[nodiscard]] const char* what() const noexcept override { return message_.c_str(); }
    [[nodiscard]] const Code& code() const noexcept { return *code_; }
    [[nodiscard]] const std::string& place() const noexcept { return place_; }
    [[nodiscard]] const std::string& stage() const noexcept { return stage_; }
    /// The next step for the user: the code's hint, or the one of this very failure.
    [[nodiscard]] const char* hint() const noexcept { return hint_.empty() ? code_->hint : hint_.c_str(); }
    /// For a cause that the code's hint does not fit; an empty one stands for the code's.
    Error& with_hint(std::string hint) {
        hint_ = std::move(hint);
        return *this;
    }
    /// Names the pipeline stage, outermost last; keeps an inner name that is already there.
    Error& with_stage(const std::string& stage) {
        if (stage_.empty()) stage_ = stage;
        return *this;
    }

 private:
    const Code* code_;
    std::string message_, place_, stage_, hint_;
};

}  // namespace dgm::model
