// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/scene_file.cpp
#include "scene/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "baking/materials.h"
#include "baking/option_names.h"
#include "baking/option_text.h"
#include "model/codes.h"
#include "scene/material_file.h"
#include "scene/toml_tree.h"
#include "tool/help.h"

namespace dgm::scene {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

constexpr std::size_t kMaxAssets = 100'000;
using Kind = TomlNode::Kind;

class Table;

/// Throws the fault in a value, with its place.
class Say {
 public:
    Say(const Table& table, const TomlNode& at, std::string_view key) : table_(table), at_(at), key_(key) {}
    [[noreturn]] void operator()(const std::string& message) const;
    /// For text that a parser of option_text.h takes; its refusals begin with the name of the key.
    template <class Parse>
    auto parsed(Parse parse) const;

 private:
    const Table& table_;
    const TomlNode& at_;
    std::string_view key_;
};

/// The value of a node; nullopt if it is of another type.
template <class T>
std::optional<T> value_of(const TomlNode& node) {
    if constexpr (std::is_same_v<T, double>) {
        // 5 is a number as well as 5.0; NaN and infinity are TOML, but no lengths.
        const std::optional<double> number = node.number();
        return number && std::isfinite(*number) ? number : std::nullopt;
    } else if constexpr (std::is_same_v<T, std::string>) {
        return node.kind == Kind::kString ? std::optional(node.text) : std::nullopt;
    } else if constexpr (std::is_same_v<T, bool>) {
        return node.kind == Kind::kBoolean ? std::optional(node.integer != 0) : std::nullopt;
    } else {
        static_assert(std::is_same_v<T, std::int64_t>);
        return node.kind == Kind::kInteger ? std::optional(node.integer) : std::nullopt;
    }
}

/// One table of the file: every key that is asked for is known, any other is a mistake.
class Table {
 public:
    Table(const TomlNode& table, const fs::path& file, std::string title)
        : table_(table), file_(file), title_(std::move(title)) {}

    [[noreturn]] void wrong(const TomlNode& at, const std::string& message) const {
        fail(file_, at.place, fmt::format("{}: {}", title_, message));
    }
    [[noreturn]] static void fail(const fs::path& file, const TomlPlace& at, const std::string& message) {
        throw model::Error(codes::kSceneInvalid, message, fmt::format("{}:{}:{}", file.string(), at.line, at.column));
    }
    [[noreturn]] void wrong_here(const std::string& message) const { wrong(table_, message); }

    /// Calls `take(value, say)` with the value of a key if it is there; `say(message)` ends with its place.
    template <class T, class Take>
    void get(std::string_view key, std::string_view what, Take take) {
        known_.emplace_back(key);
        const TomlNode* node = table_.get(key);
        if (node == nullptr) return;
        const Say say{*this, *node, key};
        const std::optional<T> value = value_of<T>(*node);
        if (!value) say(fmt::format("this is not {}", what));
        take(*value, say);
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
        const TomlNode* node = table_.get(key);
        if (node == nullptr) return;
        if (node->kind != Kind::kArray) wrong(*node, fmt::format("{}: write a list of names in brackets", key));
        into.clear();
        for (const TomlNode& entry : node->entries) {
            const auto text = value_of<std::string>(entry);
            if (!text) wrong(entry, fmt::format("{}: this is not a name in quotes", key));
            if (std::find(allowed.begin(), allowed.end(), *text) == allowed.end())
                wrong(entry, tool::unknown_word(key, *text, {allowed.begin(), allowed.end()}));
            if (std::find(into.begin(), into.end(), *text) == into.end()) into.push_back(*text);
        }
        if (into.empty()) wrong(*node, fmt::format("{}: the list is empty", key));
    }
    const TomlNode* node(std::string_view key) {
        known_.emplace_back(key);
        return table_.get(key);
    }
    /// A table below this one; nullptr if it is not there.
    const TomlNode* table(std::string_view key) {
        const TomlNode* found = node(key);
        if (found != nullptr && found->kind != Kind::kTable)
            wrong(*found, fmt::format("{} must be a table: [{}]", key, key));
        return found;
    }
    /// Call last: refuses keys that nothing has asked for.
    void finish() const {
        for (std::size_t k = 0; k < table_.keys.size(); ++k)
            if (std::find(known_.begin(), known_.end(), table_.keys[k]) == known_.end())
                fail(file_, table_.key_places[k], title_ + ": " + tool::unknown_word("key", table_.keys[k], known_));
    }

 private:
    const TomlNode& table_;
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
    table.word("unit", bake::kUnitNames, [&](double metres) { asset.metres_per_unit = metres; });
    table.get<std::string>("material", "a word in quotes", [&](const std::string& text, const Say& say) {
        asset.material = bake::value_of(bake::kMaterialNames, text);
        asset.material_file.clear();
        if (asset.material) return;
        std::vector<std::string> words;
        words.reserve(std::size(bake::kMaterialNames));
        for (const auto& row : bake::kMaterialNames) words.emplace_back(row.name);
        if (!text.ends_with(".toml")) say(tool::unknown_word("material", text, words) + ", or name a .toml file");
        asset.material_file = (folder / text).lexically_normal();
    });
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
    if ((asset.material || !asset.material_file.empty()) && !asset.metres_per_unit)
        table.wrong_here("a material needs the length of a unit of the mesh: unit = \"mm\"");
    return asset;
}

Scene read(const TomlNode& root, const fs::path& file) {
    const fs::path folder = file.parent_path();
    Scene out;
    SceneAsset defaults;
    Table top(root, file, "scene file");
    if (const TomlNode* scene = top.table("scene")) {
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
    if (const TomlNode* wishes = top.table("defaults")) {
        Table table(*wishes, file, "[defaults]");
        read_wishes(table, defaults, folder);
        table.finish();
    }
    const TomlNode* assets = top.node("asset");
    top.finish();
    if (assets == nullptr || assets->kind != Kind::kArray || assets->entries.empty())
        Table::fail(file, assets == nullptr ? root.place : assets->place,
                    "a scene has assets: [[asset]] with source = \"FILE\"");
    if (assets->entries.size() > kMaxAssets)
        Table::fail(file, assets->place, fmt::format("more than {} assets", kMaxAssets));
    std::set<std::string> names;
    for (const TomlNode& entry : assets->entries) {
        if (entry.kind != Kind::kTable) Table::fail(file, entry.place, "an asset is a table: [[asset]]");
        const int line = static_cast<int>(entry.place.line);
        Table wishes(entry, file, fmt::format("[[asset]] {}", out.assets.size() + 1));
        out.assets.push_back(read_asset(wishes, defaults, folder));
        out.assets.back().line = line;
        if (!names.insert(out.assets.back().name).second)
            wishes.wrong_here(
                fmt::format("another asset is called {}, too; give this one a name = \"...\"", out.assets.back().name));
    }
    return out;
}

}  // namespace

Scene parse_scene(std::string_view text, const fs::path& file) {
    return read(parse_toml(text, file), file);
}

Scene read_scene(const fs::path& file) {
    Scene out = read(read_toml_apart(file), file);
    std::map<fs::path, Material> materials;  // each is read once
    for (SceneAsset& asset : out.assets) {
        if (asset.material_file.empty()) continue;
        auto found = materials.find(asset.material_file);
        if (found == materials.end())
            found = materials.emplace(asset.material_file, read_material(asset.material_file)).first;
        asset.material = found->second;
    }
    return out;
}

}  // namespace dgm::scene
