// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/table.cpp
#include "bench/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/pareto.h"
#include "model/codes.h"

namespace dgm::bench {

std::size_t Table::column(const std::string& column_key) const {
    const auto at = std::find_if(columns.begin(), columns.end(), [&](const Column& c) { return c.key == column_key; });
    if (at == columns.end())
        throw model::Error(model::codes::kInternal, "table " + key + " has no column " + column_key);
    return static_cast<std::size_t>(at - columns.begin());
}

double Table::number(std::size_t row, const std::string& column_key) const {
    const auto* figure = std::get_if<Figure>(&rows[row].cells[column(column_key)]);
    return figure != nullptr ? figure->value : std::numeric_limits<double>::quiet_NaN();
}

std::string Table::text(std::size_t row, const std::string& column_key) const {
    const auto* text = std::get_if<std::string>(&rows[row].cells[column(column_key)]);
    return text != nullptr ? *text : std::string();
}

std::vector<std::size_t> front_of(const Table& table, const Plot& plot, const std::string& facet) {
    std::vector<Cost> points(table.rows.size());
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        const bool here = plot.facet.empty() || table.text(row, plot.facet) == facet;
        const double out = std::numeric_limits<double>::quiet_NaN();
        points[row] = here ? Cost{table.number(row, plot.x), table.number(row, plot.y)} : Cost{out, out};
    }
    return pareto_front(points);
}

std::vector<std::string> values_of(const Table& table, const std::string& column_key) {
    if (column_key.empty()) return {""};
    std::vector<std::string> out;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        const std::string value = table.text(row, column_key);
        if (std::find(out.begin(), out.end(), value) == out.end()) out.push_back(value);
    }
    return out;
}

std::string three_digits(double value) {
    if (value == 0 || !std::isfinite(value)) return fmt::format("{}", value);
    const double size = std::fabs(value);
    if (size < 1e-3 || size >= 1e7) return fmt::format("{:.2e}", value);
    const int digits = std::max(0, 2 - static_cast<int>(std::floor(std::log10(size))));
    return fmt::format("{:.{}f}", value, digits);
}

std::string shown(const Cell& cell, const Column& column) {
    if (const auto* text = std::get_if<std::string>(&cell)) return *text;
    const auto* figure = std::get_if<Figure>(&cell);
    if (figure == nullptr || !std::isfinite(figure->value)) return "";
    if (!column.timed) return three_digits(figure->value);
    if (figure->repetitions < 2) return three_digits(figure->value) + " (once)";
    return fmt::format("{} +- {:.0f} %", three_digits(figure->value), 100 * (figure->high / figure->value - 1));
}

}  // namespace dgm::bench
