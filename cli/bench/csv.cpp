// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/csv.cpp
#include <fmt/format.h>

#include <cmath>

#include "bench/run_files.h"

namespace dgm::bench {
namespace {

std::string quoted(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"') out += '"';
        out += c;
    }
    return out + '"';
}

std::string number(double value) {
    return std::isfinite(value) ? fmt::format("{}", value) : "";
}

}  // namespace

std::string to_csv(const Table& table) {
    std::string out;
    bool first = true;
    const auto put = [&](const std::string& field) {
        if (!first) out += ',';
        out += field;
        first = false;
    };
    const auto end_line = [&] {
        out += '\n';
        first = true;
    };
    for (const Column& c : table.columns) {
        put(quoted(c.key));
        if (c.timed)
            for (const char* part : {"_low", "_high", "_n"}) put(quoted(c.key + part));
    }
    end_line();
    for (const Row& row : table.rows) {
        for (std::size_t k = 0; k < row.cells.size(); ++k) {
            const auto* figure = std::get_if<Figure>(&row.cells[k]);
            const auto* text = std::get_if<std::string>(&row.cells[k]);
            put(figure != nullptr ? number(figure->value) : text != nullptr ? quoted(*text) : "");
            if (!table.columns[k].timed) continue;
            put(figure != nullptr ? number(figure->low) : "");
            put(figure != nullptr ? number(figure->high) : "");
            put(figure != nullptr ? std::to_string(figure->repetitions) : "");
        }
        end_line();
    }
    return out;
}

std::string facts_csv(const Run& run) {
    std::string out = "kind,name,value\n";
    for (const auto& [name, value] : run.machine) out += "machine," + quoted(name) + "," + quoted(value) + "\n";
    for (const auto& [name, value] : run.settings) out += "setting," + quoted(name) + "," + quoted(value) + "\n";
    return out;
}

}  // namespace dgm::bench
