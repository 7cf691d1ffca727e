// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/make_validation_fixtures.cpp
// make_validation_fixtures FOLDER: for each code that dgm-validate gives, a file with just that fault, DGM1003_x.dgm.
// A mesh beside it, DGM4001_x.obj, is its source. tests/e2e/test_codes.py runs them and compares with a golden report.
#include <hdf5.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "dgm/dgm_writer.h"
#include "dgm/hash.h"
#include "exr/exr_writer.h"
#include "geometry/metrics/reconstruction.h"
#include "mesh/mesh_writer.h"
#include "raw_dgm.h"
#include "validation_maps.h"

namespace {
namespace fs = std::filesystem;
using dgm::model::ElementType;
using dgm::model::MapSet;
using dgm::test::poke;
using dgm::test::RawDgm;

fs::path folder;

std::string read_bytes(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}
void write_bytes(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
}
std::string good_bytes() {
    static const std::string bytes = [] {
        dgm::formats::write_dgm(dgm::test::good_maps(), folder / "scratch");
        std::string out = read_bytes(folder / "scratch");
        fs::remove(folder / "scratch");
        return out;
    }();
    return bytes;
}

void maps_fixture(const std::string& name, const std::function<void(MapSet&)>& change) {
    MapSet maps = dgm::test::good_maps();
    change(maps);
    dgm::formats::write_dgm(maps, folder / name);
}
void raw_fixture(const std::string& name, const std::function<void(RawDgm&)>& change) {
    RawDgm raw(good_bytes());
    change(raw);
    write_bytes(name, raw.bytes());
}

void check(herr_t status) {
    if (status < 0) std::abort();
}
/// A file that HDF5 has changed, with an index that follows as far as it can.
void hdf5_fixture(const std::string& name, const std::function<void(hid_t)>& change) {
    write_bytes(name, good_bytes());
    const hid_t file = H5Fopen((folder / name).c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    change(file);
    check(H5Fclose(file));
    write_bytes(name, RawDgm(read_bytes(folder / name)).bytes(false));
}

void replace_in_report(MapSet& maps, const std::string& old_text, const std::string& new_text) {
    const std::size_t at = maps.report_json.find(old_text);
    if (at == std::string::npos) std::abort();
    maps.report_json.replace(at, old_text.size(), new_text);
}

dgm::model::TriMesh surface_of(const MapSet& maps) {
    dgm::model::TriMesh mesh;
    for (const auto& chart : maps.charts) {
        const auto surface = dgm::bake::reconstruct(chart, dgm::bake::Corners::kSkip);
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), surface.mesh.positions.begin(), surface.mesh.positions.end());
        for (const auto& f : surface.welded_faces) mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    }
    return mesh;
}
/// The good file beside a source that is the changed reconstruction.
void source_fixture(const std::string& name, bool same_hash, const std::function<void(dgm::model::TriMesh&)>& change) {
    MapSet maps = dgm::test::good_maps();
    dgm::model::TriMesh mesh = surface_of(maps);
    change(mesh);
    dgm::formats::write_obj(folder / (name + ".obj"), mesh);
    if (same_hash) maps.source_hash = dgm::formats::hash_file(folder / (name + ".obj"));
    dgm::formats::write_dgm(maps, folder / (name + ".dgm"));
}

void make_container_fixtures() {
    write_bytes("DGM1001_text.dgm", "o hello\nv 0 0 0\n");
    write_bytes("DGM1001_empty.dgm", "");
    raw_fixture("DGM1002_newer.dgm", [](RawDgm& raw) { raw.header.format_version = 2; });
    std::string bytes = good_bytes();
    bytes[RawDgm(bytes).layer("texture").offset + 5] ^= 1;
    write_bytes("DGM1003_texture.dgm", bytes);
    bytes = good_bytes();
    bytes[5000] ^= 4;
    write_bytes("DGM1003_hdf5.dgm", bytes);
    bytes = good_bytes();
    bytes[200] ^= 4;
    write_bytes("DGM1003_index.dgm", bytes);
    write_bytes("DGM1004_half.dgm", good_bytes().substr(0, good_bytes().size() / 2));
    write_bytes("DGM1004_user_block.dgm", good_bytes().substr(0, 100));
    raw_fixture("DGM1005_rank.dgm", [](RawDgm& raw) { raw.layer("normal").rank = 7; });
    raw_fixture("DGM1005_huge.dgm", [](RawDgm& raw) { raw.layer("normal").shape[0] = std::uint64_t{1} << 62; });
    bytes = good_bytes();
    bytes[4000] = 1;
    write_bytes("DGM1005_stray.dgm", bytes);
    RawDgm no_signature(good_bytes());
    bytes = no_signature.bytes(false);
    bytes[4097] = 'x';
    write_bytes("DGM1006_superblock.dgm", bytes);
    raw_fixture("DGM1008_overlap.dgm", [](RawDgm& raw) { raw.layer("normal").offset = raw.layer("geometry").offset; });
    raw_fixture("DGM1009_odd.dgm", [](RawDgm& raw) { raw.layer("normal").offset += 4; });
    hdf5_fixture("DGM1010_external_link.dgm", [](hid_t file) {
        check(H5Ldelete(file, "/charts/0/bump", H5P_DEFAULT));
        check(H5Lcreate_external("/etc/passwd", "/bump", file, "/charts/0/bump", H5P_DEFAULT, H5P_DEFAULT));
    });
    hdf5_fixture("DGM1011_rows.dgm", [](hid_t file) {
        const std::uint32_t rows = 13;
        const hid_t group = H5Gopen2(file, "/charts/0", H5P_DEFAULT);
        const hid_t attribute = H5Aopen(group, "rows", H5P_DEFAULT);
        check(H5Awrite(attribute, H5T_NATIVE_UINT32, &rows));
        check(H5Aclose(attribute));
        check(H5Gclose(group));
    });
    MapSet maps = dgm::test::good_maps();
    maps.charts[0].layers.push_back(dgm::test::make_layer<std::uint8_t>("moss", ElementType::kU8, {3}, {1, 2, 3}));
    maps.charts[0].layers.back().required = true;
    dgm::formats::write_dgm(maps, folder / "DGM1012_moss.dgm");
    hdf5_fixture("DGM1013_no_method.dgm", [](hid_t file) {
        const hid_t group = H5Gopen2(file, "/charts/1", H5P_DEFAULT);
        check(H5Adelete(group, "method"));
        check(H5Gclose(group));
    });
    hdf5_fixture("DGM1014_notes.dgm", [](hid_t file) {
        const hid_t creation = H5Pcreate(H5P_GROUP_CREATE);
        check(H5Pset_obj_track_times(creation, 0));
        check(H5Gclose(H5Gcreate2(file, "/charts/notes", H5P_DEFAULT, creation, H5P_DEFAULT)));
        check(H5Pclose(creation));
    });
    maps_fixture("DGM1015_folder.dgm", [](MapSet& m) { m.source_name = "/home/me/tube.obj"; });
    maps_fixture("DGM1015_times.dgm",
                 [](MapSet& m) { replace_in_report(m, R"("rms":0.001)", R"("cpu_seconds":1.5,"rms":0.001)"); });
}

void make_exr_fixtures() {
    const std::vector<fs::path> files = dgm::formats::write_exr(dgm::test::good_maps(), folder / "scratch.exr");
    const std::string good = read_bytes(files.back());
    for (const char* name : {"DGM1016_cover", "DGM1003_header"})  // their textures are as they were
        for (std::size_t k = 0; k + 1 < files.size(); ++k)
            fs::copy_file(files[k], folder / (name + files[k].filename().string().substr(7)));
    for (const fs::path& file : files) fs::remove(file);
    write_bytes("DGM1007_half.exr", good.substr(0, good.size() / 2));
    // The channel's name in the header, then its pixel type FLOAT.
    std::string bytes = good;
    const std::string channel("cover.V\0\2", 9);
    const std::size_t at = bytes.find(channel);
    if (at == std::string::npos) std::abort();
    bytes[at + 4] = 's';
    write_bytes("DGM1016_cover.exr", bytes);
    bytes = good;
    bytes[bytes.find("tube.obj")] = 'T';
    write_bytes("DGM1003_header.exr", bytes);
}

void make_layer_fixtures() {
    constexpr std::size_t n = dgm::test::kTubeCols;
    const auto layer = [](MapSet& m, std::size_t chart, const char* name) -> dgm::model::Layer& {
        return *m.charts[chart].find(name);
    };
    maps_fixture("DGM2001_no_mask.dgm",
                 [](MapSet& m) { std::erase_if(m.charts[1].layers, [](const auto& l) { return l.name == "mask"; }); });
    maps_fixture("DGM2002_levels.dgm", [&](MapSet& m) { layer(m, 0, "collision").attributes.clear(); });
    maps_fixture("DGM2003_nan.dgm", [&](MapSet& m) {
        poke<float>(layer(m, 0, "geometry"), 3 * (5 * n + 3) + 2, std::numeric_limits<float>::quiet_NaN());
    });
    maps_fixture("DGM2004_torn.dgm",
                 [&](MapSet& m) { poke<float>(layer(m, 0, "geometry"), 3 * (4 * n + 10), 0.4999f); });
    maps_fixture("DGM2005_range.dgm", [&](MapSet& m) { poke<std::uint32_t>(layer(m, 0, "seams"), 3, 132); });
    maps_fixture("DGM2005_inside.dgm", [&](MapSet& m) {
        auto& seams = layer(m, 0, "seams");
        poke<std::uint32_t>(seams, 0, n + 1);
        poke<std::uint32_t>(seams, 1, n + 2);
        for (unsigned k = 0; k < 3; ++k) {
            float value = 0;
            std::memcpy(&value, layer(m, 0, "geometry").bytes.data() + 4 * (3 * (n + 1) + k), 4);
            poke<float>(layer(m, 0, "geometry"), 3 * (n + 2) + k, value);
        }
    });
    maps_fixture("DGM2006_turned.dgm", [&](MapSet& m) {
        poke<std::uint32_t>(layer(m, 1, "border_faces"), 4, 5);
        poke<std::uint32_t>(layer(m, 1, "border_faces"), 5, 9);
    });
    maps_fixture("DGM2007_mask.dgm", [&](MapSet& m) { poke<std::uint8_t>(layer(m, 1, "mask"), 4, 2); });
    maps_fixture("DGM2008_box.dgm", [&](MapSet& m) { poke<float>(layer(m, 0, "collision"), 6 * 2 + 5, 0.5f); });
    maps_fixture("DGM2008_cover.dgm", [&](MapSet& m) { poke<float>(layer(m, 0, "cover"), 5 * n + 3, 0.3f); });
    maps_fixture("DGM2009_areas.dgm", [&](MapSet& m) { poke<float>(layer(m, 0, "contact"), 2 * (5 * n + 3), 0.1f); });
    maps_fixture("DGM2010_bbox.dgm", [](MapSet& m) { m.charts[0].bbox[5] = 1.9; });
    maps_fixture("DGM2011_method.dgm",
                 [](MapSet& m) { replace_in_report(m, R"("method":"lscm")", R"("method":"arap")"); });
    maps_fixture("DGM2012_metric.dgm", [&](MapSet& m) {
        // Still a metric, but of steps one and a half times as long.
        auto& deformation = layer(m, 0, "deformation");
        float value = 0;
        std::memcpy(&value, deformation.bytes.data() + 4 * 4 * (5 * n + 3), 4);
        poke<float>(deformation, 4 * (5 * n + 3), 2.25f * value);
    });
    maps_fixture("DGM2013_strip.dgm", [&](MapSet& m) {
        // The border sample beyond the diagonal: its faces turn over in (u, v), not in space.
        poke<float>(layer(m, 1, "border_uv"), 0, 0.25f);
        poke<float>(layer(m, 1, "border_uv"), 1, 0.25f);
    });
    maps_fixture("DGM2013_report.dgm",
                 [](MapSet& m) { replace_in_report(m, R"("rows":12)", R"("map":{"flips":2},"rows":12)"); });
    maps_fixture("DGM2014_unused.dgm", [&](MapSet& m) {
        layer(m, 1, "border_uv") =
            dgm::test::make_layer<float>("border_uv", ElementType::kF32, {2, 2}, {0.875f, 0.75f, 0.9f, 0.9f});
        layer(m, 1, "border_geometry") = dgm::test::make_layer<float>("border_geometry", ElementType::kF32, {2, 3},
                                                                      {1.75f, 1.5f, 0.f, 1.8f, 1.8f, 0.f});
    });
    maps_fixture("DGM2015_code.dgm",
                 [&](MapSet& m) { poke<std::int16_t>(layer(m, 0, "normal"), 2 * (5 * n + 3), std::int16_t{-32768}); });
    maps_fixture("DGM2015_inwards.dgm", [&](MapSet& m) {
        auto& normal = layer(m, 0, "normal");
        for (std::size_t k = 0; k < normal.bytes.size() / 2; ++k) {
            std::int16_t value = 0;
            std::memcpy(&value, normal.bytes.data() + 2 * k, 2);
            poke<std::int16_t>(normal, k, static_cast<std::int16_t>(-value));
        }
    });
    maps_fixture("DGM2016_reversed.dgm", [&](MapSet& m) {  // the surface has two sides
        const std::uint64_t pairs = layer(m, 0, "seams").shape[0];
        std::vector<std::uint8_t> reversed(pairs, 0);
        reversed[3] = 1;
        m.charts[0].layers.push_back(
            dgm::test::make_layer<std::uint8_t>("reversed", ElementType::kU8, {pairs}, reversed));
    });
}

void make_source_fixtures() {
    const auto shift = [](dgm::model::TriMesh& mesh) {
        for (auto& p : mesh.positions) p.z += 0.1;
    };
    source_fixture("DGM4001_shifted", true, shift);
    source_fixture("DGM4002_spike", true, [](dgm::model::TriMesh& mesh) { mesh.positions[5 * 11 + 3].y += 0.2; });
    source_fixture("DGM4003_other", false, [](dgm::model::TriMesh&) {});
    source_fixture("DGM4004_inside_out", true, [](dgm::model::TriMesh& mesh) {
        for (auto& f : mesh.faces) std::swap(f[1], f[2]);
    });
    source_fixture("DGM4005_extra_piece", true, [](dgm::model::TriMesh& mesh) {
        // A patch that lies in a quad of the flat chart: no distance, but one piece more.
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const auto& [x, y] : {std::pair{0.2, 0.2}, {0.4, 0.2}, {0.2, 0.3}}) mesh.positions.push_back({x, y, 0});
        mesh.faces.push_back({first, first + 1, first + 2});
    });
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
        return 1;
    }
    folder = argv[1];
    dgm::formats::write_dgm(dgm::test::good_maps(), folder / "good.dgm");
    dgm::formats::write_exr(dgm::test::good_maps(), folder / "good.exr");
    make_container_fixtures();
    make_exr_fixtures();
    make_layer_fixtures();
    make_source_fixtures();
    return 0;
}
