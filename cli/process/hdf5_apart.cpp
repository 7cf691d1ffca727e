// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/hdf5_apart.cpp
#include "process/hdf5_apart.h"

#include <optional>
#include <utility>

#include "model/codes.h"
#include "process/apart_answer.h"
#include "process/attribute_stream.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;
using formats::Hdf5Part;

constexpr char kPart = 'H', kEnd = '.';
/// A report of 256 MiB, attributes of 64 KiB for thousands of layers, and more.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;
constexpr std::uint64_t kMostMemory = std::uint64_t{2} << 30;
constexpr unsigned kMostSeconds = 120;

struct Request {
    formats::DgmReadLimits limits;
    std::filesystem::path path;
};

std::string encode(const Request& request) {
    ByteWriter out;
    out.put(request.limits);
    out.put(request.path.native());
    return out.take();
}

/// In the disposable process: reads the file, sends what it holds, and ends.
void work(std::string_view bytes) {
    ByteReader in(bytes);
    const auto limits = in.get<formats::DgmReadLimits>();
    const std::filesystem::path path = in.text();
    answer_in_sandbox({.readable = {path}, .writable = {}}, kMostMemory,
                      [&] { return send_head(encode_hdf5_part(formats::read_hdf5_part(path, limits))); });
}

Hdf5Part with_finding(const model::Code& code, std::string message, std::string place) {
    Hdf5Part part;
    part.findings.push_back({&code, formats::Severity::kError, std::move(message), std::move(place), {}, {}});
    return part;
}

}  // namespace

std::string encode_hdf5_part(const Hdf5Part& part) {
    ByteWriter out;
    out.put(kPart);
    out.put_each(part.findings, [&](const formats::Finding& f) {
        out.put(std::int32_t{f.code->number});
        out.put(f.message);
        out.put(f.place);
        for (const auto& figure : {f.measured, f.limit}) {
            out.put(static_cast<char>(figure.has_value()));
            out.put(figure.value_or(0));
        }
    });
    for (const std::string* text : {&part.generator, &part.source_name, &part.report_json}) out.put(*text);
    out.put_each(part.attributes, [&](const Attributes& layer) { put_attributes(out, layer); });
    out.put(kEnd);
    return out.take();
}

std::optional<Hdf5Part> decode_hdf5_part(std::string_view bytes) {
    ByteReader in(bytes);
    if (in.get<char>() != kPart) return std::nullopt;
    Hdf5Part part;
    bool known = true;
    in.get_each([&] {
        formats::Finding& f = part.findings.emplace_back();
        f.code = code_of(in.get<std::int32_t>());
        known = known && f.code != nullptr;
        f.message = in.text();
        f.place = in.text();
        for (auto* figure : {&f.measured, &f.limit}) {
            const bool is_there = in.get<char>() != 0;
            const auto value = in.get<double>();
            if (is_there) *figure = value;
        }
    });
    for (std::string* text : {&part.generator, &part.source_name, &part.report_json}) *text = in.text();
    in.get_each([&] { part.attributes.push_back(get_attributes(in)); });
    if (in.get<char>() != kEnd || !in.at_end() || !known) return std::nullopt;
    return part;
}

Hdf5Apart::Hdf5Apart() : server_({.work = work, .prepare = formats::prepare_hdf5, .seconds = kMostSeconds}) {
    formats::set_hdf5_reader([this](const auto& path, const auto& limits) { return read(path, limits); });
}

Hdf5Apart::~Hdf5Apart() {
    formats::set_hdf5_reader({});
}

Hdf5Part Hdf5Apart::read(const std::filesystem::path& path, const formats::DgmReadLimits& limits) {
    const std::scoped_lock lock(one_file_);
    ApartAnswer answer(server_, encode({limits, path}));
    try {
        if (const std::optional<std::string> bytes = answer.head(kMostBytes))
            if (auto part = decode_hdf5_part(*bytes)) return std::move(*part);
    } catch (const model::Error& error) { return with_finding(error.code(), error.what(), error.place()); }
    return with_finding(codes::kHdf5Unreadable, answer.failure("HDF5", kMostSeconds), "/");
}

}  // namespace dgm::bake
