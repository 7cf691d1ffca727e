// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/toml_tree.cpp
#include "scene/toml_tree.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>

#include "files/nesting.h"
#include "model/codes.h"

namespace dgm::scene {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using Kind = TomlNode::Kind;

[[noreturn]] void refuse(const std::string& message, const fs::path& file) {
    throw model::Error(codes::kSceneInvalid, message, file.string());
}

TomlPlace place_of(const toml::source_region& region) {
    return {region.begin.line, region.begin.column};
}

/// Copies what toml++ has made; it calls itself once a level, and levels are bounded.
class Copier {
 public:
    explicit Copier(const fs::path& file) : file_(file) {}

    TomlNode operator()(const toml::node& node) {
        if (++values_ > kMostTomlValues) refuse(fmt::format("more than {} values", kMostTomlValues), file_);
        TomlNode out;
        out.kind = Kind::kOther;
        out.place = place_of(node.source());
        if (const toml::table* table = node.as_table()) {
            out.kind = Kind::kTable;
            for (const auto& [key, value] : *table) {
                out.keys.emplace_back(key.str());
                out.key_places.push_back(place_of(key.source()));
                out.entries.push_back((*this)(value));
            }
        } else if (const toml::array* array = node.as_array()) {
            out.kind = Kind::kArray;
            for (const toml::node& entry : *array) out.entries.push_back((*this)(entry));
        } else if (const auto text = node.value_exact<std::string>()) {
            out.kind = Kind::kString;
            out.text = *text;
        } else if (const auto integer = node.value_exact<std::int64_t>()) {
            out.kind = Kind::kInteger;
            out.integer = *integer;
        } else if (const auto real = node.value_exact<double>()) {
            out.kind = Kind::kFloat;
            out.real = *real;
        } else if (const auto flag = node.value_exact<bool>()) {
            out.kind = Kind::kBoolean;
            out.integer = *flag ? 1 : 0;
        }
        return out;
    }

 private:
    const fs::path& file_;
    std::size_t values_ = 0;
};

}  // namespace

const TomlNode* TomlNode::get(std::string_view key) const {
    const auto found = std::lower_bound(keys.begin(), keys.end(), key);
    return found == keys.end() || *found != key ? nullptr : &entries[static_cast<std::size_t>(found - keys.begin())];
}

std::optional<double> TomlNode::number() const {
    if (kind == Kind::kFloat) return real;
    if (kind != Kind::kInteger) return std::nullopt;
    constexpr std::int64_t kExact = std::int64_t{1} << 53;
    if (integer < -kExact || integer > kExact) return std::nullopt;
    return static_cast<double>(integer);
}

TomlNode parse_toml(std::string_view text, const fs::path& file) {
    if (text.size() > kMostTomlBytes) refuse("the file is larger than 16 MiB", file);
    if (const auto deep = formats::too_deep_toml(text, formats::kMostNesting))
        throw model::Error(codes::kSceneInvalid,
                           fmt::format("keys or values nested more than {} deep", formats::kMostNesting),
                           fmt::format("{}:{}:{}", file.string(), deep->line, deep->column));
    try {
        return Copier(file)(toml::parse(text, file.string()));
    } catch (const toml::parse_error& e) {
        throw model::Error(codes::kSceneInvalid, std::string(e.description()),
                           fmt::format("{}:{}:{}", file.string(), e.source().begin.line, e.source().begin.column));
    }
}

}  // namespace dgm::scene
