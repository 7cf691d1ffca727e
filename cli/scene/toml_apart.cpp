// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/toml_apart.cpp
#include <algorithm>
#include <utility>

#include "files/regular_file.h"
#include "model/codes.h"
#include "process/apart_answer.h"
#include "process/byte_stream.h"
#include "scene/toml_tree.h"

namespace dgm::scene {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using Kind = TomlNode::Kind;

constexpr unsigned kMostSeconds = 60;
constexpr std::uint64_t kMostMemory = std::uint64_t{4} << 30, kMostAnswerBytes = std::uint64_t{1} << 30;
/// formats::kMostNesting is of each key and of each nest of brackets: a value's levels are their product at most.
constexpr int kMostLevels = 8192;

/// In the disposable process.
void work(const TomlParser& parse, std::string_view path) {
    const fs::path file(path);
    bake::answer_in_sandbox({.readable = {file}, .writable = {}, .cpu_seconds = kMostSeconds}, kMostMemory, [&] {
        formats::RegularFile in(file);
        if (in.size() > kMostTomlBytes)
            throw model::Error(codes::kSceneInvalid, "the file is larger than 16 MiB", file.string());
        return bake::send_head(encode_toml(parse(in.read_text(kMostTomlBytes), file)));
    });
}

void put(bake::ByteWriter& out, const TomlNode& node) {
    out.put(node.kind);
    out.put(node.place);
    switch (node.kind) {
        case Kind::kTable:
            out.put_each(node.keys, [&](const std::string& key) { out.put(key); });
            out.put_all(node.key_places);
            [[fallthrough]];
        case Kind::kArray:
            out.put_each(node.entries, [&](const TomlNode& entry) { put(out, entry); });
            break;
        case Kind::kString:
            out.put(node.text);
            break;
        case Kind::kFloat:
            out.put(node.real);
            break;
        default:
            out.put(node.integer);
    }
}

class Decoder {
 public:
    explicit Decoder(std::string_view bytes) : in_(bytes) {}

    std::optional<TomlNode> root() {
        TomlNode out = node(0);
        if (!fits_ || !in_.at_end() || out.kind != Kind::kTable) return std::nullopt;
        return out;
    }

 private:
    TomlNode node(int level) {
        TomlNode out;
        out.kind = in_.get<Kind>();
        out.place = in_.get<TomlPlace>();
        fits_ = fits_ && in_.ok() && level < kMostLevels && ++values_ <= kMostTomlValues && out.kind <= Kind::kOther;
        if (!fits_) return out;
        switch (out.kind) {
            case Kind::kTable:
                in_.get_each([&] { out.keys.push_back(in_.text()); });
                in_.get_all(out.key_places);
                fits_ = std::is_sorted(out.keys.begin(), out.keys.end());
                [[fallthrough]];
            case Kind::kArray:
                for (auto left = in_.get<std::uint64_t>(); left > 0 && fits_; --left)
                    out.entries.push_back(node(level + 1));
                if (out.kind == Kind::kTable)
                    fits_ = fits_ && out.keys.size() == out.entries.size() && out.keys.size() == out.key_places.size();
                break;
            case Kind::kString:
                out.text = in_.text();
                break;
            case Kind::kFloat:
                out.real = in_.get<double>();
                break;
            default:
                out.integer = in_.get<std::int64_t>();
        }
        return out;
    }

    bake::ByteReader in_;
    bool fits_ = true;
    std::size_t values_ = 0;
};

}  // namespace

std::string encode_toml(const TomlNode& root) {
    bake::ByteWriter out;
    put(out, root);
    return out.take();
}

std::optional<TomlNode> decode_toml(std::string_view bytes) {
    return Decoder(bytes).root();
}

TomlNode read_toml_apart(const fs::path& file, const TomlParser& parse) {
    bake::ForkServer server(
        {.work = [&](std::string_view path) { work(parse, path); }, .prepare = {}, .seconds = kMostSeconds});
    bake::ApartAnswer answer(server, file.native());
    if (const std::optional<std::string> bytes = answer.head(kMostAnswerBytes))
        if (std::optional<TomlNode> root = decode_toml(*bytes)) return std::move(*root);
    throw model::Error(codes::kSceneInvalid, answer.failure("the TOML parser", kMostSeconds), file.string());
}

}  // namespace dgm::scene
