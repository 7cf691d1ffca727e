// SPDX-License-Identifier: GPL-3.0-or-later
// tests/e2e/faulty_import.cpp
// MESH SECONDS: import_apart around a reader that fails in the way the mesh's file name asks for. Says "N faces" or the
// error's code.
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "model/codes.h"
#include "process/mesh_import.h"

namespace {

using dgm::formats::ImportedMesh;

[[noreturn]] void sleep_for_ever() {
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

ImportedMesh import(const std::filesystem::path& path, const dgm::formats::MeshReadLimits& limits) {
    const std::string fault = path.stem().string();
    if (fault == "segfault") std::raise(SIGSEGV);
    if (fault == "abort") std::abort();
    if (fault == "killed") std::raise(SIGKILL);
    if (fault == "hang") sleep_for_ever();
    if (fault == "hang-deaf") {
        for (int fd = 0; fd < 16; ++fd) close(fd);
        sleep_for_ever();
    }
    if (fault == "quit") std::_Exit(0);
    if (fault == "quit-5") std::_Exit(5);
    if (fault == "throw") throw std::runtime_error("vector::_M_range_check");
    if (fault == "memory") {
        std::vector<std::unique_ptr<char[]>> eaten;
        while (eaten.size() < 256) eaten.push_back(std::make_unique<char[]>(std::size_t{16} << 20));
        std::_Exit(3);  // a limit that does not hold must fail the test, not the machine
    }
    if (fault == "babble")
        for (int k = 0; k < 64; ++k) {
            const std::vector<char> junk(1 << 20, 'M');
            if (write(3, junk.data(), junk.size()) < 0) std::_Exit(0);
        }
    if (fault == "chatty")
        for (int k = 0; k < 100000; ++k) std::puts("a library says something on stdout");
    ImportedMesh mesh = dgm::formats::read_mesh(path, limits);
    if (fault == "stray") mesh.mesh.materials.resize(1), mesh.mesh.materials[0].diffuse_map.path = "/etc/passwd";
    if (fault == "lie") mesh.mesh.faces[0][0] = 1000000;
    return mesh;
}

}  // namespace

int main(int argc, char** argv) {
    if (const auto exit_code = dgm::bake::import_worker(argc, argv, import)) return *exit_code;
    if (argc != 3) return 1;
    try {
        const ImportedMesh mesh =
            dgm::bake::import_apart(argv[1], {.seconds = std::atof(argv[2]), .memory_bytes = 512u << 20});
        // As bytes again, it is what reading it here gives.
        if (dgm::bake::encode_import(mesh) != dgm::bake::encode_import(dgm::formats::read_mesh(argv[1]))) return 7;
        std::printf("%zu faces\n", mesh.mesh.faces.size());
        return 0;
    } catch (const dgm::model::Error& error) {
        std::printf("%s %s @%s\n", error.code().id().c_str(), error.what(), error.place().c_str());
        return static_cast<int>(error.code().exit);
    }
}
