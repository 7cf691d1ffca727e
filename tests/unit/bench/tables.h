// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/bench/tables.h
#pragma once
#include "bench/table.h"

namespace dgm::bench::test {

inline Figure times(std::vector<double> seconds) {
    return summarize(seconds);
}

/// Columns name (identifies), error (lower is better, 1 % means nothing) and time.
inline Run run_of(std::vector<Row> rows) {
    Table t;
    t.key = "bake";
    t.title = "A table";
    t.columns.resize(3);
    t.columns[0] = {"name", "name", "", Sense::kNone, false, true};
    t.columns[1] = {"rms", "rms", "%", Sense::kLower, false, false, 0.01};
    t.columns[2] = {"seconds", "CPU", "s", Sense::kLower, true, false};
    t.rows = std::move(rows);
    t.plots = {{"rms against time", "seconds", "rms", "name", "", false}};
    Run run;
    run.command = "bake";
    run.machine = {{"processor", "abacus"}, {"cores", "2"}, {"compiler", "c"}, {"build", "Release"}};
    run.tables = {t};
    return run;
}

}  // namespace dgm::bench::test
