// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/hdf5_apart.cpp
#include "process/hdf5_apart.h"

#include <fmt/format.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include <array>

#include "model/codes.h"
#include "process/attribute_stream.h"
#include "process/sandbox.h"
#include "process/worker_io.h"

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
    limit_worker_memory(kMostMemory, 1);
    static_cast<void>(enter_sandbox({.readable = {path}, .writable = {}}));
    Hdf5Part part;
    try {
        part = formats::read_hdf5_part(path, limits);
    } catch (const model::Error& error) {
        part.findings.push_back({&error.code(), formats::Severity::kError, error.what(), error.place(), {}, {}});
    }
    if (send_message(encode_hdf5_part(part))) _exit(0);
}

/// All that arrives until the end of it, or nullopt if that is too much.
std::optional<std::string> read_all(ForkServer::Reply& from) {
    std::string bytes;
    std::array<char, 65536> buffer;
    while (const std::size_t n = from.read(buffer.data(), buffer.size())) {
        if (bytes.size() + n > kMostBytes) return std::nullopt;
        bytes.append(buffer.data(), n);
    }
    return bytes;
}

Hdf5Part unreadable(std::string message) {
    Hdf5Part part;
    part.findings.push_back({&codes::kHdf5Unreadable, formats::Severity::kError, std::move(message), "/", {}, {}});
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
    ForkServer::Reply reply = server_.ask(encode({limits, path}));
    const std::optional<std::string> bytes = read_all(reply);
    const ChildEnd end = reply.end();
    if (bytes && bytes->starts_with(kOutOfMemoryLine)) return unreadable("HDF5 needs more than 2 GiB to read it");
    if (end.signal == SIGALRM || end.signal == SIGXCPU)
        return unreadable(fmt::format("HDF5 has not read it after {} seconds", kMostSeconds));
    if (end.signal != 0)
        return unreadable(fmt::format("HDF5 crashes on it: signal {} ({})", end.signal, strsignal(end.signal)));
    if (bytes && end.exit_code == 0)
        if (auto part = decode_hdf5_part(*bytes)) return std::move(*part);
    return unreadable("HDF5 sends nothing of use about it");
}

}  // namespace dgm::bake
