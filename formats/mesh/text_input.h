// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/text_input.h
// Text files of any origin: any line end, any Unicode encoding with a mark, no locale.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace dgm::formats {

/// The whole file as UTF-8 without byte-order mark; UTF-16 with a mark is converted, lone surrogates become U+FFFD.
/// @throws model::Error kFileMissing, kReadFailed (also for anything but a regular file), kTooLarge beyond `max_bytes`
[[nodiscard]] std::string read_text_file(const std::filesystem::path& path, std::uint64_t max_bytes);

/// Gives logical lines: ended by LF, CR LF or CR, joined where a line other than a comment ends in a backslash.
/// The text must outlive the reader; a line is valid until the next call.
class LineReader {
 public:
    explicit LineReader(std::string_view text) : rest_(text) {}
    /// False at the end of the text.
    [[nodiscard]] bool next(std::string_view& line);
    /// Number of the first physical line of the last logical line, from 1.
    [[nodiscard]] std::uint64_t number() const { return number_; }
    /// What is left behind the last line.
    [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
    std::string_view physical_line();
    std::string_view rest_;
    std::string joined_;
    std::uint64_t number_ = 0, physical_ = 0;
};

/// Takes the next blank-separated word off `rest`; empty at the end.
[[nodiscard]] std::string_view next_word(std::string_view& rest);
[[nodiscard]] std::string_view trim(std::string_view text);
/// ASCII letters lowered, all else untouched.
[[nodiscard]] std::string lower_case(std::string_view text);

/// The whole word as a number, in any of the spellings that printf and MSVC produce: "+1", ".5", "1e5", "nan", "-inf",
/// "1.#QNAN", and "1,5" of a program that ran under a comma locale. Too large becomes infinity, too small zero.
[[nodiscard]] std::optional<double> parse_number(std::string_view word);

}  // namespace dgm::formats
