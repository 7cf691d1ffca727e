// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/exr_apart.cpp
#include "process/exr_apart.h"

#include <utility>

#include "model/codes.h"
#include "process/apart_answer.h"
#include "process/map_stream.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using formats::ExrHead;
using formats::ExrPicture;
using formats::ExrPixels;
using formats::ExrPlane;
using formats::ExrReadLimits;

constexpr char kExr = 'X', kPlaneList = 'P', kEnd = '.';
constexpr unsigned kMostSeconds = 600;
/// Names, attributes and a report, but no layers.
constexpr std::uint64_t kMostHeadBytes = std::uint64_t{1} << 30;
/// Beside the layers: a block of rows for each, packed and unpacked.
constexpr std::uint64_t kMemoryBeside = std::uint64_t{2} << 30;

enum class Task : std::uint8_t { kMap, kHead, kPlanes, kPicture, kDescription };

struct Request {
    Task task = Task::kMap;
    ExrReadLimits limits;
    fs::path path;
    std::vector<model::Chart> charts;  ///< of kPlanes, without bytes
};

std::string encode(Task task, const ExrReadLimits& limits, const fs::path& path,
                   const std::vector<model::Chart>& charts = {}) {
    ByteWriter out;
    out.put(task);
    out.put(limits);
    out.put(path.native());
    put_charts(out, charts);
    return out.take();
}

Request decode(std::string_view bytes) {
    ByteReader in(bytes);
    Request out;
    out.task = in.get<Task>();
    out.limits = in.get<ExrReadLimits>();
    out.path = in.text();
    if (std::optional<ChartHeads> heads = get_charts(in)) out.charts = std::move(heads->charts);
    return out;
}

bool send_map(const ExrHead& exr) {
    bool is_sent = send_head(encode_exr(exr));
    for (const model::Chart& chart : exr.maps.charts)
        for (const model::Layer& layer : chart.layers) is_sent = is_sent && send_array(layer.bytes);
    return is_sent;
}

bool send_planes(const std::vector<ExrPlane>& planes) {
    bool is_sent = send_head(encode_planes(planes));
    for (const ExrPlane& plane : planes) is_sent = is_sent && send_array(plane.values);
    return is_sent;
}

bool send_picture(const ExrPicture& picture) {
    ByteWriter head;
    head.put(picture.width);
    head.put(picture.height);
    head.put(picture.channels);
    head.put(static_cast<char>(picture.is_half));
    return send_head(head.take()) && send_array(picture.pixels);
}

bool answer(const formats::ExrPlaneReader& planes, const Request& request) {
    switch (request.task) {
        case Task::kPlanes:
            return send_planes(planes.planes(request.path, request.charts, request.limits));
        case Task::kPicture:
            return send_picture(planes.picture(request.path, request.limits));
        case Task::kDescription:
            return send_head(planes.has_description(request.path) ? "1" : "0");
        default:
            return send_map(formats::read_exr_here(request.path, request.limits,
                                                   request.task == Task::kMap ? ExrPixels::kRead : ExrPixels::kSkip));
    }
}

/// In the disposable process.
void work(const formats::ExrPlaneReader& planes, std::string_view bytes) {
    const Request request = decode(bytes);
    const fs::path folder = request.path.has_parent_path() ? request.path.parent_path() : fs::path(".");
    answer_in_sandbox({.readable = {request.path, folder}, .writable = {}, .cpu_seconds = kMostSeconds},
                      request.limits.max_total_bytes + kMemoryBeside, [&] { return answer(planes, request); });
}

/// Each of these gives nullopt for what is no answer.
std::optional<ExrHead> receive_map(ApartAnswer& from, const ExrReadLimits& limits) {
    const std::optional<std::string> head = from.head(kMostHeadBytes);
    std::vector<std::uint64_t> sizes;
    std::optional<ExrHead> out = head ? decode_exr(*head, limits, sizes) : std::nullopt;
    if (!out) return out;
    auto size = sizes.begin();
    for (model::Chart& chart : out->maps.charts)
        for (model::Layer& layer : chart.layers)
            if (!from.array(layer.bytes, *size++)) return std::nullopt;
    return out;
}

std::optional<std::vector<ExrPlane>> receive_planes(ApartAnswer& from, const std::vector<model::Chart>& charts,
                                                    const ExrReadLimits& limits) {
    const std::optional<std::string> head = from.head(kMostHeadBytes);
    std::vector<std::uint64_t> counts;
    auto out = head ? decode_planes(*head, charts, limits, counts) : std::nullopt;
    if (!out) return out;
    auto count = counts.begin();
    for (ExrPlane& plane : *out)
        if (!from.array(plane.values, *count++)) return std::nullopt;
    return out;
}

std::optional<ExrPicture> receive_picture(ApartAnswer& from, const ExrReadLimits& limits) {
    const std::optional<std::string> head = from.head(kMostHeadBytes);
    if (!head) return std::nullopt;
    ByteReader in(*head);
    ExrPicture out;
    out.width = in.get<std::uint32_t>();
    out.height = in.get<std::uint32_t>();
    out.channels = in.get<std::uint32_t>();
    out.is_half = in.get<char>() != 0;
    const std::uint64_t pixels = std::uint64_t{out.width} * out.height, most = limits.max_total_bytes / sizeof(float);
    if (!in.at_end() || pixels == 0 || out.channels == 0 || out.channels > 4 || pixels > most / out.channels ||
        !from.array(out.pixels, pixels * out.channels))
        return std::nullopt;
    return out;
}

/// @throws model::Error the one that was sent; kExrUnreadable for no answer
template <class Receive>
auto ask(ForkServer& server, const std::string& request, const fs::path& path, const Receive& receive) {
    ApartAnswer from(server, request);
    if (auto out = receive(from)) return std::move(*out);
    throw model::Error(codes::kExrUnreadable, from.failure("OpenEXR", kMostSeconds), path.string());
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
    put_charts(out, maps.charts);
    out.put(static_cast<char>(exr.multipart));
    out.put_each(exr.beside, [&](const std::string& name) { out.put(name); });
    out.put(kEnd);
    return out.take();
}

std::optional<ExrHead> decode_exr(std::string_view bytes, const ExrReadLimits& limits,
                                  std::vector<std::uint64_t>& sizes) {
    ByteReader in(bytes);
    if (in.get<char>() != kExr) return std::nullopt;
    ExrHead out;
    model::MapSet& maps = out.maps;
    maps.format_version = in.get<std::uint32_t>();
    for (std::string* text : {&maps.generator, &maps.source_name, &maps.report_json}) *text = in.text();
    maps.source_hash = in.get<decltype(maps.source_hash)>();
    maps.settings_hash = in.get<decltype(maps.settings_hash)>();
    std::optional<ChartHeads> heads = get_charts(in);
    out.multipart = in.get<char>() != 0;
    in.get_each([&] { out.beside.push_back(in.text()); });
    if (in.get<char>() != kEnd || !in.at_end() || !heads || heads->total > limits.max_total_bytes) return std::nullopt;
    maps.charts = std::move(heads->charts);
    sizes = std::move(heads->sizes);
    return out;
}

std::string encode_planes(const std::vector<ExrPlane>& planes) {
    ByteWriter out;
    out.put(kPlaneList);
    out.put_each(planes, [&](const ExrPlane& plane) {
        out.put(std::uint64_t{plane.chart});
        out.put(std::uint64_t{plane.layer});
        out.put(plane.component);
        out.put(plane.meaning);
        out.put(static_cast<char>(plane.is_half));
        out.put(plane.file.native());
        out.put(std::uint64_t{plane.values.size()});
    });
    out.put(kEnd);
    return out.take();
}

std::optional<std::vector<ExrPlane>> decode_planes(std::string_view bytes, const std::vector<model::Chart>& charts,
                                                   const ExrReadLimits& limits, std::vector<std::uint64_t>& counts) {
    ByteReader in(bytes);
    if (in.get<char>() != kPlaneList) return std::nullopt;
    std::vector<ExrPlane> out;
    bool fits = true;
    std::uint64_t left = limits.max_total_bytes / sizeof(float);
    in.get_each([&] {
        ExrPlane& plane = out.emplace_back();
        plane.chart = in.get<std::uint64_t>();
        plane.layer = in.get<std::uint64_t>();
        plane.component = in.get<std::uint32_t>();
        plane.meaning = in.get<ExrPlane::Meaning>();
        plane.is_half = in.get<char>() != 0;
        plane.file = in.text();
        const auto count = in.get<std::uint64_t>();
        counts.push_back(count);
        fits = fits && plane.meaning >= ExrPlane::Meaning::kValue && plane.meaning <= ExrPlane::Meaning::kHigh16 &&
               plane.chart < charts.size() && plane.layer < charts[plane.chart].layers.size() && count > 0 &&
               count <= left;
        if (!fits) return;
        left -= count;
        const std::uint64_t elements = elements_of(charts[plane.chart].layers[plane.layer]).value_or(0);
        fits = elements % count == 0 && plane.component < elements / count;
    });
    if (in.get<char>() != kEnd || !in.at_end() || !fits) return std::nullopt;
    return out;
}

ExrApart::ExrApart(const formats::ExrPlaneReader& planes)
    : server_(
          {.work = [&](std::string_view request) { work(planes, request); }, .prepare = {}, .seconds = kMostSeconds}) {
    formats::set_exr_reader([this](const fs::path& path, const ExrReadLimits& limits, ExrPixels pixels) {
        return ask(server_, encode(pixels == ExrPixels::kRead ? Task::kMap : Task::kHead, limits, path), path,
                   [&](ApartAnswer& from) { return receive_map(from, limits); });
    });
    formats::set_exr_plane_reader(
        {.planes =
             [this](const fs::path& path, const std::vector<model::Chart>& charts, const ExrReadLimits& limits) {
                 return ask(server_, encode(Task::kPlanes, limits, path, charts), path,
                            [&](ApartAnswer& from) { return receive_planes(from, charts, limits); });
             },
         .picture =
             [this](const fs::path& path, const ExrReadLimits& limits) {
                 return ask(server_, encode(Task::kPicture, limits, path), path,
                            [&](ApartAnswer& from) { return receive_picture(from, limits); });
             },
         .has_description =
             [this](const fs::path& path) {
                 return ask(server_, encode(Task::kDescription, {}, path), path,
                            [](ApartAnswer& from) { return from.head(kMostHeadBytes); }) == "1";
             }});
}

ExrApart::~ExrApart() {
    formats::set_exr_reader({});
    formats::set_exr_plane_reader({});
}

}  // namespace dgm::bake
