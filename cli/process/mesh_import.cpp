// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/mesh_import.cpp
#include "process/mesh_import.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <new>
#include <thread>
#include <vector>

#include "mesh/asset_folders.h"
#include "model/codes.h"
#include "model/shortage.h"
#include "process/byte_stream.h"
#include "process/child_process.h"
#include "process/error_stream.h"
#include "process/sandbox.h"
#include "process/worker_io.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;
using formats::ImportedMesh;
using Clock = std::chrono::steady_clock;

constexpr char kMesh = 'M', kEnd = '.';
/// More than a mesh within formats::MeshReadLimits takes.
constexpr std::uint64_t kMaxBytes = std::uint64_t{8} << 30;
constexpr std::uint32_t kMostCpuSeconds = 3600;  ///< beside the parent's limit of time
constexpr auto kPause = std::chrono::milliseconds(100);

bool fits_together(const model::TriMesh& mesh) {
    const std::size_t corners = 3 * mesh.faces.size();
    const auto per_corner = [&](std::size_t count) { return count == 0 || count == corners; };
    if (!per_corner(mesh.corner_normals.size()) || !per_corner(mesh.corner_uvs.size()) ||
        !per_corner(mesh.corner_colours.size()) ||
        !(mesh.face_materials.empty() || mesh.face_materials.size() == mesh.faces.size()))
        return false;
    for (const model::Face& face : mesh.faces)
        for (const std::uint32_t v : face)
            if (v >= mesh.positions.size()) return false;
    return std::all_of(mesh.face_materials.begin(), mesh.face_materials.end(),
                       [&](std::uint32_t m) { return m < mesh.materials.size(); });
}

void put_picture(ByteWriter& out, const model::PictureFile& picture) {
    out.put(picture.path.native());
    out.put(static_cast<char>(picture.bytes != nullptr));
    if (picture.bytes) out.put(*picture.bytes);
}

model::PictureFile get_picture(ByteReader& in) {
    model::PictureFile out{.path = in.text()};
    if (in.get<char>() != 0) out.bytes = std::make_shared<const std::string>(in.text());
    return out;
}

/// All that the worker sends until its end.
std::string conversation(ChildProcess& child, const ImportLimits& limits, Clock::time_point deadline) {
    std::string bytes;
    std::array<char, 65536> buffer;
    for (bool open = true; open;) {
        std::array<pollfd, 2> waiting{pollfd{child.messages(), POLLIN, 0}, pollfd{child.errors(), POLLIN, 0}};
        const bool any = poll(waiting.data(), waiting.size(), static_cast<int>(kPause.count())) > 0;
        child.read_errors();
        if (any && waiting[0].revents != 0) {
            const ssize_t n = read(child.messages(), buffer.data(), buffer.size());
            if (n > 0) bytes.append(buffer.data(), static_cast<std::size_t>(n));
            open = n > 0 || (n < 0 && (errno == EINTR || errno == EAGAIN));
        }
        if (bytes.size() > kMaxBytes)
            throw model::Error(codes::kWorkerCrashed, "the worker sent something that is not a mesh");
        if (Clock::now() > deadline)
            throw model::Error(codes::kWorkerTimeout,
                               fmt::format("the import was not done after {} s", limits.seconds));
    }
    return bytes;
}

ChildEnd end_of(ChildProcess& child, Clock::time_point deadline) {
    for (;;) {
        child.read_errors();
        if (const auto end = child.poll_end()) return *end;
        if (Clock::now() > deadline) {
            child.kill();
            throw model::Error(codes::kWorkerTimeout, "the import's process does not end");
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

/// Pictures that the program will open itself: a worker that is not itself any more could name any file.
bool stays_home(const ImportedMesh& mesh, const formats::AssetFolders& folders) {
    const auto is_home = [&](const model::PictureFile& picture) {
        return picture.empty() || picture.bytes != nullptr || folders.hold(picture.path);
    };
    return std::all_of(mesh.mesh.materials.begin(), mesh.mesh.materials.end(), [&](const model::Material& material) {
        return is_home(material.diffuse_map) && is_home(material.bump_map);
    });
}

}  // namespace

std::string encode_import(const ImportedMesh& imported) {
    const model::TriMesh& mesh = imported.mesh;
    ByteWriter out;
    out.put(kMesh);
    out.put_all(mesh.positions);
    out.put_all(mesh.faces);
    out.put_all(mesh.corner_normals);
    out.put_all(mesh.corner_uvs);
    out.put_all(mesh.corner_colours);
    out.put_all(mesh.face_materials);
    out.put_each(mesh.materials, [&](const model::Material& material) {
        out.put(material.name);
        out.put(material.diffuse);
        put_picture(out, material.diffuse_map);
        put_picture(out, material.bump_map);
        out.put(static_cast<char>(material.bump_is_normal_map));
        out.put(material.bump_scale);
    });
    out.put_each(imported.warnings, [&](const std::string& warning) { out.put(warning); });
    out.put_each(imported.remarks, [&](const std::string& remark) { out.put(remark); });
    out.put_each(imported.missing, [&](const std::string& name) { out.put(name); });
    out.put_each(imported.dependencies, [&](const std::filesystem::path& path) { out.put(path.native()); });
    out.put_each(imported.dropped, [&](const auto& dropped) {
        out.put(dropped.first);
        out.put(dropped.second);
    });
    out.put(kEnd);
    return out.take();
}

std::optional<ImportedMesh> decode_import(std::string_view bytes) {
    throw_sent_error(bytes);
    ByteReader in(bytes);
    if (in.get<char>() != kMesh) return std::nullopt;
    ImportedMesh out;
    model::TriMesh& mesh = out.mesh;
    in.get_all(mesh.positions);
    in.get_all(mesh.faces);
    in.get_all(mesh.corner_normals);
    in.get_all(mesh.corner_uvs);
    in.get_all(mesh.corner_colours);
    in.get_all(mesh.face_materials);
    in.get_each([&] {
        model::Material& material = mesh.materials.emplace_back();
        material.name = in.text();
        material.diffuse = in.get<model::Rgba8>();
        material.diffuse_map = get_picture(in);
        material.bump_map = get_picture(in);
        material.bump_is_normal_map = in.get<char>() != 0;
        material.bump_scale = in.get<double>();
    });
    in.get_each([&] { out.warnings.push_back(in.text()); });
    in.get_each([&] { out.remarks.push_back(in.text()); });
    in.get_each([&] { out.missing.push_back(in.text()); });
    in.get_each([&] { out.dependencies.emplace_back(in.text()); });
    in.get_each([&] {
        std::string what = in.text();
        out.dropped.emplace_back(std::move(what), in.get<std::uint64_t>());
    });
    if (in.get<char>() != kEnd || !in.at_end() || !fits_together(mesh)) return std::nullopt;
    return out;
}

ImportedMesh import_apart(const std::filesystem::path& path, const ImportLimits& limits) {
    const auto deadline =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limits.seconds));
    ByteWriter job;
    job.put(limits.memory_bytes);
    job.put(path.native());
    job.put_each(limits.asset_roots, [&](const std::filesystem::path& root) { job.put(root.native()); });
    ChildProcess child(job.take());
    std::string bytes = conversation(child, limits, deadline);
    const ChildEnd end = end_of(child, deadline);
    // Whatever a library made of a failed allocation, the shortage is the cause.
    if (bytes.starts_with(kOutOfMemoryLine))
        throw model::Error(codes::kWorkerMemory,
                           fmt::format("the import needs more than the {} MiB it may take", limits.memory_bytes >> 20),
                           path.string());
    if (end.is_killed())
        throw model::Error(codes::kWorkerKilled, fmt::format("the import's process was ended by signal {}", end.signal),
                           path.string());
    if (end.signal == SIGXCPU)
        throw model::Error(codes::kWorkerTimeout, "the import has used the processor time that it may", path.string());
    if (end.signal != 0)
        throw model::Error(
            codes::kWorkerCrashed,
            fmt::format("the import's process was ended by signal {} ({})", end.signal, strsignal(end.signal)),
            path.string());
    if (end.exit_code == 0)
        if (auto mesh = decode_import(bytes);
            mesh && stays_home(*mesh, formats::AssetFolders(path, limits.asset_roots)))
            return std::move(*mesh);
    throw model::Error(codes::kWorkerCrashed,
                       fmt::format("the import's process ended with exit code {} and no mesh", end.exit_code),
                       path.string());
}

std::optional<int> import_worker(int argc, const char* const* argv, const MeshReader& read) {
    if (!is_worker(argc, argv)) return std::nullopt;
    if (!has_message_descriptor()) return static_cast<int>(model::ExitCode::kUsage);
    std::string answer;
    try {
        const std::string text = read_job_text();
        ByteReader job(text);
        limit_worker_memory(job.get<std::uint64_t>(), 1);
        const std::filesystem::path path = job.text();
        formats::MeshReadLimits limits;
        job.get_each([&] { limits.asset_roots.emplace_back(job.text()); });
        Sandbox sandbox = import_sandbox(path, limits.asset_roots);
        sandbox.cpu_seconds = kMostCpuSeconds;
        static_cast<void>(enter_sandbox(sandbox));
        answer = encode_import(read ? read(path, limits) : formats::read_mesh(path, limits));
    } catch (const model::Error& error) { answer = encode_error(error); } catch (const std::bad_alloc&) {
        return static_cast<int>(model::ExitCode::kInternal);  // reported already
    } catch (const std::exception& error) { answer = encode_error(model::error_of(error)); }
    if (!send_message(answer)) return static_cast<int>(model::ExitCode::kInternal);
    // Destructors of statics in importers have crashed before; there is nothing left to save.
    _exit(static_cast<int>(model::ExitCode::kOk));
}

}  // namespace dgm::bake
