// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_obj.cpp
// The OBJ reader, and repair on what it makes of the bytes. Promises: faces name vertices that exist, corner arrays fit
// the faces; repair leaves finite manifold pieces or refuses; nothing but model::Error is thrown.
#include <cmath>

#include "bytes_file.h"
#include "geometry/repair/repair.h"
#include "mesh/obj_reader.h"
#include "model/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm;
    const test::BytesFile file(data, size);
    formats::MeshReadLimits limits;
    limits.max_file_bytes = 1 << 16;
    limits.max_faces = 1 << 12;
    limits.max_vertices = 1 << 12;
    try {
        const formats::ImportedMesh imported = formats::read_obj(file.path(), limits);
        const model::TriMesh& mesh = imported.mesh;
        test::require(!mesh.faces.empty());
        for (const model::Face& face : mesh.faces)
            for (const std::uint32_t v : face) test::require(v < mesh.positions.size());
        const std::size_t corners = 3 * mesh.faces.size();
        for (const std::size_t count : {mesh.corner_uvs.size(), mesh.corner_normals.size(), mesh.corner_colours.size()})
            test::require(count == 0 || count == corners);
        for (const model::TriMesh& component : bake::repair(imported.mesh).components)
            for (const model::Vec3d& p : component.positions)
                test::require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    } catch (const model::Error&) {
        // A refusal.
    }
    return 0;
}
