// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/exr_apart.cpp
#include "process/exr_apart.h"

#include <fmt/format.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <new>

#include "model/codes.h"
#include "process/attribute_stream.h"
#include "process/sandbox.h"
#include "process/worker_io.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using formats::ExrHead;
using formats::ExrPixels;
using formats::ExrReadLimits;

constexpr char kExr = 'X', kError = 'E', kEnd = '.';
constexpr unsigned kMostSeconds = 600;
/// Names, attributes and a report, but no layers.
constexpr std::uint64_t kMostHeadBytes = std::uint64_t{1} << 30;
/// Beside the layers: a block of rows for each, packed and unpacked.
constexpr std::uint64_t kMemoryBeside = std::uint64_t{2} << 30;

struct Request {
    ExrReadLimits limits;
    ExrPixels pixels = ExrPixels::kRead;
    fs::path path;
};

std::string encode(const Request& request) {
    ByteWriter out;
    out.put(request.limits);
    out.put(request.pixels);
    out.put(request.path.native());
    return out.take();
}

Request decode(std::string_view bytes) {
    ByteReader in(bytes);
    Request out;
    out.limits = in.get<ExrReadLimits>();
    out.pixels = in.get<ExrPixels>();
    out.path = in.text();
    return out;
}

/// The length of `head`, then itself.
bool send_head(const std::string& head) {
    ByteWriter length;
    length.put(std::uint64_t{head.size()});
    return send_message(length.take()) && send_message(head);
}

bool send_layers(const model::MapSet& maps) {
    for (const model::Chart& chart : maps.charts)
        for (const model::Layer& layer : chart.layers)
            if (!send_message({reinterpret_cast<const char*>(layer.bytes.data()), layer.bytes.size()})) return false;
    return true;
}

/// In the disposable process.
void work(std::string_view bytes) {
    const Request request = decode(bytes);
    const fs::path folder = request.path.has_parent_path() ? request.path.parent_path() : fs::path(".");
    limit_worker_memory(request.limits.max_total_bytes + kMemoryBeside, 1);
    static_cast<void>(enter_sandbox({.readable = {request.path, folder}, .writable = {}, .cpu_seconds = kMostSeconds}));
    bool sent = false;
    try {
        const ExrHead exr = formats::read_exr_here(request.path, request.limits, request.pixels);
        sent = send_head(encode_exr(exr)) && send_layers(exr.maps);
    } catch (const model::Error& error) { sent = send_head(encode_exr(error)); }
    if (sent) _exit(0);
}

/// Exactly `size` bytes. False if there are fewer.
bool read_whole(ForkServer::Reply& reply, char* into, std::size_t size) {
    while (size > 0) {
        const std::size_t n = reply.read(into, size);
        if (n == 0) return false;
        into += n;
        size -= n;
    }
    return true;
}

/// Memory grows with what comes, whatever was announced.
template <class Bytes>
bool read_growing(ForkServer::Reply& reply, Bytes& into, std::uint64_t size) {
    constexpr std::uint64_t kStep = std::uint64_t{64} << 20;
    into.reserve(std::min(size, kStep));
    while (into.size() < size) {
        const std::size_t old = into.size(), step = static_cast<std::size_t>(std::min(kStep, size - old));
        into.resize(old + step);
        if (!read_whole(reply, reinterpret_cast<char*>(into.data()) + old, step)) return false;
    }
    return true;
}

/// nullopt if what came is no answer; then `said` has the first of it.
std::optional<ExrHead> receive(ForkServer::Reply& reply, const Request& request, std::string& said) {
    std::uint64_t length = 0;
    said.resize(sizeof length);
    if (!read_whole(reply, said.data(), said.size())) return std::nullopt;
    std::memcpy(&length, said.data(), sizeof length);
    std::string head;
    if (length > kMostHeadBytes || !read_growing(reply, head, length)) return std::nullopt;
    std::vector<std::uint64_t> sizes;
    std::optional<ExrHead> out = decode_exr(head, request.limits, sizes);
    if (!out) return out;
    auto size = sizes.begin();
    for (model::Chart& chart : out->maps.charts)
        for (model::Layer& layer : chart.layers)
            if (!read_growing(reply, layer.bytes, *size++)) return std::nullopt;
    return out;
}

void put_layer(ByteWriter& out, const model::Layer& layer) {
    out.put(layer.name);
    out.put(layer.type);
    out.put_all(layer.shape);
    put_attributes(out, layer.attributes);
    out.put(static_cast<char>(layer.required));
    out.put(std::uint64_t{layer.bytes.size()});
}

/// @return its size in bytes; nullopt if that does not follow from its shape
std::optional<std::uint64_t> get_layer(ByteReader& in, model::Layer& layer) {
    layer.name = in.text();
    layer.type = in.get<model::ElementType>();
    in.get_all(layer.shape);
    layer.attributes = get_attributes(in);
    layer.required = in.get<char>() != 0;
    const auto bytes = in.get<std::uint64_t>();
    std::uint64_t right = layout::element_size(layer.type);
    if (right == 0 || layer.shape.empty() || layer.shape.size() > 4) return std::nullopt;
    for (const std::uint64_t extent : layer.shape)
        if (__builtin_mul_overflow(right, extent, &right)) return std::nullopt;
    if (bytes != 0 && bytes != right) return std::nullopt;  // none for pixels that were skipped
    return bytes;
}

}  // namespace

std::string encode_exr(const ExrHead& exr) {
    const model::MapSet& maps = exr.maps;
    ByteWriter out;
    out.put(kExr);
    out.put(maps.format_version);
    for (const std::string* text : {&maps.generator, &maps.source_name, &maps.report_json}) out.put(*text);
    out.put(maps.source_hash);
    out.put(maps.settings_hash);
    out.put_each(maps.charts, [&](const model::Chart& chart) {
        out.put(chart.rows);
        out.put(chart.cols);
        out.put(chart.domain);
        out.put(chart.method);
        out.put(chart.bbox);
        out.put(chart.offset);
        out.put(chart.scale);
        out.put_each(chart.layers, [&](const model::Layer& layer) { put_layer(out, layer); });
    });
    out.put(static_cast<char>(exr.multipart));
    out.put_each(exr.beside, [&](const std::string& name) { out.put(name); });
    out.put(kEnd);
    return out.take();
}

std::string encode_exr(const model::Error& error) {
    ByteWriter out;
    out.put(kError);
    out.put(std::int32_t{error.code().number});
    out.put(std::string(error.what()));
    out.put(error.place());
    out.put(std::string(error.hint()));
    return out.take();
}

std::optional<ExrHead> decode_exr(std::string_view bytes, const ExrReadLimits& limits,
                                  std::vector<std::uint64_t>& sizes) {
    ByteReader in(bytes);
    const char kind = in.get<char>();
    if (kind == kError) {
        const model::Code* code = code_of(in.get<std::int32_t>());
        std::string message = in.text(), place = in.text();
        throw model::Error(code != nullptr ? *code : codes::kInternal, std::move(message), std::move(place))
            .with_hint(in.text());
    }
    if (kind != kExr) return std::nullopt;
    ExrHead out;
    model::MapSet& maps = out.maps;
    maps.format_version = in.get<std::uint32_t>();
    for (std::string* text : {&maps.generator, &maps.source_name, &maps.report_json}) *text = in.text();
    maps.source_hash = in.get<decltype(maps.source_hash)>();
    maps.settings_hash = in.get<decltype(maps.settings_hash)>();
    bool fits = true;
    std::uint64_t total = 0;
    in.get_each([&] {
        model::Chart& chart = maps.charts.emplace_back();
        chart.rows = in.get<std::uint32_t>();
        chart.cols = in.get<std::uint32_t>();
        chart.domain = in.get<model::Domain>();
        fits = fits && (chart.domain == model::Domain::kSquare || chart.domain == model::Domain::kFree);
        chart.method = in.text();
        chart.bbox = in.get<decltype(chart.bbox)>();
        chart.offset = in.get<decltype(chart.offset)>();
        chart.scale = in.get<decltype(chart.scale)>();
        in.get_each([&] {
            const std::optional<std::uint64_t> size = get_layer(in, chart.layers.emplace_back());
            fits = fits && size && !__builtin_add_overflow(total, *size, &total);
            sizes.push_back(size.value_or(0));
        });
    });
    out.multipart = in.get<char>() != 0;
    in.get_each([&] { out.beside.push_back(in.text()); });
    if (in.get<char>() != kEnd || !in.at_end() || !fits || total > limits.max_total_bytes) return std::nullopt;
    return out;
}

ExrApart::ExrApart() : server_({.work = work, .prepare = {}, .seconds = kMostSeconds}) {
    formats::set_exr_reader(
        [this](const auto& path, const auto& limits, ExrPixels pixels) { return read(path, limits, pixels); });
}

ExrApart::~ExrApart() {
    formats::set_exr_reader({});
}

ExrHead ExrApart::read(const fs::path& path, const ExrReadLimits& limits, ExrPixels pixels) {
    const Request request{limits, pixels, path};
    ForkServer::Reply reply = server_.ask(encode(request));
    std::string said;
    std::optional<ExrHead> out = receive(reply, request, said);
    const ChildEnd end = reply.end();
    if (out) return std::move(*out);
    const auto unreadable = [&](const std::string& why) {
        return model::Error(codes::kExrUnreadable, why, path.string());
    };
    if (!said.empty() && kOutOfMemoryLine.starts_with(said)) throw unreadable("OpenEXR needs too much memory for it");
    if (end.signal == SIGALRM || end.signal == SIGXCPU)
        throw unreadable(fmt::format("OpenEXR has not read it after {} seconds", kMostSeconds));
    if (end.signal != 0)
        throw unreadable(fmt::format("OpenEXR crashes on it: signal {} ({})", end.signal, strsignal(end.signal)));
    throw unreadable("OpenEXR sends nothing of use about it");
}

}  // namespace dgm::bake
