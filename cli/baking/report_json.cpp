// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/report_json.cpp
// BakeReport <-> JSON. Each struct lists its fields once, in `fields`; a writer and a reader walk the same list.
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "baking/bake_report.h"
#include "baking/option_names.h"
#include "files/nesting.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using nlohmann::json;

constexpr std::array kSearchGoalNames{NamedValue<SearchGoal>{"max-error", SearchGoal::kMaxError},
                                      NamedValue<SearchGoal>{"budget", SearchGoal::kBudget},
                                      NamedValue<SearchGoal>{"samples", SearchGoal::kSamples}};

[[noreturn]] void malformed(const std::string& what) {
    throw model::Error(model::codes::kInternal, "malformed bake report: " + what);
}

template <class A, class T>
void fields(A& a, T& e) requires std::is_same_v<std::remove_const_t<T>, SurfaceError> {
    a("rms", e.rms);
    a("hausdorff", e.hausdorff);
    a("rms_forward", e.rms_forward);
    a("rms_backward", e.rms_backward);
    a("hausdorff_forward", e.hausdorff_forward);
    a("hausdorff_backward", e.hausdorff_backward);
    a("normal_rms_degrees", e.normal_rms_degrees);
    a("normal_rms_face_degrees", e.normal_rms_face_degrees);
    a("normal_rms_bump_degrees", e.normal_rms_bump_degrees);
    a("diagonal", e.diagonal);
    a("samples", e.samples);
}

template <class A, class T>
void fields(A& a, T& m) requires std::is_same_v<std::remove_const_t<T>, MapMetrics> {
    a("stretch_l2", m.stretch_l2);
    a("stretch_linf", m.stretch_linf);
    a("symmetric_dirichlet", m.symmetric_dirichlet);
    a("angle", m.angle);
    a("area", m.area);
    a("flips", m.flips);
    a("degenerate", m.degenerate);
    a("not_finite", m.not_finite);
}

template <class A, class T>
void fields(A& a, T& t) requires std::is_same_v<std::remove_const_t<T>, Topology> {
    a("components", t.components);
    a("boundary_loops", t.boundary_loops);
    a("genus", t.genus);
    a("manifold", t.manifold);
    a("oriented", t.oriented);
    a("degenerate_faces", t.degenerate_faces);
}

template <class A, class T>
void fields(A& a, T& c) requires std::is_same_v<std::remove_const_t<T>, CandidateReport> {
    a("method", c.method);
    a("psnr", c.psnr);
    a("outcome", c.outcome);
    a.of_run("cpu_seconds", c.cpu_seconds);
}

template <class A, class T>
void fields(A& a, T& c) requires std::is_same_v<std::remove_const_t<T>, ChartReport> {
    a("method", c.method);
    a("domain", c.domain);
    a("rows", c.rows);
    a("cols", c.cols);
    a("source_vertices", c.source_vertices);
    a("source_faces", c.source_faces);
    a("error", c.error);
    a("map", c.map);
    a("utilisation", c.utilisation);
    a("seam_gap", c.seam_gap);
    a("cut_length", c.cut_length);
    a("cut_exposure", c.cut_exposure);
    a("volume_relative_error", c.volume_relative_error);
    a("seam_pairs", c.seam_pairs);
    a("turned_faces", c.turned_faces);
    a("source_topology", c.source_topology);
    a("map_topology", c.map_topology);
    a("candidates", c.candidates);
}

template <class A, class T>
void fields(A& a, T& t) requires std::is_same_v<std::remove_const_t<T>, StageTime> {
    a("stage", t.stage);
    a("seconds", t.seconds);
    a("cpu_seconds", t.cpu_seconds);
}

template <class A, class T>
void fields(A& a, T& t) requires std::is_same_v<std::remove_const_t<T>, GridTrial> {
    a("rows", t.rows);
    a("cols", t.cols);
    a("rms", t.rms);
    a("hausdorff", t.hausdorff);
    a("bytes", t.bytes);
    a("outcome", t.outcome);
    a.of_run("cpu_seconds", t.cpu_seconds);
}

template <class A, class T>
void fields(A& a, T& s) requires std::is_same_v<std::remove_const_t<T>, GridSearch> {
    a.word("goal", kSearchGoalNames, s.goal);
    a.word("kind", kErrorKindNames, s.kind);
    a("asked", s.asked);
    a("asked_percent", s.asked_percent);
    a("reached", s.reached);
    a("reached_percent", s.reached_percent);
    a("margin", s.margin);
    a("asked_bytes", s.asked_bytes);
    a("asked_samples", s.asked_samples);
    a("rows", s.rows);
    a("cols", s.cols);
    a("shapes", s.shapes);
    a("trials", s.trials);
    a("next", s.next);
}

template <class A, class T>
void fields(A& a, T& r) requires std::is_same_v<std::remove_const_t<T>, RepairCounts::value_type> {
    a("kind", r.first);
    a("count", r.second);
}

template <class A, class T>
void fields(A& a, T& e) requires std::is_same_v<std::remove_const_t<T>, MapEdit> {
    a("layer", e.layer);
    a("samples", e.samples);
    a("source", e.source);
    a("source_hash", e.source_hash);
}

template <class A, class T>
void fields(A& a, T& r) requires std::is_same_v<std::remove_const_t<T>, BakeReport> {
    a("source_name", r.source_name);
    a("inputs_hash", r.inputs_hash);
    a("source_vertices", r.source_vertices);
    a("source_faces", r.source_faces);
    a("error", r.error);
    a("worst_quantisation", r.worst_quantisation);
    a("repairs", r.repairs);
    a("warnings", r.warnings);
    a("charts", r.charts);
    a.if_any("remarks", r.remarks);
    a.if_any("inputs", r.inputs);
    a.if_any("missing_inputs", r.missing_inputs);
    a.if_any("edits", r.edits);
    a("search", r.search);
    a.of_run("times", r.times);
    a.of_run("cpu_seconds", r.cpu_seconds);
    a.of_run("peak_memory_bytes", r.peak_memory_bytes);
}

json number(double value) {
    return std::isfinite(value) ? json(value) : json(nullptr);
}

struct Writer {
    bool with_times;
    json object = json::object();

    template <class T>
    json value(const T& v) {
        if constexpr (std::is_same_v<T, double>) {
            return number(v);
        } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
            return v;
        } else {
            Writer inner{with_times};
            fields(inner, v);
            if constexpr (std::is_same_v<T, SurfaceError>) {
                inner.object["psnr"] = number(v.psnr());
                inner.object["rms_percent"] = number(100 * v.rms / v.diagonal);
                inner.object["hausdorff_percent"] = number(100 * v.hausdorff / v.diagonal);
            }
            return inner.object;
        }
    }
    template <class T>
    json value(const std::vector<T>& list) {
        json out = json::array();
        for (const T& v : list) out.push_back(value(v));
        return out;
    }
    template <class T>
    void operator()(const char* key, const T& v) {
        object[key] = value(v);
    }
    template <class Table, class E>
    void word(const char* key, const Table& table, const E& v) {
        object[key] = name_of(table, v);
    }
    /// No value is an empty word.
    template <class Table, class E>
    void word(const char* key, const Table& table, const std::optional<E>& v) {
        object[key] = v ? name_of(table, *v) : std::string_view();
    }
    template <class T>
    void operator()(const char* key, const std::optional<T>& v) {
        if (v) object[key] = value(*v);
    }
    template <class T>
    void if_any(const char* key, const std::vector<T>& list) {
        if (!list.empty()) (*this)(key, list);
    }
    /// Values that differ from run to run.
    template <class T>
    void of_run(const char* key, const T& v) {
        if (with_times) object[key] = value(v);
    }
};

struct Reader {
    const json& object;

    template <class T>
    static void read(const char* key, const json& from, T& v) {
        if constexpr (std::is_same_v<T, bool>) {
            if (!from.is_boolean()) malformed(key);
            v = from.get<bool>();
        } else if constexpr (std::is_same_v<T, double>) {
            if (!from.is_number() && !from.is_null()) malformed(key);
            v = from.is_null() ? std::numeric_limits<double>::quiet_NaN() : from.get<double>();
        } else if constexpr (std::is_integral_v<T>) {
            if (!from.is_number_integer()) malformed(key);
            if (!from.is_number_unsigned() && std::is_unsigned_v<T>) malformed(key);
            if (from.is_number_unsigned() && from.get<std::uint64_t>() > std::uint64_t{std::numeric_limits<T>::max()})
                malformed(key);
            v = from.get<T>();
        } else if constexpr (std::is_same_v<T, std::string>) {
            if (!from.is_string()) malformed(key);
            v = from.get<std::string>();
        } else {
            if (!from.is_object()) malformed(key);
            Reader inner{from};
            fields(inner, v);
        }
    }
    template <class T>
    static void read(const char* key, const json& from, std::vector<T>& list) {
        if (!from.is_array()) malformed(key);
        list.clear();
        for (const json& item : from) read(key, item, list.emplace_back());
    }
    template <class T>
    static void read(const char* key, const json& from, std::optional<T>& v) {
        read(key, from, v.emplace());
    }
    template <class T>
    void if_any(const char* key, std::vector<T>& list) {
        (*this)(key, list);
    }
    template <class T>
    void of_run(const char* key, T& v) {
        (*this)(key, v);
    }
    template <class Table, class E>
    void word(const char* key, const Table& table, E& v) {
        std::string name;
        (*this)(key, name);
        if (name.empty()) return;
        const auto known = value_of(table, name);
        if (!known) malformed(key);
        v = *known;
    }
    template <class T>
    void operator()(const char* key, T& v) {
        if (const auto found = object.find(key); found != object.end()) read(key, *found, v);
    }
};

}  // namespace

std::string to_json(const BakeReport& report, bool with_times) {
    Writer writer{with_times};
    fields(writer, report);
    // Names come from strangers' files: bytes that are not UTF-8 become U+FFFD instead of an exception.
    return writer.object.dump(-1, ' ', false, json::error_handler_t::replace);
}

BakeReport report_from_json(std::string_view text) {
    if (formats::too_deep_json(text, formats::kMostNesting)) malformed("nested too deeply");
    const json parsed = json::parse(text, nullptr, false);
    if (!parsed.is_object()) malformed("not an object");
    BakeReport report;
    Reader reader{parsed};
    fields(reader, report);
    return report;
}

}  // namespace dgm::bake
