// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/make_corpus.cpp
// make_corpus FOLDER: writes the seeds of corpus/open, small files with every kind of layer.
#include <fstream>
#include <string>

#include "dgm_builder.h"

using namespace dgm::test;

namespace {
void write(const std::string& path, const std::vector<ChartSpec>& charts) {
    const Image image = build(charts);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(image.bytes.data()), static_cast<std::streamsize>(image.bytes.size()));
}

ChartSpec quantised() {
    ChartSpec c;
    c.rows = 3;
    c.cols = 4;
    c.scale = {0.1, 0.2, 0.3};
    c.add("geometry", ElementType::kU16, {3, 4, 3}, std::vector<std::uint16_t>(36, 500));
    c.add("normal", ElementType::kI16, {3, 4, 2}, std::vector<std::int16_t>(24, 100));
    c.add("texture", ElementType::kU8, {2, 2, 4}, std::vector<std::uint8_t>(16, 9));
    c.add("bump", ElementType::kF16, {2, 2}, std::vector<std::uint16_t>(4));
    c.add("collision", ElementType::kF32, {1, 6}, std::vector<float>(6));
    c.add("diagonals", ElementType::kU8, {2, 3}, std::vector<std::uint8_t>(6, 1));
    c.add("other", ElementType::kU32, {2}, std::vector<std::uint32_t>(2));
    return c;
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 1;
    const std::string folder = std::string(argv[1]) + "/";
    write(folder + "square_fold.dgm", {grid_chart(9, 5, sheet, fold_seams(9, 5))});
    write(folder + "square_octahedron.dgm", {grid_chart(9, 9, sheet, octahedral_seams(9))});
    write(folder + "free_seam.dgm", {free_chart(5, 6, sheet, {{30, 41}, {31, 40}, {32, 39}})});
    write(folder + "quantised_two_charts.dgm", {quantised(), grid_chart(2, 2, sheet)});
    return 0;
}
