// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/scene_file.cpp
#include "scene/scene_file.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>

#include "baking/option_names.h"
#include "baking/option_text.h"
#include "files/nesting.h"
#include "files/regular_file.h"
#include "model/codes.h"
#include "tool/help.h"

namespace dgm::scene {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

constexpr std::size_t kMaxAssets = 100'000, kMaxFileBytes = std::size_t{16} << 20;

class Table;

/// Throws the fault in a value, with its place.
class Say {
 public:
    Say(const Table& table, const toml::node& at, std::string_view key) : table_(table), at_(at), key_(key) {}
    [[noreturn]] void operator()(const std::string& message) const;
    /// For text that a parser of option_text.h takes; its refusals begin with the name of the key.
    template <class Parse>
    auto parsed(Parse parse) const;

 private:
    const Table& table_;
    const toml::node& at_;
    std::string_view key_;
};

/// One table of the file: every key that is asked for is known, any other is a mistake.
class Table {
 public:
    Table(const toml::table& table, const fs::path& file, std::string title)
        : table_(table), file_(file), title_(std::move(title)) {}

    [[noreturn]] void wrong(const toml::node& at, const std::string& message) const {
        fail(file_, at.source(), fmt::format("{}: {}", title_, message));
    }
    [[noreturn]] static void fail(const fs::path& file, const toml::source_region& at, const std::string& message) {
        throw model::Error(codes::kSceneInvalid, message,
                           fmt::format("{}:{}:{}", file.string(), at.begin.line, at.begin.column));
    }
    [[noreturn]] void wrong_here(const std::string& message) const { wrong(table_, message); }

    /// Calls `take(value, say)` with the value of a key if it is there; `say(message)` ends with its place.
    template <class T, class Take>
    void get(std::string_view key, std::string_view what, Take take) {
        known_.emplace_back(key);
        const toml::node* node = table_.get(key);
        if (node == nullptr) return;
        const Say say{*this, *node, key};
        if constexpr (std::is_same_v<T, double>) {
            // 5 is a number as well as 5.0; NaN and infinity are TOML, but no lengths.
            const auto value = node->value<double>();
            if (!node->is_number() || !value || !std::isfinite(*value)) say(fmt::format("this is not {}", what));
            take(*value, say);
        } else {
            const auto value = node->value_exact<T>();
            if (!value) say(fmt::format("this is not {}", what));
            take(*value, say);
        }
    }
    void flag(std::string_view key, bool& into) {
        get<bool>(key, "true or false", [&](bool value, const Say&) { into = value; });
    }
    template <class E, std::size_t N>
    void word(std::string_view key, const std::array<bake::NamedValue<E>, N>& table, auto assign) {
        get<std::string>(key, "a word in quotes", [&](const std::string& text, const Say& say) {
            if (const auto value = bake::value_of(table, text)) return assign(*value);
            std::vector<std::string> words;
            words.reserve(N);
            for (const auto& row : table) words.emplace_back(row.name);
            say(tool::unknown_word("value", text, words));
        });
    }
    void names(std::string_view key, std::span<const std::string_view> allowed, std::vector<std::string>& into) {
        known_.emplace_back(key);
        const toml::node* node = table_.get(key);
        if (node == nullptr) return;
        const toml::array* list = node->as_array();
        if (list == nullptr) wrong(*node, fmt::format("{}: write a list of names in brackets", key));
        into.clear();
        for (const toml::node& entry : *list) {
            const auto text = entry.value_exact<std::string>();
            if (!text) wrong(entry, fmt::format("{}: this is not a name in quotes", key));
            if (std::find(allowed.begin(), allowed.end(), *text) == allowed.end())
                wrong(entry, tool::unknown_word(key, *text, {allowed.begin(), allowed.end()}));
            if (std::find(into.begin(), into.end(), *text) == into.end()) into.push_back(*text);
        }
        if (into.empty()) wrong(*node, fmt::format("{}: the list is empty", key));
    }
    const toml::node* node(std::string_view key) {
        known_.emplace_back(key);
        return table_.get(key);
    }
    /// A table below this one; nullptr if it is not there.
    const toml::table* table(std::string_view key) {
        const toml::node* found = node(key);
        if (found != nullptr && found->as_table() == nullptr)
            wrong(*found, fmt::format("{} must be a table: [{}]", key, key));
        return found == nullptr ? nullptr : found->as_table();
    }
    /// Call last: refuses keys that nothing has asked for.
    void finish() const {
        for (const auto& [key, value] : table_)
            if (std::find(known_.begin(), known_.end(), key.str()) == known_.end())
                fail(file_, key.source(), title_ + ": " + tool::unknown_word("key", std::string(key.str()), known_));
    }

 private:
    const toml::table& table_;
    const fs::path& file_;
    std::string title_;
    std::vector<std::string> known_;
};

void Say::operator()(const std::string& message) const {
    table_.wrong(at_, fmt::format("{}: {}", key_, message));
}

template <class Parse>
auto Say::parsed(Parse parse) const {
    try {
        return parse();
    } catch (const model::Error& error) { table_.wrong(at_, error.what()); }
}

/// "0.05 %", "1.5 px", or "0.2" in source units.
Tolerance parse_tolerance(const std::string& text, const Say& say) {
    Tolerance out;
    const bake::Quantity read = say.parsed([&] {
        return bake::parse_quantity("tolerance", text, {"%", "px"}, "0.05%, 0.2 or 1px");
    });
    out.value = read.value;
    out.unit = read.unit == "%"    ? ToleranceUnit::kPercent
               : read.unit == "px" ? ToleranceUnit::kPixels
                                   : ToleranceUnit::kSource;
    return out;
}

void read_view(Table& table, View& view) {
    table.get<double>("fov", "an angle in degrees", [&](double value, const Say& say) {
        if (!(value >= 1 && value <= 170)) say("a vertical field of view has 1 to 170 degrees");
        view.fov_degrees = value;
    });
    table.get<std::int64_t>("resolution", "a whole number of rows", [&](std::int64_t value, const Say& say) {
        if (value < 16 || value > 65536) say("a picture has 16 to 65536 rows");
        view.rows = static_cast<std::uint32_t>(value);
    });
}

void read_bytes(Table& table, std::string_view key, std::optional<std::uint64_t>& into) {
    table.get<std::string>(key, "a size in quotes, such as \"256KiB\"", [&](const std::string& text, const Say& say) {
        into = say.parsed([&] { return bake::parse_bytes(key, text, "256KiB"); });
    });
}

/// Reads the keys that [defaults] and [[asset]] share.
void read_wishes(Table& table, SceneAsset& asset, const fs::path& folder) {
    read_view(table, asset.view);
    const bake::ErrorKind kind = asset.tolerance.kind;
    table.get<std::string>("tolerance", "an error in quotes, such as \"0.05%\", \"0.2\" or \"1px\"",
                           [&](const std::string& text, const Say& say) {
                               asset.tolerance = parse_tolerance(text, say);
                               asset.tolerance.kind = kind;
                           });
    table.word("tolerance_kind", bake::kErrorKindNames, [&](bake::ErrorKind k) { asset.tolerance.kind = k; });
    table.get<double>("distance", "a length in the source's units", [&](double value, const Say& say) {
        if (!(value > 0)) say("a distance is above zero");
        asset.distance = value;
    });
    table.flag("touched", asset.touched);
    table.word("footprint", kFootprintNames, [&](Footprint f) { asset.footprint = f; });
    table.get<std::string>("reach", "a length in quotes, such as \"5%\" or \"12\"",
                           [&](const std::string& text, const Say& say) {
                               const bake::Quantity read =
                                   say.parsed([&] { return bake::parse_quantity("reach", text, {"%"}, "5% or 12"); });
                               asset.reach = {read.value, read.unit == "%"};
                           });
    table.flag("contact", asset.contact);
    table.flag("lit", asset.lit);
    table.flag("textured", asset.textured);
    table.flag("detail", asset.detail);
    table.names("layers", bake::kLayerNames, asset.layers);
    read_bytes(table, "texture_budget", asset.texture_budget);
    read_bytes(table, "budget", asset.budget);
    table.get<std::string>("fabric", "a file name in quotes", [&](const std::string& text, const Say& say) {
        if (text.empty()) say("the name is empty");
        asset.fabric = (folder / text).lexically_normal();
    });
    table.get<std::string>(
        "largest", "a size in quotes, such as \"513x513\"", [&](const std::string& text, const Say& say) {
            asset.largest =
                say.parsed([&] { return bake::parse_size("largest", text, bake::kMinSide, bake::kMaxSide); });
        });
    table.get<std::string>("method", "a word in quotes", [&](const std::string& text, const Say& say) {
        const std::optional<bake::Method> method = bake::method_of(text);
        if (!method) say(tool::unknown_word("method", text, {bake::kMethodNames.begin(), bake::kMethodNames.end()}));
        asset.method = *method;
    });
    table.word("domain", bake::kDomainNames, [&](bake::DomainChoice d) { asset.domain = d; });
    table.word("fit", bake::kFitNames, [&](bake::Fit f) { asset.fit = f; });
    table.word("precision", bake::kPrecisionNames, [&](bake::Precision p) { asset.precision = p; });
}

SceneAsset read_asset(Table& table, SceneAsset asset, const fs::path& folder) {
    table.get<std::string>("source", "a file name in quotes", [&](const std::string& text, const Say& say) {
        if (text.empty()) say("the name is empty");
        asset.source = (folder / text).lexically_normal();
        asset.name = asset.source.stem().string();
    });
    table.get<std::string>("name", "a name in quotes", [&](const std::string& text, const Say& say) {
        const fs::path path = fs::path(text).lexically_normal();
        const bool leaves = path.is_absolute() || path.empty() || *path.begin() == ".." || !path.has_filename();
        if (leaves || text.find('\0') != std::string::npos || path == ".")
            say("a name is that of a file below the output folder, without extension");
        asset.name = path.string();
    });
    read_wishes(table, asset, folder);
    table.finish();
    if (asset.source.empty()) table.wrong_here("source is missing: name the mesh file");
    if (asset.tolerance.unit == ToleranceUnit::kPixels && !asset.distance)
        table.wrong_here("a tolerance in pixels needs the nearest viewing distance: distance = 2.0");
    return asset;
}

Scene read(const toml::table& root, const fs::path& file) {
    const fs::path folder = file.parent_path();
    Scene out;
    SceneAsset defaults;
    Table top(root, file, "scene file");
    if (const toml::table* scene = top.table("scene")) {
        Table table(*scene, file, "[scene]");
        table.get<std::string>("name", "a name in quotes",
                               [&](const std::string& text, const Say&) { out.name = text; });
        read_bytes(table, "budget", out.budget);
        table.get<double>("tick_budget", "a number of microseconds", [&](double value, const Say& say) {
            if (!(value > 0)) say("a time is above zero");
            out.tick_budget = value * 1e-6;
        });
        table.finish();
    }
    if (const toml::table* wishes = top.table("defaults")) {
        Table table(*wishes, file, "[defaults]");
        read_wishes(table, defaults, folder);
        table.finish();
    }
    const toml::node* assets = top.node("asset");
    top.finish();
    const toml::array* list = assets == nullptr ? nullptr : assets->as_array();
    if (list == nullptr || list->empty())
        Table::fail(file, assets == nullptr ? root.source() : assets->source(),
                    "a scene has assets: [[asset]] with source = \"FILE\"");
    if (list->size() > kMaxAssets) Table::fail(file, list->source(), fmt::format("more than {} assets", kMaxAssets));
    std::set<std::string> names;
    for (const toml::node& entry : *list) {
        const toml::table* table = entry.as_table();
        if (table == nullptr) Table::fail(file, entry.source(), "an asset is a table: [[asset]]");
        const int line = static_cast<int>(entry.source().begin.line);
        Table wishes(*table, file, fmt::format("[[asset]] {}", out.assets.size() + 1));
        out.assets.push_back(read_asset(wishes, defaults, folder));
        out.assets.back().line = line;
        if (!names.insert(out.assets.back().name).second)
            wishes.wrong_here(
                fmt::format("another asset is called {}, too; give this one a name = \"...\"", out.assets.back().name));
    }
    return out;
}

[[noreturn]] void refuse_size(const fs::path& file) {
    throw model::Error(codes::kSceneInvalid, "the scene file is larger than 16 MiB", file.string());
}

}  // namespace

Scene parse_scene(std::string_view text, const fs::path& file) {
    if (text.size() > kMaxFileBytes) refuse_size(file);
    if (const auto deep = formats::too_deep_toml(text, formats::kMostNesting))
        throw model::Error(codes::kSceneInvalid,
                           fmt::format("keys or values nested more than {} deep", formats::kMostNesting),
                           fmt::format("{}:{}:{}", file.string(), deep->line, deep->column));
    toml::table root;
    try {
        root = toml::parse(text, file.string());
    } catch (const toml::parse_error& e) { Table::fail(file, e.source(), std::string(e.description())); }
    return read(root, file);
}

Scene read_scene(const fs::path& file) {
    formats::RegularFile in(file);
    if (in.size() > kMaxFileBytes) refuse_size(file);
    return parse_scene(in.read_text(kMaxFileBytes), file);
}

}  // namespace dgm::scene
