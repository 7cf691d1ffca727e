// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/compare.cpp
#include "bench/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bench/machine_facts.h"
#include "model/codes.h"

namespace dgm::bench {
namespace {

struct Change {
    double size = 0;  ///< |log| of the ratio
    std::string line;
};

struct Tally {
    std::vector<Change> changes;
    std::size_t same = 0, too_seldom = 0, unmatched = 0, other_machine = 0;
};

std::string name_of(const Table& table, std::size_t row) {
    std::string out;
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
        if (!table.columns[k].identifies) continue;
        const std::string part = shown(table.rows[row].cells[k], table.columns[k]);
        if (!part.empty()) out += (out.empty() ? "" : " ") + part;
    }
    return out;
}

/// "faster", "slower" of times; "better", "worse" of the rest; "larger", "smaller" of bytes.
const char* word(const Column& column, bool rose) {
    if (column.unit == "bytes" || column.unit == "MiB") return rose ? "larger" : "smaller";
    if (column.timed) return rose ? "slower" : "faster";
    return rose == (column.sense == Sense::kHigher) ? "better" : "worse";
}

void compare_figures(const std::string& point, const Column& column, const Figure& now, const Figure& then,
                     bool same_machine, Tally& tally) {
    if (column.timed && !same_machine) {
        ++tally.other_machine;
        return;
    }
    double change = 0;
    std::string times;
    if (column.timed) {
        const auto quotient = ratio(now, then);
        if (!quotient) {
            ++tally.too_seldom;
            return;
        }
        if (quotient->beyond_noise()) {
            change = std::log(quotient->value);
            times = fmt::format(" ({:.2f}x, {:.2f} to {:.2f})", quotient->value, quotient->low, quotient->high);
        }
    } else {
        const double scale = std::max(std::fabs(now.value), std::fabs(then.value));
        if (std::fabs(now.value - then.value) > column.tolerance * scale)
            change = now.value > 0 && then.value > 0 ? std::log(now.value / then.value)
                                                     : std::copysign(1e9, now.value - then.value);
    }
    if (change == 0) {
        ++tally.same;
        return;
    }
    const std::string unit = column.unit.empty() ? "" : " " + column.unit;
    tally.changes.push_back(
        {std::fabs(change), fmt::format("{}: {} {}: {} -> {}{}{}", word(column, change > 0), point, column.title,
                                        three_digits(then.value), three_digits(now.value), unit, times)});
}

void compare_rows(const Table& now, std::size_t row, const Table& then, std::size_t old_row, bool same_machine,
                  Tally& tally) {
    const std::string point = name_of(now, row);
    for (std::size_t k = 0; k < now.columns.size(); ++k) {
        const Column& column = now.columns[k];
        const auto old_column = std::find_if(then.columns.begin(), then.columns.end(),
                                             [&](const Column& c) { return c.key == column.key; });
        if (column.identifies || old_column == then.columns.end()) continue;
        const Cell& cell = now.rows[row].cells[k];
        const Cell& old_cell = then.rows[old_row].cells[static_cast<std::size_t>(old_column - then.columns.begin())];
        if (const auto* a = std::get_if<Figure>(&cell), *b = std::get_if<Figure>(&old_cell);
            a != nullptr && b != nullptr && column.sense != Sense::kNone)
            compare_figures(point, column, *a, *b, same_machine, tally);
        if (const auto* a = std::get_if<std::string>(&cell), *b = std::get_if<std::string>(&old_cell);
            a != nullptr && b != nullptr && *a != *b)
            tally.changes.push_back({1e9, fmt::format("changed: {} {}: {} -> {}", point, column.title, *b, *a)});
    }
}

}  // namespace

std::vector<std::string> compare_runs(const Run& now, const Run& then) {
    if (now.command != then.command)
        throw model::Error(model::codes::kUsage,
                           "a run of " + now.command + " cannot be compared with one of " + then.command);
    const bool same_machine = same_hardware(now.machine, then.machine);
    Tally tally;
    for (const Table& table : now.tables) {
        const auto old_table =
            std::find_if(then.tables.begin(), then.tables.end(), [&](const Table& t) { return t.key == table.key; });
        std::map<std::string, std::size_t> old_rows;
        if (old_table != then.tables.end())
            for (std::size_t row = 0; row < old_table->rows.size(); ++row)
                old_rows.emplace(name_of(*old_table, row), row);
        std::size_t matched = 0;
        for (std::size_t row = 0; row < table.rows.size(); ++row) {
            const auto found = old_rows.find(name_of(table, row));
            if (found == old_rows.end()) {
                ++tally.unmatched;
                continue;
            }
            ++matched;
            compare_rows(table, row, *old_table, found->second, same_machine, tally);
        }
        tally.unmatched += old_rows.size() - std::min(matched, old_rows.size());
    }
    std::stable_sort(tally.changes.begin(), tally.changes.end(),
                     [](const Change& a, const Change& b) { return a.size > b.size; });
    std::vector<std::string> out;
    for (const Change& change : tally.changes) out.push_back(change.line);
    if (!same_machine)
        out.push_back(
            fmt::format("{} times not compared: they come from another machine or compiler", tally.other_machine));
    out.push_back(
        fmt::format("{} changed; {} within the noise; {} taken fewer than {} times, so nothing is said; {} "
                    "points in one run only",
                    tally.changes.size(), tally.same, tally.too_seldom, kEnoughRepetitions, tally.unmatched));
    return out;
}

}  // namespace dgm::bench
