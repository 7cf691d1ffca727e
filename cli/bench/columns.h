// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/columns.h
// Short ways to write the columns and rows of a sweep down.
#pragma once
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "bench/table.h"

namespace dgm::bench {

/// Text that says which point a row is.
[[nodiscard]] inline Column key_column(std::string key, std::string title) {
    Column out{std::move(key), std::move(title), ""};
    out.identifies = true;
    return out;
}
/// Text about the result.
[[nodiscard]] inline Column text_column(std::string key, std::string title) {
    return {std::move(key), std::move(title), ""};
}
/// Something that differs from run to run; less is better.
[[nodiscard]] inline Column time_column(std::string key, std::string title, std::string unit) {
    Column out{std::move(key), std::move(title), std::move(unit), Sense::kLower};
    out.timed = true;
    return out;
}
/// Something that does not, to within `tolerance` (relative).
[[nodiscard]] inline Column exact_column(std::string key, std::string title, std::string unit, Sense sense,
                                         double tolerance = 1e-9) {
    Column out{std::move(key), std::move(title), std::move(unit), sense};
    out.tolerance = tolerance;
    return out;
}

/// One list after the other.
[[nodiscard]] inline std::vector<Column> joined(std::initializer_list<std::vector<Column>> lists) {
    std::vector<Column> out;
    for (const std::vector<Column>& list : lists) out.insert(out.end(), list.begin(), list.end());
    return out;
}

/// Columns for the cost of a bake, which set_bake() fills (result_figures.h).
[[nodiscard]] inline std::vector<Column> bake_columns() {
    return {time_column("cpu_seconds", "bake CPU", "s"), time_column("wall_seconds", "bake wall", "s"),
            time_column("memory_mib", "peak memory", "MiB")};
}

/// A row of `table`, filled by keys. @throws model::Error kInternal for a key that the table does not have
class RowBuilder {
 public:
    explicit RowBuilder(const Table& table) : table_(table) { row_.cells.resize(table.columns.size()); }
    void set(const std::string& key, Cell cell) { row_.cells[table_.column(key)] = std::move(cell); }
    [[nodiscard]] const Row& row() const { return row_; }

 private:
    const Table& table_;
    Row row_;
};

}  // namespace dgm::bench
