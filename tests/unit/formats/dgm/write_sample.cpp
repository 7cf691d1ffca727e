// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/dgm/write_sample.cpp
// Writes FOLDER/sample_<k>.dgm and beside it, in plain files, what each layer and attribute should read as.
#include <fstream>
#include <iostream>

#include "dgm/dgm_writer.h"
#include "dgm/hash.h"
#include "model/codes.h"
#include "unit/formats/test_maps.h"

namespace {

void write_expected(const dgm::model::MapSet& maps, const std::filesystem::path& stem) {
    static constexpr const char* kTypes[] = {"", "u1", "u2", "u4", "i2", "f2", "f4"};
    std::ofstream list(stem.string() + ".txt");
    list.precision(17);
    list << "set " << dgm::formats::to_hex(maps.source_hash) << ' ' << dgm::formats::to_hex(maps.settings_hash) << '\n';
    for (std::size_t k = 0; k < maps.charts.size(); ++k) {
        const auto& chart = maps.charts[k];
        list << "chart " << k << ' ' << chart.rows << ' ' << chart.cols << ' '
             << (chart.domain == dgm::model::Domain::kFree ? "free" : "square") << ' ' << chart.method;
        for (const double value : chart.bbox) list << ' ' << value;
        for (const double value : chart.offset) list << ' ' << value;
        for (const double value : chart.scale) list << ' ' << value;
        list << '\n';
        for (const auto& layer : chart.layers) {
            const std::string file = stem.string() + "_" + std::to_string(k) + "_" + layer.name + ".bin";
            list << "layer " << k << ' ' << layer.name << ' ' << kTypes[static_cast<unsigned>(layer.type)] << ' '
                 << file;
            for (const auto extent : layer.shape) list << ' ' << extent;
            list << '\n';
            dgm::test::write_bytes(file, {reinterpret_cast<const char*>(layer.bytes.data()), layer.bytes.size()});
        }
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 1;
    try {
        const std::size_t charts[] = {1, 3, 9};  // records in the user block, and in /index
        for (std::size_t k = 0; k < std::size(charts); ++k) {
            const std::filesystem::path stem = std::filesystem::path(argv[1]) / ("sample_" + std::to_string(k));
            const dgm::model::MapSet maps = dgm::test::random_maps(100 + k, charts[k]);
            dgm::formats::write_dgm(maps, stem.string() + ".dgm");
            write_expected(maps, stem);
        }
    } catch (const std::exception& e) {
        std::cerr << e.what() << '\n';
        return 1;
    }
}
