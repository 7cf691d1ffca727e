// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/json_apart.h
// JSON of strangers is parsed in disposable processes.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "process/fork_server.h"

namespace dgm::bake {

/// A value of the whole text. @throws model::Error kReportUnreadable naming `file`
using JsonParser = std::function<nlohmann::json(std::string_view text, const std::filesystem::path& file)>;

/// One that takes a text as it stands, nested at most 64 deep (files/nesting.h).
[[nodiscard]] nlohmann::json parse_json(std::string_view text, const std::filesystem::path& file);

/// While it lives, read_json() reads every file in a process of its own, which can read that file and do nothing else
/// (sandbox.h), and read_map_report() every report in one that can read no file at all. If it dies, the file or report
/// is unreadable and the program goes on. For programs. Create it as a ForkServer.
class JsonApart {
 public:
    /// @param parse  works in those processes; it may take the JSON out of another text
    /// @throws model::Error kSystemBusy
    explicit JsonApart(JsonParser parse = parse_json);
    JsonApart(const JsonApart&) = delete;
    JsonApart& operator=(const JsonApart&) = delete;
    ~JsonApart();

 private:
    friend nlohmann::json read_json(const std::filesystem::path& file, std::uint64_t most_bytes);
    friend nlohmann::json read_map_report(const std::string& text);
    ForkServer server_;
};

/// The JSON in a file of at most `most_bytes`. Without a JsonApart it is parsed here, by parse_json().
/// @throws model::Error kReportUnreadable; kFileMissing, kReadFailed; kTooLarge before any byte is read; kSystemBusy
[[nodiscard]] nlohmann::json read_json(const std::filesystem::path& file, std::uint64_t most_bytes);

/// The report inside a map (MapSet::report_json). null if it is no JSON, is nested more than 64 deep, or ends the
/// process that parses it. Without a JsonApart it is parsed here. @throws model::Error as ApartAnswer does
[[nodiscard]] nlohmann::json read_map_report(const std::string& text);

/// The message of such a process.
[[nodiscard]] std::string encode_json(const nlohmann::json& value);
/// nullopt for bytes that are none, or are nested more than 64 deep.
[[nodiscard]] std::optional<nlohmann::json> decode_json(std::string_view bytes);

}  // namespace dgm::bake
