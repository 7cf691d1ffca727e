// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/baking/bake_mesh_test.cpp
// A caller with a mesh in memory, a progress callback and a flag to stop: no file, no process.
#include "baking/bake_mesh.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "baking/attempt.h"
#include "baking/pipeline.h"
#include "baking/stages.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;

/// A bowl of 2 x 13 x 13 triangles over the square of side 2.
model::TriMesh bowl() {
    constexpr std::uint32_t kSide = 14;
    model::TriMesh out;
    for (std::uint32_t i = 0; i < kSide; ++i)
        for (std::uint32_t j = 0; j < kSide; ++j) {
            const double x = 2.0 * i / (kSide - 1) - 1, y = 2.0 * j / (kSide - 1) - 1;
            out.positions.push_back({x, y, 0.5 * (x * x + y * y)});
        }
    for (std::uint32_t i = 0; i + 1 < kSide; ++i)
        for (std::uint32_t j = 0; j + 1 < kSide; ++j) {
            const std::uint32_t a = i * kSide + j, b = a + kSide;
            out.faces.push_back({a, b, b + 1});
            out.faces.push_back({a, b + 1, a + 1});
        }
    return out;
}

BakeOptions small_grid() {
    BakeOptions out;
    out.size = {17, 17};
    return out;
}

/// Writes `mesh` as OBJ, with all digits.
void write(const model::TriMesh& mesh, const std::filesystem::path& path) {
    std::ofstream file(path);
    file.precision(std::numeric_limits<double>::max_digits10);
    for (const model::Vec3d& p : mesh.positions) file << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
    for (const model::Face& f : mesh.faces) file << "f " << f[0] + 1 << ' ' << f[1] + 1 << ' ' << f[2] + 1 << '\n';
}

TEST(BakeMesh, BakesFromMemoryAndReportsItsProgress) {
    std::vector<std::string> stages;
    model::Progress progress;
    progress.on_update = [&](std::string_view stage, double share) {
        EXPECT_GE(share, 0);
        EXPECT_LE(share, 1);
        if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
    };
    const BakeResult result = bake_mesh({bowl(), "bowl"}, small_grid(), progress);
    EXPECT_EQ(result.maps.source_name, "bowl");
    EXPECT_FALSE(result.maps.report_json.empty());
    ASSERT_EQ(result.maps.charts.size(), 1U);
    EXPECT_EQ(result.maps.charts[0].rows, 17U);
    EXPECT_EQ(result.report.source_vertices, 14U * 14U);
    EXPECT_LT(result.report.error.rms, 1e-2 * result.report.error.diagonal);
    std::vector<std::string> order;
    for (const std::string& stage : stages)
        if (stage != "cut" && std::find(order.begin(), order.end(), stage) == order.end()) order.push_back(stage);
    EXPECT_EQ(order, (std::vector<std::string>{"import", "repair", "textures", "map", "fit", "layers", "measure"}));
}

TEST(BakeMesh, GivesTheLayersThatAFileWithTheMeshGives) {
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("dgm-bowl-" + std::to_string(getpid()) + ".obj");
    write(bowl(), path);
    const BakeResult of_file = bake_asset(path, small_grid(), {});
    const model::TriMesh mesh = formats::read_mesh(path).mesh;
    std::filesystem::remove(path);
    const BakeResult of_memory = bake_mesh({mesh, path.filename().string()}, small_grid());
    EXPECT_TRUE(of_memory.maps.charts == of_file.maps.charts);
    EXPECT_EQ(of_memory.maps.settings_hash, of_file.maps.settings_hash);
    EXPECT_EQ(of_memory.report.error.rms, of_file.report.error.rms);
}

TEST(BakeMesh, StopsInTheStageInWhichItIsAskedTo) {
    for (const char* wanted : {"import", "map", "fit", "layers"}) {
        std::atomic<bool> stop{false};
        std::string last;
        model::Progress progress;
        progress.cancelled = &stop;
        progress.on_update = [&](std::string_view stage, double) {
            EXPECT_FALSE(stop) << stage << " after the request";
            last = stage;
            if (stage == wanted) stop = true;
        };
        try {
            (void)bake_mesh({bowl(), "bowl"}, small_grid(), progress);
            ADD_FAILURE() << "nothing thrown in " << wanted;
        } catch (const model::Error& error) { EXPECT_EQ(&error.code(), &codes::kInterrupted); }
        EXPECT_EQ(last, wanted);
    }
}

TEST(BakeMesh, RefusesAMeshWhoseArraysDoNotFitTogether) {
    const auto refuses = [](model::TriMesh mesh) {
        try {
            (void)bake_mesh({std::move(mesh), "bad"}, small_grid());
        } catch (const model::Error& error) {
            return &error.code() == &codes::kImportFailed && error.stage() == "import";
        }
        return false;
    };
    model::TriMesh mesh = bowl();
    mesh.faces.front()[1] = 14 * 14;
    EXPECT_TRUE(refuses(mesh));
    mesh = bowl();
    mesh.corner_uvs.resize(7);
    EXPECT_TRUE(refuses(mesh));
    mesh = bowl();
    mesh.face_materials.assign(mesh.faces.size(), 0);
    EXPECT_TRUE(refuses(mesh));
}

TEST(BakeMesh, SearchesForTheGridThatHoldsAnError) {
    BakeOptions options;
    options.auto_samples = 65 * 65;
    options.max_error = ErrorGoal{0.5, true, ErrorKind::kRms};
    const BakeResult result = bake_mesh({bowl(), "bowl"}, options);
    ASSERT_TRUE(result.report.search);
    EXPECT_EQ(result.report.search->goal, SearchGoal::kMaxError);
    EXPECT_EQ(result.maps.charts.at(0).rows, result.report.search->rows);
    EXPECT_LE(100 * result.report.error.rms / result.report.error.diagonal, 0.5);
    EXPECT_LT(result.report.search->rows, 65U);
}

TEST(BakeMesh, ABudgetNeedsAFileToMeasure) {
    BakeOptions options = small_grid();
    options.budget_bytes = 1 << 20;
    try {
        (void)bake_mesh({bowl(), "bowl"}, options);
        ADD_FAILURE() << "nothing thrown";
    } catch (const model::Error& error) { EXPECT_EQ(&error.code(), &codes::kUsage); }
}

/// A closed body of three limbs: the star does not fit it. 20 x 4^levels faces.
model::TriMesh limbed_body(int levels = 4) {
    model::TriMesh body = test::icosphere(levels);
    for (model::Vec3d& p : body.positions)
        p = p *
            (1 + 2.9 * std::exp(9 * (dot(p, {0.6, 0.8, 0}) - 1)) + 2.5 * std::exp(9 * (dot(p, {-0.8, 0, 0.6}) - 1)) +
             0.4 * std::exp(9 * (dot(p, {0.1, -0.7, -0.7}) - 1)));
    return body;
}

/// Charts along other cuts that are tried on grids of so many samples a side.
std::size_t other_cuts(const model::TriMesh& mesh, std::uint32_t side, Fit fit) {
    BakeOptions options = small_grid();
    options.size = {side, side};
    options.fit = fit;
    const BakeResult result = bake_mesh({mesh, "limbs"}, options);
    std::size_t count = 0;
    for (const ChartReport& chart : result.report.charts)
        count += std::ranges::count_if(chart.candidates, [](const CandidateReport& tried) {
            return tried.outcome.find("along another cut") != std::string::npos;
        });
    return count;
}

TEST(BakeMesh, TheBestFitTriesOtherCutsOfAClosedBody) {
    EXPECT_EQ(other_cuts(limbed_body(), 49, Fit::kL2), 0U);
    EXPECT_GT(other_cuts(limbed_body(), 49, Fit::kBest), 0U);
}

TEST(BakeMesh, SmallGridsTryAPredictedCutBesideAMeasuredOne) {
    EXPECT_EQ(other_cuts(limbed_body(3), 33, Fit::kL2), 1U);
    EXPECT_EQ(other_cuts(limbed_body(5), 33, Fit::kL2), 0U) << "to measure trials takes long there: predicted alone";
    model::TriMesh many = limbed_body(2);
    for (int k = 1; k < 5; ++k) many = test::joined(std::move(many), limbed_body(2), 8.0 * k);
    EXPECT_EQ(other_cuts(many, 17, Fit::kL2), 0U) << "one of many components is searched once";
}

/// Elsewhere a corner of the square lies amid a loop, and its cell has two sides on one line: cloth that hangs from
/// there knots.
TEST(BakeMesh, RingsWithAUnitHaveTheirLoopsOnOppositeSides) {
    const auto is_unrolled = [](BakeOptions options) {
        const BakeResult result = bake_mesh({test::tube(20, 18, 10, 32, 12), "skirt"}, options);
        const auto& candidates = result.report.charts.at(0).candidates;
        return std::ranges::any_of(candidates, [](const CandidateReport& tried) {
            return tried.outcome.starts_with("chosen") &&
                   tried.outcome.find("loops on opposite sides") != std::string::npos;
        });
    };
    BakeOptions options = small_grid();
    options.size = {33, 33};
    options.fit = Fit::kSample;
    EXPECT_FALSE(is_unrolled(options)) << "has more error, or the rest of the test says nothing";
    options.metres_per_unit = 0.01;
    EXPECT_TRUE(is_unrolled(options));
}

TEST(Stages, OneAfterTheOtherTheyGiveWhatBakeMeshGives) {
    const BakeOptions options = small_grid();
    const Repaired source = repair_source(import_mesh(bowl(), "bowl"));
    ASSERT_EQ(source.components.size(), 1U);
    std::vector<CutMemory> cuts(1);
    const std::vector<double> aspects(1);
    Mapped mapped = map_source(source, {options.size, aspects}, options, cuts, {});
    ASSERT_EQ(mapped.charts.size(), 1U);
    EXPECT_EQ(mapped.charts[0].method, Method::kStretch);
    const auto chosen = [](const Candidate& tried) { return tried.outcome == CandidateOutcome::kChosen; };
    EXPECT_EQ(std::ranges::count_if(mapped.charts[0].candidates, chosen), 1);
    const Fitted plain{mapped.charts};
    const Fitted fitted = fit_source(source, std::move(mapped), options, false, {});
    const Layered layered = store_layers(source, fitted, {}, options, false, {});
    const Measured measured = measure_layers(source, fitted, layered, kSurfaceSamples, {});
    const BakeResult whole = bake_mesh({bowl(), "bowl"}, options);
    EXPECT_TRUE(layered.charts == whole.maps.charts);
    EXPECT_EQ(measured.error.rms, whole.report.error.rms);
    EXPECT_EQ(measured.charts.at(0).candidates.size(), whole.report.charts.at(0).candidates.size());
    const Layered unfitted = store_layers(source, plain, {}, options, false, {});
    EXPECT_LT(measured.error.rms, measure_layers(source, plain, unfitted, kSurfaceSamples, {}).error.rms);
}

/// A small part with inverted faces gets more samples, up to those of the largest, and nothing else changes.
TEST(Stages, SmallComponentsWithInvertedFacesGetFinerGrids) {
    model::TriMesh two = bowl();
    const auto count = static_cast<std::uint32_t>(two.positions.size());
    for (std::uint32_t v = 0; v < count; ++v) two.positions.push_back(two.positions[v] * 0.2 + model::Vec3d{3, 0, 0});
    for (std::size_t f = 0, end = two.faces.size(); f < end; ++f)
        two.faces.push_back({two.faces[f][0] + count, two.faces[f][1] + count, two.faces[f][2] + count});
    BakeOptions options = small_grid();
    options.size = {49, 49};
    const Repaired source = repair_source(import_mesh(std::move(two), "two"));
    ASSERT_EQ(source.components.size(), 2U);
    std::vector<CutMemory> cuts(2);
    const std::vector<double> aspects(2);
    const MapRequest request{options.size, aspects};
    Fitted fitted = fit_source(source, map_source(source, request, options, cuts, {}), options, false, {});
    ASSERT_EQ(fitted.inverted, (std::vector<std::size_t>{0, 0}));
    const std::size_t small = 1 - source.largest;
    ASSERT_EQ(fitted.charts[small].chart.m, 17U);
    const auto sides = [&](Fitted from) {
        from = refine_inverted(source, request, std::move(from), options, false, cuts, {});
        return std::pair(from.charts[source.largest].chart.m, from.charts[small].chart.m);
    };
    EXPECT_EQ(sides(fitted), std::pair(49U, 17U)) << "none is inverted";
    fitted.inverted[small] = 5;  // as if they were
    EXPECT_EQ(sides(fitted), std::pair(49U, 33U)) << "the first grid without any";
    fitted.inverted[small] = 0;
    fitted.inverted[source.largest] = 5;
    EXPECT_EQ(sides(fitted), std::pair(49U, 17U)) << "the largest keeps the grid that was asked for";
}

/// Parses "ask for --size 17x17, ..."; {0, 0} if the hint names no size.
GridSize size_named_in(const std::string& hint) {
    GridSize out{0, 0};
    const std::size_t at = hint.find("--size ");
    if (at == std::string::npos || std::sscanf(hint.c_str() + at, "--size %ux%u", &out.rows, &out.cols) != 2)
        return {0, 0};
    return out;
}

/// The error of a bake at `size`; nothing if it succeeds.
std::optional<model::Error> error_at(const model::TriMesh& mesh, BakeOptions options, GridSize size) {
    options.size = size;
    options.fit = Fit::kSample;
    const auto baked = attempt([&] { return bake_mesh({.mesh = mesh, .name = "limbs"}, options); });
    if (baked) return std::nullopt;
    return baked.error();
}

/// Nine holes of a sheet need nine cuts: too many paths for the border of a small square.
model::TriMesh sheet_of_nine_holes() {
    std::vector<std::array<std::uint32_t, 2>> holes;
    for (std::uint32_t i = 1; i < 12; i += 4)
        for (std::uint32_t j = 1; j < 12; j += 4) holes.push_back({i, j});
    return test::sheet_with_holes(12, holes);
}

TEST(BakeMesh, ASurfaceThatNeedsALargerGridIsToldWhichOne) {
    const model::TriMesh mesh = sheet_of_nine_holes();
    BakeOptions options = small_grid();
    options.domain = DomainChoice::kSquare;
    const GridSize asked{5, 5};
    const std::optional<model::Error> error = error_at(mesh, options, asked);
    ASSERT_TRUE(error);
    EXPECT_EQ(&error->code(), &codes::kGridTooSmall);
    const GridSize named = size_named_in(error->hint());
    ASSERT_GT(named.rows, asked.rows) << error->hint();
    ASSERT_LT(named.rows, 257u) << "not the smallest: " << error->hint();
    EXPECT_FALSE(error_at(mesh, options, named)) << "the size that the hint names does not work";
    const GridSize before{(named.rows + 1) / 2, (named.cols + 1) / 2};
    EXPECT_TRUE(error_at(mesh, options, before)) << "a smaller size works than the hint names";
}

TEST(BakeMesh, ASmallPartThatNeedsALargerGridIsToldTheSizeOfTheWholeAsset) {
    const model::TriMesh mesh = test::joined(test::grid_sheet(4, 4, 3, 3), sheet_of_nine_holes(), 5);
    BakeOptions options = small_grid();
    options.domain = DomainChoice::kSquare;
    const std::optional<model::Error> error = error_at(mesh, options, {5, 5});
    ASSERT_TRUE(error);
    const GridSize named = size_named_in(error->hint());
    ASSERT_GT(named.rows, 0u) << error->hint();
    EXPECT_FALSE(error_at(mesh, options, named)) << error->hint();
}

// Components are mapped side by side: which fails first depends on the machine.
TEST(BakeMesh, OfSeveralPartsThatFailTheFirstIsNamed) {
    model::TriMesh mesh = test::grid_sheet(4, 4, 3, 3);
    for (const double x : {5.0, 10.0, 15.0, 20.0}) mesh = test::joined(mesh, sheet_of_nine_holes(), x);
    BakeOptions options = small_grid();
    options.domain = DomainChoice::kSquare;
    for (int k = 0; k < 8; ++k) {
        const std::optional<model::Error> error = error_at(mesh, options, {5, 5});
        ASSERT_TRUE(error);
        EXPECT_EQ(std::string(error->what()).find("component 2 of 5: "), 0u) << error->what();
    }
}

TEST(BakeMesh, AFlatPanelOfNeedlesIsItsOwnChart) {
    // Teeth of 1/400 x 4 on a thin back.
    constexpr std::uint32_t kTeeth = 400;
    model::TriMesh comb;
    for (std::uint32_t k = 0; k <= kTeeth; ++k) {
        comb.positions.push_back({double(k) / kTeeth, 0, 0});
        comb.positions.push_back({double(k) / kTeeth, 0.01, 0});
    }
    for (std::uint32_t k = 0; k < kTeeth; ++k) {
        const std::uint32_t a = 2 * k, tip = 2 * (kTeeth + 1) + k;
        comb.positions.push_back({(k + 0.5) / kTeeth, 4, 0});
        comb.faces.insert(comb.faces.end(), {{a, a + 2, a + 3}, {a, a + 3, a + 1}, {a + 1, a + 3, tip}});
    }
    for (model::Vec3d& p : comb.positions) p = {p.x, 0.6 * p.y, 0.8 * p.y};
    for (std::uint32_t k = 1; k < kTeeth; ++k) comb.positions[2 * (kTeeth + 1) + k].x -= 0.4 / kTeeth;
    const BakeResult result = bake_mesh({.mesh = comb, .name = "comb"}, small_grid());
    ASSERT_EQ(result.report.charts.size(), 1u);
    EXPECT_EQ(result.report.charts[0].method, "arap");
    EXPECT_EQ(result.report.charts[0].candidates.size(), 1u) << "other maps were tried";
    EXPECT_GT(result.report.charts[0].candidates[0].psnr, 200);
}

// Soups have thousands of such charts.
TEST(BakeMesh, TriesNothingBesideAChartWithoutError) {
    model::TriMesh soup;
    for (std::uint32_t k = 0; k < 12; ++k) {
        const double x = 3.0 * k;
        soup.positions.insert(soup.positions.end(), {{x, 0, 0.1 * k}, {x + 1, 0.2, 0}, {x + 0.3, 0.9, 0.5}});
        soup.faces.push_back({3 * k, 3 * k + 1, 3 * k + 2});
    }
    const BakeResult result = bake_mesh({.mesh = soup, .name = "soup"}, small_grid());
    ASSERT_EQ(result.report.charts.size(), 12u);
    for (const ChartReport& chart : result.report.charts) {
        EXPECT_EQ(chart.candidates.size(), 1u) << "other maps were tried";
        EXPECT_EQ(chart.method, "stretch");
        EXPECT_GT(chart.candidates[0].psnr, 200);
    }
}

// Sixteen long teeth: the search for a cut ends after two of them, at 47 dB.
TEST(BakeMesh, CutsAllLimbsWhereThatPays) {
    BakeOptions options;
    options.size = {65, 65};
    options.domain = DomainChoice::kSquare;
    const BakeResult result = bake_mesh({.mesh = test::comb(16, 30), .name = "comb"}, options);
    const ChartReport& chart = result.report.charts.at(0);
    EXPECT_GT(result.report.error.psnr(), 53);
    EXPECT_EQ(chart.turned_faces, 0U);
    const auto to_tips = [](const CandidateReport& tried) {
        return tried.outcome.starts_with("chosen") &&
               tried.outcome.find("cut to the tips of limbs") != std::string::npos;
    };
    EXPECT_TRUE(std::ranges::any_of(chart.candidates, to_tips));
}

/// A ball with 42 long spikes.
model::TriMesh urchin() {
    constexpr std::size_t kSpikes = 42;  // the vertices of the ball before its last two subdivisions
    model::TriMesh out = test::icosphere(3);
    for (std::size_t v = 0; v < kSpikes; ++v) out.positions[v] = out.positions[v] * 30.0;
    return out;
}

// The square has no room for spikes: 45.5 dB. A slit one is nearly flat.
TEST(BakeMesh, UnfoldsLimbsThatTheSquareCrowds) {
    BakeOptions options;
    options.size = {33, 33};
    const BakeResult result = bake_mesh({.mesh = urchin(), .name = "urchin"}, options);
    const ChartReport& chart = result.report.charts.at(0);
    EXPECT_GT(result.report.error.psnr(), 50);
    EXPECT_EQ(chart.turned_faces, 0U);
    const auto unfolded = [](const CandidateReport& tried) {
        return tried.outcome.starts_with("chosen") && (tried.method == "lscm" || tried.method == "arap") &&
               tried.outcome.find("cut to the tips of limbs") != std::string::npos;
    };
    EXPECT_TRUE(std::ranges::any_of(chart.candidates, unfolded));
}

/// A wavy sheet of 12 x 12 quads with six straps, each a quad wide and six long.
model::TriMesh apron() {
    constexpr int kSide = 12, kLength = 6;
    std::vector<std::array<int, 2>> quads;
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j) quads.push_back({i, j});
    const auto strap = [&](int i, int j, int down, int right) {
        for (int k = 0; k < kLength; ++k) quads.push_back({i + k * down, j + k * right});
    };
    strap(kSide, 3, 1, 0);
    strap(kSide, 5, 1, 0);
    strap(10, -1, 0, -1);
    strap(-1, 11, -1, 0);
    strap(kSide, 10, 1, 0);
    strap(6, -1, 0, -1);
    model::TriMesh out;
    std::map<std::array<int, 2>, std::uint32_t> numbers;
    const auto number = [&](int i, int j) {
        const auto [it, is_new] = numbers.try_emplace({i, j}, static_cast<std::uint32_t>(out.positions.size()));
        const double x = double(i) / kSide, y = double(j) / kSide;
        if (is_new) out.positions.push_back({x, y, 0.2 * std::sin(3 * x) * std::cos(2 * y)});
        return it->second;
    };
    for (const auto& [i, j] : quads) {
        const std::uint32_t a = number(i, j), b = number(i + 1, j), c = number(i + 1, j + 1), d = number(i, j + 1);
        out.faces.insert(out.faces.end(), {{a, b, c}, {a, c, d}});
    }
    return out;
}

// Teeth that lie flat: 51 dB on the square, and samples to spare on a free chart.
TEST(BakeMesh, TakesAFreeChartWhereItIsFittedBetter) {
    BakeOptions options;
    options.size = {65, 65};
    const BakeResult either = bake_mesh({.mesh = test::comb(16, 30), .name = "comb"}, options);
    options.domain = DomainChoice::kSquare;
    const BakeResult square = bake_mesh({.mesh = test::comb(16, 30), .name = "comb"}, options);
    EXPECT_GT(either.report.error.psnr(), square.report.error.psnr() + 6);
    EXPECT_NE(either.report.charts.at(0).method, "stretch");
    EXPECT_EQ(either.report.charts.at(0).turned_faces, 0U);
}

/// A closed tube that winds: 24 times as long as it is around.
model::TriMesh winding_tube() {
    model::TriMesh mesh = test::finger(0.3, 44, 20, 360, 4);
    const auto last = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back({0, 0, -0.2});
    for (std::uint32_t j = 0; j < 20; ++j) mesh.faces.push_back({last, (j + 1) % 20, j});
    for (model::Vec3d& p : mesh.positions) p = {2 * std::sin(p.z / 2) + p.x, 3 * std::cos(p.z / 3) + p.y, p.z / 2};
    return mesh;
}

TEST(BakeMesh, LongSurfacesGetLongGrids) {
    BakeOptions options;
    options.size = {65, 65};
    const BakeResult square = bake_mesh({.mesh = winding_tube(), .name = "tube"}, options);
    EXPECT_EQ(square.maps.charts.at(0).rows, 65U) << "that was named";
    BakeOptions unasked = options, asked = options;
    unasked.any_aspect = true;
    asked.auto_samples = 65 * 65;
    for (const BakeOptions& searched : {unasked, asked}) {
        const BakeResult result = bake_mesh({.mesh = winding_tube(), .name = "tube"}, searched);
        const model::Chart& chart = result.maps.charts.at(0);
        EXPECT_LE(chart.rows * chart.cols, 65U * 65);
        EXPECT_GE(std::max(chart.rows, chart.cols), 4 * std::min(chart.rows, chart.cols));
        EXPECT_GT(result.report.error.psnr(), square.report.error.psnr() + 6);
    }
}

// Lengths in metres are for physics, which knows no free charts; its material may come at run time.
TEST(BakeMesh, UnitsStayOnTheSquare) {
    BakeOptions options;
    options.size = {65, 65};
    options.metres_per_unit = 0.01;
    for (const model::TriMesh& mesh : {test::comb(16, 30), apron(), test::grid_sheet(20, 20)}) {
        const BakeResult result = bake_mesh({.mesh = mesh, .name = "cloth"}, options);
        for (const CandidateReport& tried : result.report.charts.at(0).candidates) EXPECT_EQ(tried.method, "stretch");
    }
}

TEST(BakeMesh, TriesNoFreeChartWhereTheSquareStretchesLittle) {
    const BakeResult result = bake_mesh({.mesh = test::icosphere(4), .name = "ball"}, small_grid());
    for (const CandidateReport& tried : result.report.charts.at(0).candidates)
        EXPECT_TRUE(tried.method == "sphere" || tried.method == "stretch") << tried.method;
}

TEST(BakeMesh, CutsNoLimbsWhereNothingIsCrowded) {
    const BakeResult result = bake_mesh({.mesh = test::comb(3, 4), .name = "comb"}, small_grid());
    for (const CandidateReport& tried : result.report.charts.at(0).candidates)
        EXPECT_EQ(tried.outcome.find("limbs"), std::string::npos);
}

TEST(BakeMesh, TakesAnotherMapWhereFacesAreLeftInverted) {
    BakeOptions options = small_grid();
    options.ablate = {"free-charts"};
    const BakeResult result = bake_mesh({.mesh = apron(), .name = "apron"}, options);
    const ChartReport& chart = result.report.charts.at(0);
    EXPECT_EQ(chart.turned_faces, 0U);
    EXPECT_NE(chart.method, "stretch");
    EXPECT_GT(result.report.error.psnr(), 72);
    const auto outcomes = [&](std::string_view outcome) {
        return std::ranges::count_if(chart.candidates,
                                     [&](const CandidateReport& tried) { return tried.outcome.starts_with(outcome); });
    };
    EXPECT_EQ(outcomes("more inverted faces"), 1);
    EXPECT_EQ(outcomes("chosen"), 1);
}

}  // namespace
}  // namespace dgm::bake
