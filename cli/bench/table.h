// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/table.h
// Results of a run of dgm-bench, as tables that know which of their figures can be compared and how.
#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "bench/statistics.h"

namespace dgm::bench {

enum class Sense { kNone, kLower, kHigher };  ///< which way is better

struct Column {
    std::string key;    ///< of CSV and JSON: "rms_percent"
    std::string title;  ///< for people: "rms"
    std::string unit;   ///< "%", "s", "bytes"; empty for text and counts
    Sense sense = Sense::kNone;
    bool timed = false;       ///< differs from run to run; its figures have a spread
    bool identifies = false;  ///< rows of two runs are the same point if these columns agree
    double tolerance = 1e-9;  ///< not timed: relative difference that means nothing, such as another sample of points
};

using Cell = std::variant<std::monostate, std::string, Figure>;  ///< monostate: no value

struct Row {
    std::vector<Cell> cells;  ///< one a column
};

/// Two columns against each other, a point a row, logarithmic both ways.
struct Plot {
    std::string title, x, y;  ///< keys of columns
    std::string series;       ///< key of the text column that gives the colour
    std::string facet;        ///< key of the text column with a picture for each value; empty: one picture
    bool joined = false;      ///< draw a line through the points of a series, else along the Pareto front
};

struct Table {
    std::string key, title, note;
    std::vector<Column> columns;
    std::vector<Row> rows;
    std::vector<Plot> plots;

    /// Place of a column. @throws model::Error kInternal if there is none
    [[nodiscard]] std::size_t column(const std::string& column_key) const;
    /// NaN where the cell holds no figure.
    [[nodiscard]] double number(std::size_t row, const std::string& column_key) const;
    /// Empty where the cell holds no text.
    [[nodiscard]] std::string text(std::size_t row, const std::string& column_key) const;
};

using Pairs = std::vector<std::pair<std::string, std::string>>;

struct Run {
    std::string command;  ///< "bake", "run", "physics", "cloth", "stability", "scale"
    Pairs machine, settings;
    std::vector<Table> tables;
    std::vector<std::string> findings;    ///< in words: recommendations, where methods fail, exponents
    std::vector<std::string> comparison;  ///< --compare
};

/// Rows of a plot's facet that no other row of it beats in both coordinates, by rising x. Lower is better on both axes.
[[nodiscard]] std::vector<std::size_t> front_of(const Table& table, const Plot& plot, const std::string& facet);

/// The values of a text column in the order of their first row; one empty text for an empty key.
[[nodiscard]] std::vector<std::string> values_of(const Table& table, const std::string& column_key);

/// A cell as people read it: "0.0123", "1.23 +- 0.05", "1.2 (once)".
[[nodiscard]] std::string shown(const Cell& cell, const Column& column);

/// Three significant digits.
[[nodiscard]] std::string three_digits(double value);

}  // namespace dgm::bench
