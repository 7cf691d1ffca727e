// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/json.cpp
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "bench/run_files.h"
#include "model/codes.h"

namespace dgm::bench {
namespace {

using nlohmann::ordered_json;

constexpr int kFormat = 1;

ordered_json number(double value) {
    return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json cell_json(const Cell& cell) {
    if (const auto* text = std::get_if<std::string>(&cell)) return *text;
    const auto* figure = std::get_if<Figure>(&cell);
    if (figure == nullptr) return nullptr;
    if (figure->repeatable) return number(figure->value);
    return {{"median", number(figure->value)},
            {"low", number(figure->low)},
            {"high", number(figure->high)},
            {"n", figure->repetitions}};
}

const char* sense_name(Sense sense) {
    return sense == Sense::kNone ? "none" : sense == Sense::kLower ? "lower" : "higher";
}

ordered_json pairs_json(const Pairs& pairs) {
    ordered_json out = ordered_json::object();
    for (const auto& [key, value] : pairs) out[key] = value;
    return out;
}

ordered_json plot_json(const Table& table, const Plot& plot) {
    ordered_json fronts = ordered_json::object();
    for (const std::string& facet : values_of(table, plot.facet)) fronts[facet] = front_of(table, plot, facet);
    return {{"title", plot.title}, {"x", plot.x},           {"y", plot.y},          {"series", plot.series},
            {"facet", plot.facet}, {"joined", plot.joined}, {"pareto_rows", fronts}};
}

ordered_json table_json(const Table& table) {
    ordered_json out{{"key", table.key}, {"title", table.title}, {"note", table.note}};
    out["columns"] = ordered_json::array();
    for (const Column& c : table.columns)
        out["columns"].push_back({{"key", c.key},
                                  {"title", c.title},
                                  {"unit", c.unit},
                                  {"better", sense_name(c.sense)},
                                  {"timed", c.timed},
                                  {"identifies", c.identifies},
                                  {"tolerance", c.tolerance}});
    out["rows"] = ordered_json::array();
    for (const Row& row : table.rows) {
        ordered_json cells = ordered_json::array();
        for (const Cell& cell : row.cells) cells.push_back(cell_json(cell));
        out["rows"].push_back(cells);
    }
    out["plots"] = ordered_json::array();
    for (const Plot& plot : table.plots) out["plots"].push_back(plot_json(table, plot));
    return out;
}

double number_from(const ordered_json& value) {
    return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

Cell cell_from(const ordered_json& value) {
    if (value.is_null()) return std::monostate();
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number()) return exactly(value.get<double>());
    return Figure{number_from(value.at("median")), number_from(value.at("low")), number_from(value.at("high")),
                  value.at("n").get<unsigned>(), false};
}

Pairs pairs_from(const ordered_json& value) {
    Pairs out;
    for (const auto& [key, text] : value.items()) out.emplace_back(key, text.get<std::string>());
    return out;
}

Table table_from(const ordered_json& value) {
    Table out{value.at("key").get<std::string>(),
              value.at("title").get<std::string>(),
              value.at("note").get<std::string>(),
              {},
              {},
              {}};
    for (const ordered_json& c : value.at("columns")) {
        const auto better = c.at("better").get<std::string>();
        const Sense sense = better == "lower" ? Sense::kLower : better == "higher" ? Sense::kHigher : Sense::kNone;
        out.columns.push_back({c.at("key").get<std::string>(), c.at("title").get<std::string>(),
                               c.at("unit").get<std::string>(), sense, c.at("timed").get<bool>(),
                               c.at("identifies").get<bool>(), c.at("tolerance").get<double>()});
    }
    for (const ordered_json& cells : value.at("rows")) {
        Row& row = out.rows.emplace_back();
        for (const ordered_json& cell : cells) row.cells.push_back(cell_from(cell));
        row.cells.resize(out.columns.size());
    }
    return out;
}

}  // namespace

std::string to_json(const Run& run) {
    ordered_json out{{"tool", "dgm-bench"}, {"format", kFormat}, {"command", run.command}};
    out["machine"] = pairs_json(run.machine);
    out["settings"] = pairs_json(run.settings);
    out["findings"] = run.findings;
    out["comparison"] = run.comparison;
    out["tables"] = ordered_json::array();
    for (const Table& table : run.tables) out["tables"].push_back(table_json(table));
    // Names come from strangers' files: bytes that are not UTF-8 become U+FFFD instead of an exception.
    return out.dump(1, ' ', false, ordered_json::error_handler_t::replace);
}

Run run_from_json(std::string_view text) {
    try {
        const ordered_json in = ordered_json::parse(text);
        if (in.at("tool") != "dgm-bench" || in.at("format").get<int>() != kFormat)
            throw model::Error(model::codes::kUsage, "not a JSON file of this version of dgm-bench");
        Run run;
        run.command = in.at("command").get<std::string>();
        run.machine = pairs_from(in.at("machine"));
        run.settings = pairs_from(in.at("settings"));
        for (const ordered_json& table : in.at("tables")) run.tables.push_back(table_from(table));
        return run;
    } catch (const ordered_json::exception& error) {
        throw model::Error(model::codes::kUsage, std::string("not a JSON file of dgm-bench: ") + error.what());
    }
}

}  // namespace dgm::bench
