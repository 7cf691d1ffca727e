// SPDX-License-Identifier: GPL-3.0-or-later
// tests/property/determinism_test.cpp
// The same mesh gives the same bytes, again and with another number of threads.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <optional>

#include "geometry/cgal/border_simple.h"
#include "geometry/cgal/constrained_triangulation.h"
#include "geometry/chart/free_chart.h"
#include "geometry/chart/square_chart.h"
#include "geometry/cut_search/cut_search.h"
#include "geometry/layers/layers.h"
#include "geometry/parameterize/free_methods.h"
#include "geometry/repair/repair.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

struct Outcome {
    model::Chart square, free;
    double search_rms = 0, rms = 0;
};

Outcome bake_with(std::size_t threads, const TriMesh& mesh) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const RepairedMesh repaired = repair(mesh);
    const TriMesh& component = repaired.components.at(0);
    CutSearchOptions options;
    options.m = 33;
    options.n = 29;
    options.samples = 3000;
    options.max_extremities = 5;
    const CutSearchResult cut = search_cut(component, options, {});
    const auto layers = [&](const SampledChart& chart) {
        const SampleGrid fine = rasterize(chart.disk->mesh.faces, chart.uv, 2 * chart.m - 1, 2 * chart.n - 1);
        return make_layers({chart, repaired.frame, choose_frame(repaired.frame, chart, false), {}, fine, std::nullopt},
                           {})
            .chart;
    };
    Outcome out;
    const SampledChart square = make_square_chart(cut.disk, 33, 29, cut.rotation, *make_stretch_parameterizer(4), {});
    out.search_rms = cut.rms;
    out.rms = quick_error(component, square, 30'000).rms;
    out.square = layers(square);
    out.free = layers(make_free_chart(cut.disk, 33, 29, *make_free_parameterizer("arap"),
                                      {border_is_simple, constrained_triangulation}, {}));
    return out;
}

TEST(Determinism, SameBytesWhateverTheThreads) {
    for (const TriMesh& mesh : {test::torus(1, 0.4, 32, 16), test::finger(0.3, 1, 16, 12, 6)}) {
        const Outcome one = bake_with(1, mesh), two = bake_with(2, mesh), again = bake_with(2, mesh);
        EXPECT_EQ(one.search_rms, two.search_rms);
        EXPECT_EQ(one.rms, two.rms);
        EXPECT_TRUE(one.square == two.square);
        EXPECT_TRUE(one.free == two.free);
        EXPECT_TRUE(again.square == two.square);
        EXPECT_TRUE(again.free == two.free);
        EXPECT_FALSE(one.square.layers.empty());
    }
}

}  // namespace
}  // namespace dgm::bake
