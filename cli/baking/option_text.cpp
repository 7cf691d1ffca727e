// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/option_text.cpp
#include "baking/option_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "model/codes.h"

namespace dgm::bake {
namespace {

[[noreturn]] void wrong(const std::string& message) {
    throw model::Error(model::codes::kUsage, message);
}

}  // namespace

GridSize parse_size(std::string_view name, const std::string& text, std::uint32_t least, std::uint32_t most) {
    const auto side = [&](std::string_view digits) {
        std::uint32_t value = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (error != std::errc() || end != digits.data() + digits.size() || value < least || value > most)
            wrong(fmt::format("{}: \"{}\" is not a size; write MxN or N, each from {} to {}", name, text, least, most));
        return value;
    };
    const std::size_t x = text.find_first_of("xX");
    const std::string_view whole = text;
    if (x == std::string::npos) return {side(whole), side(whole)};
    return {side(whole.substr(0, x)), side(whole.substr(x + 1))};
}

std::uint64_t parse_bytes(std::string_view name, const std::string& text, std::string_view example) {
    constexpr std::string_view kLetters = "KMGT";
    double value = 0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
    std::string unit(rest, text.data() + text.size());
    for (char& c : unit)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    double factor = 1;
    bool good = error == std::errc() && std::isfinite(value) && value >= 0;
    if (const std::size_t power = unit.empty() ? std::string_view::npos : kLetters.find(unit[0]);
        power != std::string_view::npos) {
        const std::string_view tail = std::string_view(unit).substr(1);
        good = good && (tail.empty() || tail == "B" || tail == "IB");
        for (std::size_t k = 0; k <= power; ++k) factor *= tail == "B" ? 1000 : 1024;
    } else {
        good = good && (unit.empty() || unit == "B");
    }
    if (!good || value * factor > 1e18)
        wrong(fmt::format("{}: \"{}\" is not a size; write for instance {}", name, text, example));
    return static_cast<std::uint64_t>(value * factor);
}

Quantity parse_quantity(std::string_view name, const std::string& text, std::initializer_list<std::string_view> units,
                        std::string_view example) {
    Quantity out;
    std::string_view number = text;
    for (const std::string_view unit : units)
        if (number.ends_with(unit)) {
            number.remove_suffix(unit.size());
            out.unit = unit;
            break;
        }
    while (number.ends_with(' ')) number.remove_suffix(1);
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), out.value);
    if (error != std::errc() || end != number.data() + number.size() || !std::isfinite(out.value) || !(out.value > 0))
        wrong(fmt::format("{}: \"{}\" is not an amount above zero; write for instance {}", name, text, example));
    return out;
}

}  // namespace dgm::bake
