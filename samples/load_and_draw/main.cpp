// SPDX-License-Identifier: GPL-3.0-or-later
// samples/load_and_draw/main.cpp
// Opens a .dgm, lists its charts, presses a dent into each and writes what a renderer would draw, as OBJ.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <span>
#include <vector>

#include <dgm/asset.h>
#include <dgm/collide.h>
#include <dgm/deform.h>
#include <dgm/reconstruct.h>
#include <dgm/state.h>

namespace {

int fail(const char* what, const dgm::Error& error) {
    std::fprintf(stderr, "load_and_draw: %s: %s: %s\n", what, dgm::error_name(error.code), error.message);
    return 3;
}

/// Presses the sample nearest to the middle of the chart's box, against its normal, by 5 % of the box's diagonal.
dgm::Result<dgm::DeformReport> press(const dgm::Chart& chart, dgm::State& state) {
    const auto box = chart.bbox();
    const auto offset = chart.offset();
    const auto middle = [&](std::size_t axis) {
        return static_cast<float>((box[axis] + box[axis + 3]) / 2 - offset[axis]);  // states are in local coordinates
    };
    const auto contact = dgm::nearest_sample(state, {middle(0), middle(1), middle(2)});
    if (!contact) return contact.error();
    const auto table = dgm::DeformTable::create({.sigma = 16, .reach = 11});  // eq. 7: sigma and b, in grid steps
    if (!table) return table.error();

    const float depth = 0.05F * static_cast<float>(std::hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]));
    const std::uint32_t sample = contact.value().sample;
    std::printf("  pressed sample (%u, %u) by %g\n", sample / chart.cols(), sample % chart.cols(), depth);
    return dgm::deform(state, table.value(),
                       {.sample = sample, .displacement = -depth * state.normal(sample), .d_max = depth});
}

struct Vertex {  // as a vertex buffer would hold it
    float position[3], normal[3], uv[2];
};

/// Appends the present shape of `state` to `out`; `first` is the number of its first vertex, counted from 1.
dgm::Result<void> write_obj(const dgm::Chart& chart, const dgm::State& state, std::size_t first, std::ofstream& out) {
    const auto counts = dgm::mesh_counts(state);
    if (!counts) return counts.error();
    std::vector<Vertex> vertices(counts.value().vertices);
    std::vector<std::uint32_t> indices(counts.value().indices);
    const auto written = dgm::reconstruct(state,
                                          {.memory = std::as_writable_bytes(std::span(vertices)),
                                           .stride = sizeof(Vertex),
                                           .position_offset = offsetof(Vertex, position),
                                           .normal_offset = offsetof(Vertex, normal),
                                           .uv_offset = offsetof(Vertex, uv)},
                                          indices);
    if (!written) return written.error();

    char line[256];
    const auto offset = chart.offset();
    for (const Vertex& v : vertices) {
        std::snprintf(line, sizeof line, "v %.9g %.9g %.9g\nvt %.9g %.9g\nvn %.9g %.9g %.9g\n",
                      offset[0] + v.position[0], offset[1] + v.position[1], offset[2] + v.position[2], v.uv[0],
                      1 - v.uv[1], v.normal[0], v.normal[1], v.normal[2]);  // OBJ counts v from the bottom
        out << line;
    }
    for (std::size_t k = 0; k < indices.size(); k += 3) {
        out << 'f';
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::size_t n = first + indices[k + corner];
            out << ' ' << n << '/' << n << '/' << n;
        }
        out << '\n';
    }
    return {};
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: load_and_draw IN.dgm OUT.obj\n");
        return 1;
    }
    const auto asset = dgm::Asset::open(argv[1], {.verify_hashes = true});
    if (!asset) return fail(argv[1], asset.error());
    std::ofstream out(argv[2]);
    std::size_t first = 1;
    for (std::uint32_t k = 0; k < asset.value().chart_count(); ++k) {
        const dgm::Chart chart = asset.value().chart(k).value();
        std::printf("chart %u: %u x %u samples, method %s, %u layers\n", k, chart.rows(), chart.cols(), chart.method(),
                    chart.layer_count());
        auto state = dgm::State::create(chart);
        if (!state) return fail(argv[1], state.error());
        const auto pressed = press(chart, state.value());
        if (!pressed) return fail(argv[1], pressed.error());
        std::printf("  %u samples moved%s\n", pressed.value().samples,
                    pressed.value().crossed_seam ? ", across a seam" : "");
        if (const auto written = write_obj(chart, state.value(), first, out); !written)
            return fail(argv[1], written.error());
        first += chart.sample_count();
    }
    out.close();
    if (!out) {
        std::fprintf(stderr, "load_and_draw: %s: cannot be written\n", argv[2]);
        return 2;
    }
    return 0;
}
