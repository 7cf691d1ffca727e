// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/validation_test.cpp
// One good file, broken in one way at a time: each way has its code and no other.
#include "validate/validation.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "dgm/dgm_writer.h"
#include "dgm/hash.h"
#include "geometry/metrics/reconstruction.h"
#include "mesh/mesh_writer.h"
#include "model/codes.h"
#include "support/temp_folder.h"
#include "validate/source_checks.h"
#include "validation_maps.h"

namespace dgm::validate {
namespace {
namespace codes = model::codes;
namespace fs = std::filesystem;
using model::Chart;
using model::ElementType;
using model::MapSet;
using test::poke;

/// "DGM2004 /charts/0/geometry", in order; warnings in brackets.
std::vector<std::string> summary(const FileValidation& validation) {
    std::vector<std::string> out;
    for (const formats::Finding& f : validation.findings) {
        const std::string line = f.code->id() + " " + f.place;
        out.push_back(f.severity == formats::Severity::kError ? line : "[" + line + "]");
    }
    return out;
}

struct Breakage {
    const char* name;
    std::function<void(MapSet&)> change;
    std::vector<std::string> want;
};
void PrintTo(const Breakage& b, std::ostream* out) {
    *out << b.name;
}

template <class T>
std::function<void(MapSet&)> set(std::size_t chart, const char* layer, std::size_t index, T value) {
    return [=](MapSet& maps) { poke<T>(*maps.charts[chart].find(layer), index, value); };
}
std::function<void(MapSet&)> drop(std::size_t chart, const std::string& layer) {
    return [=](MapSet& maps) {
        std::erase_if(maps.charts[chart].layers, [&](const model::Layer& l) { return l.name == layer; });
    };
}
std::function<void(MapSet&)> replace_in_report(const std::string& old_text, const std::string& new_text) {
    return [=](MapSet& maps) {
        const std::size_t at = maps.report_json.find(old_text);
        ASSERT_NE(at, std::string::npos);
        maps.report_json.replace(at, old_text.size(), new_text);
    };
}

const float kNan = std::numeric_limits<float>::quiet_NaN();
const float kInf = std::numeric_limits<float>::infinity();
constexpr std::size_t n = test::kTubeCols;

// Sample (5, 3) of the tube is in the middle of tile 0; (4, 0) and (4, 10) are mates.
const std::vector<Breakage> kValueBreakages{
    {"nan_geometry", set<float>(0, "geometry", 3 * (5 * n + 3) + 2, kNan), {"DGM2003 /charts/0/geometry[5][3][2]"}},
    {"infinite_cover", set<float>(0, "cover", 7, kInf), {"DGM2003 /charts/0/cover[0][7]"}},
    {"nan_bump", set<std::uint16_t>(0, "bump", 2, 0x7e01), {"DGM2003 /charts/0/bump[1][0]"}},
    {"nan_stiffness", set<float>(0, "deformation", 4 * 12 + 3, kNan), {"DGM2003 /charts/0/deformation[1][1][3]"}},
    {"nan_box", set<float>(0, "collision", 9, kNan), {"DGM2003 /charts/0/collision[1][3]"}},
    {"nan_contact", set<float>(0, "contact", 3, kNan), {"DGM2003 /charts/0/contact[0][1][1]"}},
    {"mask_two", set<std::uint8_t>(1, "mask", 4, 2), {"DGM2007 /charts/1/mask[1][1]"}},
    {"diagonal_seven", set<std::uint8_t>(0, "diagonals", 13, 7), {"DGM2007 /charts/0/diagonals[1][3]"}},
    {"negative_e", set<float>(0, "deformation", 0, -1e-3f), {"DGM2007 /charts/0/deformation[0][0][0]"}},
    {"negative_g", set<float>(0, "deformation", 4 * n + 2, -1.f), {"DGM2007 /charts/0/deformation[1][0][2]"}},
    {"not_a_metric", set<float>(0, "deformation", 4 * n + 1, 1.f), {"DGM2007 /charts/0/deformation[1][0][0]"}},
    {"negative_stiffness", set<float>(0, "deformation", 7, -0.5f), {"DGM2007 /charts/0/deformation[0][1][3]"}},
    {"stiffness_above_one", set<float>(0, "deformation", 7, 1.5f), {"DGM2007 /charts/0/deformation[0][1][3]"}},
    {"huge_e", set<float>(0, "deformation", 0, 2e30f), {"DGM2007 /charts/0/deformation[0][0][0]"}},
    {"far_sample", set<float>(0, "geometry", 3 * (5 * n + 3) + 1, -2e18f), {"DGM2007 /charts/0/geometry[5][3][1]"}},
    {"far_border_sample", set<float>(1, "border_geometry", 0, 2e18f), {"DGM2007 /charts/1/border_geometry[0][0]"}},
    {"mobility_above_one", set<float>(0, "contact", 1, 1.5f), {"DGM2007 /charts/0/contact[0][0][1]"}},
    {"unit_zero",
     set<float>(0, "material", 0, 0.f),
     {"DGM2007 /charts/0/material[0]", "DGM1013 /charts/0/geometry@metres_per_unit"}},
    {"unit_of_attribute", set<float>(0, "material", 0, 1e-2f), {"DGM1013 /charts/0/geometry@metres_per_unit"}},
    {"poisson_beyond", set<float>(0, "material", 2, 0.5f), {"DGM2007 /charts/0/material[2]"}},
    {"no_density", set<float>(0, "material", 5, 0.f), {"DGM2007 /charts/0/material[5]"}},
    {"nan_viscosity", set<float>(0, "material", 6, kNan), {"DGM2003 /charts/0/material[6]"}},
    {"no_material", drop(0, "material"), {"DGM1013 /charts/0/geometry@metres_per_unit"}},
    {"no_unit_attribute",
     [](MapSet& m) { m.charts[0].find("geometry")->attributes.erase("metres_per_unit"); },
     {"DGM1013 /charts/0/geometry@metres_per_unit"}},
    {"half_a_material",
     [](MapSet& m) {
         model::Layer& layer = *m.charts[0].find("material");
         layer.shape = {3};
         layer.bytes.resize(12);
     },
     {"DGM2002 /charts/0/material"}},
    {"border_uv_outside", set<float>(1, "border_uv", 1, 1.25f), {"DGM2007 /charts/1/border_uv[0][1]"}},
    {"torn_seam", set<float>(0, "geometry", 3 * (4 * n + 10), 0.4999f), {"DGM2004 /charts/0/geometry"}},
    // One unit in the last place is a gap as well; the boxes allow for it.
    {"torn_by_one_bit",
     set<float>(0, "geometry", 3 * (4 * n + 10), std::nextafter(0.5f, 0.f)),
     {"DGM2004 /charts/0/geometry"}},
    {"seam_out_of_range", set<std::uint32_t>(0, "seams", 3, 132), {"DGM2005 /charts/0/seams"}},
    {"seam_not_lowest", set<std::uint32_t>(0, "seams", 2, 22), {"DGM2005 /charts/0/seams"}},
    {"seam_copy_twice", set<std::uint32_t>(0, "seams", 3, 10), {"DGM2005 /charts/0/seams"}},
    {"no_seams", drop(0, "seams"), {"DGM2006 /report charts[0].boundary_loops"}},
    {"strip_face_out_of_range", set<std::uint32_t>(1, "border_faces", 5, 10), {"DGM2007 /charts/1/border_faces"}},
    // One surface point twice: no manifold, and no area.
    {"strip_face_degenerate",
     set<std::uint32_t>(1, "border_faces", 5, 9),
     {"DGM2006 /charts/1/geometry", "[DGM2006 /charts/1/geometry]"}},
    {"strip_face_off_surface", set<std::uint32_t>(1, "border_faces", 5, 8), {"DGM2007 /charts/1/border_faces[1][2]"}},
    {"seam_off_surface",
     [](MapSet& m) {
         m.charts[1].layers.push_back(test::make_layer<std::uint32_t>("seams", ElementType::kU32, {1, 2}, {8, 9}));
         poke<float>(*m.charts[1].find("geometry"), 3 * 8, 1.75f);
         poke<float>(*m.charts[1].find("geometry"), 3 * 8 + 1, 1.5f);
     },
     {"DGM2005 /charts/1/seams[0][0]"}},
    {"flat_face",
     [](MapSet& m) {
         set<float>(1, "border_geometry", 0, 1.5f)(m);  // onto the edge from (1, 1) to (2, 1)
         set<float>(1, "border_geometry", 1, 1.0f)(m);
     },
     {"[DGM2006 /charts/1/geometry]"}},
    {"strip_face_turned",
     [](MapSet& m) {
         set<std::uint32_t>(1, "border_faces", 4, 5)(m);
         set<std::uint32_t>(1, "border_faces", 5, 9)(m);
     },
     {"DGM2006 /charts/1/geometry", "[DGM2013 /charts/1/border_faces[1]]"}},
    {"box_too_small", set<float>(0, "collision", 6 * 2 + 5, 0.5f), {"DGM2008 /charts/0/collision[2]"}},
    {"root_too_small", set<float>(0, "collision", 6 * 4, -0.25f), {"DGM2008 /charts/0/collision[4]"}},
    {"wrong_levels",
     [](MapSet& m) {
         m.charts[0].find("collision")->attributes["levels"] = std::vector<std::uint32_t>{4, 1, 1, 1};
     },
     {"DGM2002 /charts/0/collision"}},
    {"no_levels",
     [](MapSet& m) { m.charts[0].find("collision")->attributes.clear(); },
     {"DGM2002 /charts/0/collision"}},
    {"cover_too_small", set<float>(0, "cover", 5 * n + 3, 0.3f), {"DGM2008 /charts/0/cover[5][3]"}},
    {"contact_areas", set<float>(0, "contact", 2 * (5 * n + 3), 0.1f), {"DGM2009 /charts/0/contact"}},
    {"bbox_too_small", [](MapSet& m) { m.charts[0].bbox[5] = 1.9; }, {"DGM2010 /charts/0"}},
    {"bbox_too_large", [](MapSet& m) { m.charts[1].bbox[0] = -0.1; }, {"DGM2010 /charts/1"}},
    {"report_genus", replace_in_report(R"("genus":0)", R"("genus":1)"), {"DGM2006 /report charts[0].genus"}},
    {"report_method",
     replace_in_report(R"("method":"lscm")", R"("method":"arap")"),
     {"DGM2011 /report charts[1].method"}},
    {"report_rows", replace_in_report(R"("rows":3)", R"("rows":4)"), {"DGM2011 /report charts[1].rows"}},
    {"report_charts", replace_in_report(R"("charts")", R"("karts")"), {"DGM2011 /report charts"}},
    {"report_garbage", [](MapSet& m) { m.report_json = "{\"charts\":["; }, {"DGM2011 /report"}},
    {"report_types", replace_in_report(R"("rms":0.001)", R"("rms":[{}])"), {}},
    {"report_nested",
     [](MapSet& m) { m.report_json.insert(1, "\"x\":" + std::string(200'000, '[') + std::string(200'000, ']') + ","); },
     {"DGM2011 /report"}},
    {"report_rms_above_hausdorff",
     replace_in_report(R"("rms":0.001)", R"("rms":0.003)"),
     {"DGM2011 /report error.rms"}},
    {"report_percent",
     replace_in_report(R"("rms":0.001)", R"("rms_percent":0.5,"rms":0.001)"),
     {"DGM2011 /report error.rms_percent"}},
    {"report_utilisation",
     replace_in_report(R"("rows":3)", R"("utilisation":1,"rows":3)"),
     {"DGM2011 /report charts[1].utilisation"}},
    {"report_seam_pairs",
     replace_in_report(R"("rows":12)", R"("seam_pairs":11,"rows":12)"),
     {"DGM2011 /report charts[0].seam_pairs"}},
    {"report_stretch",
     replace_in_report(R"("rows":12)", R"("map":{"stretch_l2":0.5},"rows":12)"),
     {"DGM2011 /report charts[0].map.stretch_l2"}},
    {"report_source_topology",
     replace_in_report(R"("rows":12)", R"("source_topology":{"genus":1},"rows":12)"),
     {"DGM4005 /report charts[0].source_topology.genus"}},
    {"report_folder",
     replace_in_report(R"("rows":12)", R"("note":"see /home/me/x.png","rows":12)"),
     {"[DGM1015 /report charts[0].note]"}},
    {"no_report", [](MapSet& m) { m.report_json.clear(); }, {"[DGM2011 /report]"}},
    {"seam_normals",
     set<std::int16_t>(0, "normal", 2 * (4 * n + 10), std::int16_t{32000}),
     {"[DGM2004 /charts/0/normal]"}},
    {"no_mask", drop(1, "mask"), {"DGM2001 /charts/1/mask"}},
    {"no_strip", drop(1, "border_faces"), {"DGM2001 /charts/1/border_faces"}},
    {"unknown_optional_layer",
     [](MapSet& m) {
         m.charts[0].layers.push_back(test::make_layer<std::uint8_t>("moss", ElementType::kU8, {3}, {1, 2, 3}));
     },
     {}},
};

class ValidationOfFile : public testing::TestWithParam<Breakage> {};
TEST_P(ValidationOfFile, FindsExactlyThis) {
    MapSet maps = test::good_maps();
    GetParam().change(maps);
    const test::TempFolder folder;
    formats::write_dgm(maps, folder / "x.dgm");
    const FileValidation validation = validate_file(folder / "x.dgm");
    EXPECT_EQ(summary(validation), GetParam().want);
    const bool fails = !GetParam().want.empty() && GetParam().want[0][0] != '[';
    EXPECT_EQ(validation.exit_code(), fails ? model::ExitCode::kInvalid : model::ExitCode::kOk);
}
const auto breakage_name = [](const auto& info) { return std::string(info.param.name); };
INSTANTIATE_TEST_SUITE_P(Values, ValidationOfFile, testing::ValuesIn(kValueBreakages), breakage_name);

/// Changes maps in memory to shapes that the writer would refuse.
std::function<void(MapSet&)> reshape(std::size_t chart, const char* layer, std::vector<std::uint64_t> shape) {
    return [=](MapSet& maps) { maps.charts[chart].find(layer)->shape = shape; };
}
const std::vector<Breakage> kShapeBreakages{
    {"no_geometry", drop(0, "geometry"), {"DGM2001 /charts/0/geometry"}},
    {"transposed", reshape(0, "geometry", {11, 12, 3}), {"DGM2002 /charts/0/geometry"}},
    {"rank", reshape(0, "cover", {132}), {"DGM2002 /charts/0/cover"}},
    {"overflow", reshape(0, "texture", {std::uint64_t{1} << 62, 4, 4}), {"DGM2002 /charts/0/texture"}},
    {"empty_texture", reshape(0, "texture", {0, 3, 4}), {"DGM2002 /charts/0/texture"}},
    {"short", [](MapSet& m) { m.charts[0].find("normal")->bytes.pop_back(); }, {"DGM2002 /charts/0/normal"}},
    {"type", [](MapSet& m) { m.charts[0].find("contact")->type = ElementType::kU32; }, {"DGM2002 /charts/0/contact"}},
    {"strip_in_square",
     [](MapSet& m) { m.charts[0].layers.push_back(*m.charts[1].find("border_faces")); },
     {"DGM2002 /charts/0/border_faces"}},
    {"no_grid", [](MapSet& m) { m.charts[1].rows = 1; }, {"DGM2002 /charts/1", "DGM2011 /report charts[1].rows"}},
    {"unknown_required_layer",
     [](MapSet& m) {
         m.charts[0].layers.push_back(test::make_layer<std::uint8_t>("moss", ElementType::kU8, {3}, {1, 2, 3}));
         m.charts[0].layers.back().required = true;
     },
     {"DGM1012 /charts/0/moss"}},
    {"no_charts",
     [](MapSet& m) {
         m.charts.clear();
         m.report_json = R"({"charts":[]})";
     },
     {"DGM2001 /charts"}},
};
class ValidationOfMaps : public testing::TestWithParam<Breakage> {};
TEST_P(ValidationOfMaps, FindsExactlyThis) {
    MapSet maps = test::good_maps();
    GetParam().change(maps);
    EXPECT_EQ(summary(validate_maps(maps)), GetParam().want);
}
INSTANTIATE_TEST_SUITE_P(Shapes, ValidationOfMaps, testing::ValuesIn(kShapeBreakages), breakage_name);

TEST(Validation, AGoodFileHasNoFindings) {
    const test::TempFolder folder;
    formats::write_dgm(test::good_maps(), folder / "good.dgm");
    const FileValidation validation = validate_file(folder / "good.dgm");
    EXPECT_EQ(summary(validation), std::vector<std::string>{});
    EXPECT_EQ(validation.charts, 2u);
    EXPECT_FALSE(validation.error.has_value());
}

TEST(Validation, QuantisedGeometryIsMeasuredInItsUnits) {
    // The free chart again as u16 with a step of 1/1024: same surface, same findings (none).
    MapSet maps = test::good_maps();
    Chart& chart = maps.charts[1];
    std::vector<std::uint16_t> steps;
    for (std::uint16_t i = 0; i < 3; ++i)
        for (std::uint16_t j = 0; j < 3; ++j)
            steps.insert(steps.end(), {static_cast<std::uint16_t>(1024 * i), static_cast<std::uint16_t>(1024 * j), 0});
    *chart.find("geometry") = test::make_layer<std::uint16_t>("geometry", ElementType::kU16, {3, 3, 3}, steps);
    chart.scale = {1.0 / 1024, 1.0 / 1024, 1};
    EXPECT_EQ(summary(validate_maps(maps)), std::vector<std::string>{});
    chart.scale[1] = 1.0 / 2048;
    EXPECT_EQ(summary(validate_maps(maps)), std::vector<std::string>{"DGM2010 /charts/1"});
}

TEST(Validation, DamagedBytesAreTheContainersFindingAlone) {
    const test::TempFolder folder;
    const fs::path file = folder / "x.dgm";
    MapSet maps = test::good_maps();
    formats::write_dgm(maps, file);
    // The texture is the one place that holds this byte six times and more in a row.
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    const std::size_t at = bytes.find(std::string(24, static_cast<char>(200)));
    ASSERT_NE(at, std::string::npos);
    stream.clear();
    stream.seekp(static_cast<std::streamoff>(at + 5));
    stream.put(static_cast<char>(201));
    stream.close();
    const FileValidation validation = validate_file(file);
    ASSERT_EQ(validation.findings.size(), 1u);
    EXPECT_EQ(validation.findings[0].code, &codes::kHashMismatch);
    EXPECT_NE(validation.findings[0].place.find("/charts/0/texture"), std::string::npos);
    EXPECT_EQ(validation.exit_code(), model::ExitCode::kInvalid);
}

TEST(Validation, MissingAndForeignFiles) {
    const test::TempFolder folder;
    FileValidation validation = validate_file(folder / "absent.dgm");
    ASSERT_EQ(validation.findings.size(), 1u);
    EXPECT_EQ(validation.findings[0].code, &codes::kFileMissing);
    EXPECT_EQ(validation.exit_code(), model::ExitCode::kIo);

    std::ofstream(folder / "text.dgm") << "o hello\nv 0 0 0\n";
    validation = validate_file(folder / "text.dgm");
    ASSERT_EQ(validation.findings.size(), 1u);
    EXPECT_EQ(validation.findings[0].code, &codes::kNotDgm);
    EXPECT_EQ(validation.exit_code(), model::ExitCode::kInvalid);
}

/// The reconstruction of both charts, moved by `shift` along z and written as OBJ: its distance is known.
Source shifted_source(const test::TempFolder& folder, const MapSet& maps, double shift) {
    model::TriMesh mesh;
    for (const Chart& chart : maps.charts) {
        const bake::Reconstruction r = bake::reconstruct(chart);
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (model::Vec3d p : r.mesh.positions) mesh.positions.push_back(p + model::Vec3d{0, 0, shift});
        for (const model::Face& f : r.mesh.faces) mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    }
    formats::write_obj(folder / "source.obj", mesh);
    return load_source(folder / "source.obj");
}

TEST(Validation, ComparesWithTheSource) {
    const test::TempFolder folder;
    MapSet maps = test::good_maps();
    const Source same = shifted_source(folder, maps, 0);
    maps.source_hash = same.hash;
    Options options;
    options.sampling.samples = 20'000;
    options.source = &same;
    FileValidation validation = validate_maps(maps, options);
    EXPECT_EQ(summary(validation), std::vector<std::string>{});
    ASSERT_TRUE(validation.error.has_value());
    EXPECT_LT(validation.error->rms, 1e-9);
    EXPECT_EQ(validation.turned_faces, 0u);

    // Another file: a warning. The flat chart is 0.1 away everywhere, the tube only at its rims.
    const Source moved = shifted_source(folder, maps, 0.1);
    options.source = &moved;
    const std::string other = "[DGM4003 /]", rms = "DGM4001 /charts", hausdorff = "DGM4002 /charts";
    validation = validate_maps(maps, options);
    EXPECT_EQ(summary(validation), (std::vector{other, rms, hausdorff}));
    ASSERT_TRUE(validation.error.has_value());
    EXPECT_NEAR(validation.error->hausdorff, 0.1, 1e-9);
    EXPECT_NE(validation.findings.back().message.find("of the diagonal), near ("), std::string::npos);
    const double diagonal = validation.error->diagonal;
    // 0.1 over the flat chart (3 quads, triangles of 1/4 and 3/8), 0..0.1 over a band of height 0.1 of the tube, 0
    // below.
    const double around = 20 * test::kTubeRadius * std::sin(std::numbers::pi / 10), flat = 3.625;
    const double mean_square = (0.01 * flat + 0.1 * around * 0.01 / 3) / (flat + around * test::kTubeLength);
    EXPECT_NEAR(validation.error->rms, std::sqrt(mean_square), 1e-5);
    EXPECT_EQ(validation.exit_code(), model::ExitCode::kInvalid);

    // Limits of the caller's, in percent of the diagonal.
    options.max_rms_percent = options.max_hausdorff_percent = 0.101 / diagonal * 100;
    EXPECT_EQ(summary(validate_maps(maps, options)), (std::vector{other}));
    options.max_hausdorff_percent = 0.099 / diagonal * 100;
    EXPECT_EQ(summary(validate_maps(maps, options)), (std::vector{other, hausdorff}));
    options.max_hausdorff_percent = 1;
    options.max_rms_percent = 0;
    EXPECT_EQ(summary(validate_maps(maps, options)), (std::vector{other, rms}));
}

/// Validates maps as if they had been baked from `mesh`.
FileValidation against(model::TriMesh mesh, MapSet& maps, const test::TempFolder& folder) {
    mesh.corner_normals.clear();
    mesh.corner_uvs.clear();
    formats::write_obj(folder / "source.obj", mesh);
    const Source source = load_source(folder / "source.obj");
    maps.source_hash = source.hash;
    maps.report_json.clear();
    Options options;
    options.sampling.samples = 1000;
    options.source = &source;
    return validate_maps(maps, options);
}

TEST(Validation, WarnsOfFacesTurnedAgainstTheSource) {
    const test::TempFolder folder;
    MapSet maps = test::good_maps();
    maps.charts.resize(1);
    const bake::Reconstruction tube = bake::reconstruct(maps.charts[0]);
    model::TriMesh inside_out = tube.mesh;
    for (model::Face& f : inside_out.faces) std::swap(f[1], f[2]);
    const FileValidation validation = against(inside_out, maps, folder);
    EXPECT_EQ(validation.turned_faces, tube.mesh.faces.size());
    ASSERT_FALSE(validation.findings.empty());
    const formats::Finding& last = validation.findings.back();
    EXPECT_EQ(last.code, &codes::kTurnedFaces);
    EXPECT_EQ(last.severity, formats::Severity::kWarning);
    EXPECT_EQ(last.measured, static_cast<double>(tube.mesh.faces.size()));
    EXPECT_EQ(validation.exit_code(), model::ExitCode::kOk);
}

TEST(Validation, NamesThePlaceOfAFaceTurnedAgainstTheSource) {
    const test::TempFolder folder;
    MapSet maps = test::good_maps();
    ASSERT_EQ(maps.charts.size(), 2u);
    const bake::Reconstruction first = bake::reconstruct(maps.charts[0]), second = bake::reconstruct(maps.charts[1]);
    model::TriMesh source_mesh;
    append_mesh(source_mesh, first.mesh);
    append_mesh(source_mesh, second.mesh);
    // The second chart as it is seen from its back: in the file the first of its faces is wrong.
    for (std::size_t f = first.mesh.faces.size(); f < source_mesh.faces.size(); ++f)
        std::swap(source_mesh.faces[f][1], source_mesh.faces[f][2]);
    const FileValidation validation = against(source_mesh, maps, folder);
    EXPECT_EQ(validation.turned_faces, second.mesh.faces.size());
    const formats::Finding& last = validation.findings.back();
    EXPECT_NE(last.message.find("the first in chart 1 at row 0, column 0, near ("), std::string::npos) << last.message;
}

TEST(Validation, WorseFollowsTheBatchRule) {
    using enum model::ExitCode;
    EXPECT_EQ(worse(kOk, kUnsupported), kUnsupported);
    EXPECT_EQ(worse(kUnsupported, kInvalid), kInvalid);
    EXPECT_EQ(worse(kIo, kInvalid), kIo);
    EXPECT_EQ(worse(kIo, kInternal), kInternal);
    EXPECT_EQ(worse(kInterrupted, kInternal), kInterrupted);
    EXPECT_EQ(worse(kTransient, kInternal), kTransient);
    EXPECT_EQ(worse(kTransient, kInterrupted), kInterrupted);
}

}  // namespace
}  // namespace dgm::validate
