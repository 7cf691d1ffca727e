// SPDX-License-Identifier: GPL-3.0-or-later
// tests/e2e/dump_layers.cpp
// Maps a .dgm with the runtime and puts each layer's bytes into FOLDER/<chart>.<layer>.bin, for test_layers.py to hold
// against what h5py reads. Prints one line a layer: chart, name, type number, file offset, shape.
#include <dgm/asset.h>

#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <string>

namespace {

int refuse(const dgm::Error& error) {
    std::fprintf(stderr, "%s at byte %" PRIu64 ": %s\n", dgm::error_name(error.code), error.byte_offset, error.message);
    return 1;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    dgm::OpenOptions options;
    options.verify_hashes = true;
    const auto asset = dgm::Asset::open(argv[1], options);
    if (!asset) return refuse(asset.error());
    for (std::uint32_t c = 0; c < asset.value().chart_count(); ++c) {
        const auto chart = asset.value().chart(c);
        if (!chart) return refuse(chart.error());
        std::printf("chart %" PRIu32 " %" PRIu32 " %" PRIu32 " %s\n", c, chart.value().rows(), chart.value().cols(),
                    chart.value().method());
        for (std::uint32_t k = 0; k < chart.value().layer_count(); ++k) {
            const auto layer = chart.value().layer(k);
            if (!layer) return refuse(layer.error());
            const dgm::LayerView& view = layer.value();
            std::printf("layer %" PRIu32 " %s %" PRIu32 " %" PRIu64, c, view.name,
                        static_cast<std::uint32_t>(view.type), view.file_offset);
            for (std::uint32_t d = 0; d < view.rank; ++d) std::printf(" %" PRIu64, view.shape[d]);
            std::printf("\n");
            const std::string path = std::string(argv[2]) + "/" + std::to_string(c) + "." + view.name + ".bin";
            std::ofstream out(path, std::ios::binary);
            out.write(reinterpret_cast<const char*>(view.data), static_cast<std::streamsize>(view.bytes));
            if (!out.flush()) return 2;
        }
    }
    return 0;
}
