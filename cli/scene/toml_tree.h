// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/toml_tree.h
// What a TOML file holds, as plain values with their places: what a parser in another process can send.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dgm::scene {

/// Where a value begins, from 1.
struct TomlPlace {
    std::uint32_t line = 0, column = 0;
};

struct TomlNode {
    enum class Kind : std::uint8_t { kTable, kArray, kString, kInteger, kFloat, kBoolean, kOther } kind = Kind::kTable;
    TomlPlace place;
    std::string text;                   ///< of kString
    std::int64_t integer = 0;           ///< of kInteger, and of kBoolean 0 or 1
    double real = 0;                    ///< of kFloat; may be NaN or infinite
    std::vector<TomlNode> entries;      ///< of kArray and kTable
    std::vector<std::string> keys;      ///< of kTable, one an entry, sorted
    std::vector<TomlPlace> key_places;  ///< of kTable, one an entry

    /// An entry of a table; nullptr if it has none of that key.
    [[nodiscard]] const TomlNode* get(std::string_view key) const;
    /// A number, whole or not; nullopt for one that no double is, and for other values.
    [[nodiscard]] std::optional<double> number() const;
};

inline constexpr std::size_t kMostTomlBytes = std::size_t{16} << 20, kMostTomlValues = 4'000'000;

/// The root table. @param file  for messages
/// @throws model::Error kSceneInvalid with FILE:LINE:COLUMN as its place: no TOML, too long, too many values, nested
///         too deeply
[[nodiscard]] TomlNode parse_toml(std::string_view text, const std::filesystem::path& file);

using TomlParser = std::function<TomlNode(std::string_view text, const std::filesystem::path& file)>;

/// Reads and parses a file in a disposable process that can open nothing else and is limited in memory and time
/// (fork_server.h). The program must have one thread. @param parse  works in that process; another one is for tests
/// @throws model::Error as parse_toml(); kFileMissing, kReadFailed; kSceneInvalid if the parser crashes, hangs or needs
///         too much memory; kSystemBusy
[[nodiscard]] TomlNode read_toml_apart(const std::filesystem::path& file, const TomlParser& parse = parse_toml);

/// The message of that process.
[[nodiscard]] std::string encode_toml(const TomlNode& root);
/// nullopt for bytes that are none.
[[nodiscard]] std::optional<TomlNode> decode_toml(std::string_view bytes);

}  // namespace dgm::scene
