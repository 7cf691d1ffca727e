// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/recommend.cpp
#include "bench/recommend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <tuple>

#include "batch/report_text.h"

namespace dgm::bench {
namespace {

constexpr double kLadder[] = {1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001};

/// Cheapest row of `rows` with at most `rms`.
std::optional<std::size_t> cheapest(const Table& table, const std::vector<std::size_t>& rows, double rms) {
    std::optional<std::size_t> best;
    const auto cost = [&](std::size_t row) {
        return std::tuple(table.number(row, "bytes"), table.number(row, "cpu_seconds"));
    };
    for (const std::size_t row : rows)
        if (table.number(row, "rms_percent") <= rms && (!best || cost(row) < cost(*best))) best = row;
    return best;
}

int side_of(const Table& table, std::size_t row) {
    return std::atoi(table.text(row, "grid").c_str());
}

/// Whether a grid of half the side or more, but smaller, was tried among `rows`: it does not hold, or it would be
/// cheaper.
bool knows_smaller(const Table& table, const std::vector<std::size_t>& rows, std::size_t row) {
    const int side = side_of(table, row);
    return std::any_of(rows.begin(), rows.end(), [&](std::size_t other) {
        return side_of(table, other) < side && 2 * side_of(table, other) >= side;
    });
}

/// A method is asked by the grid it needs with the settings that most methods were swept with.
std::string others(const Table& table, const std::map<std::string, std::vector<std::size_t>>& methods,
                   const std::string& used, double rms) {
    std::map<std::pair<int, bool>, std::vector<std::string>> needs;  // by side, and whether a smaller one might do
    std::vector<std::string> never;
    for (const auto& [method, rows] : methods) {
        if (method == used) continue;
        if (const auto row = cheapest(table, rows, rms))
            needs[{side_of(table, *row), !knows_smaller(table, rows, *row)}].push_back(method);
        else
            never.push_back(method);
    }
    std::string out;
    for (const auto& [grid, names] : needs)
        out += fmt::format("; {} need{} {}{}x{}", listed(names), names.size() == 1 ? "s" : "",
                           grid.second ? "at most " : "", grid.first, grid.first);
    if (never.empty()) return out;
    return out + fmt::format("; {} do{} not reach it on the grids tried", listed(never), never.size() == 1 ? "es" : "");
}

}  // namespace

std::string listed(const std::vector<std::string>& names) {
    std::string out;
    for (std::size_t k = 0; k < names.size(); ++k)
        out += (k == 0 ? "" : k + 1 == names.size() ? " and " : ", ") + names[k];
    return out;
}

std::vector<std::string> recommend(const Table& table, const std::string& asset) {
    std::vector<std::size_t> all;
    std::map<std::string, std::vector<std::size_t>> methods;
    // A file without some of the layers is no cheaper answer to the same wish.
    const std::string layers = table.rows.empty() ? "" : table.text(0, "layers");
    for (std::size_t row = 0; row < table.rows.size(); ++row)
        if (table.text(row, "asset") == asset && table.text(row, "layers") == layers &&
            std::isfinite(table.number(row, "rms_percent"))) {
            all.push_back(row);
            methods[table.text(row, "method")].push_back(row);
        }
    std::vector<std::string> out;
    std::optional<std::size_t> last;
    for (const double rms : kLadder) {
        const auto row = cheapest(table, all, rms);
        // A rung whose answer holds the next one, too, says less than that one.
        const bool next_same =
            rms > kLadder[std::size(kLadder) - 1] && row &&
            cheapest(table, all, *(std::upper_bound(std::begin(kLadder), std::end(kLadder), rms, std::greater<>()))) ==
                row;
        if (!row || row == last || next_same) continue;
        last = row;
        const std::string method = table.text(*row, "method");
        out.push_back(
            fmt::format("{}: for {} % rms use {} {} {} fit {}: {}, {} s CPU{}", asset, rms, table.text(*row, "grid"),
                        method, table.text(*row, "precision"), table.text(*row, "fit"),
                        bake::bytes_text(static_cast<std::uint64_t>(table.number(*row, "bytes"))),
                        three_digits(table.number(*row, "cpu_seconds")), others(table, methods, method, rms)));
    }
    return out;
}

}  // namespace dgm::bench
