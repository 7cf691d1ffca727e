// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/write_sample.cpp
// write_sample FILE: a 17 x 33 tube with a seam, for programs outside the build tree.
#include <cstdio>
#include <fstream>

#include "dgm_builder.h"

int main(int argc, char** argv) {
    if (argc != 2) return 1;
    const auto tube = [](double i, double j) {
        const double angle = 2 * 3.14159265358979 * j / 32;
        return dgm::test::Point{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)),
                                static_cast<float>(i / 8)};
    };
    const auto image = dgm::test::build({dgm::test::grid_chart(17, 33, tube, dgm::test::tube_seams(17, 33))});
    std::ofstream out(argv[1], std::ios::binary);
    out.write(reinterpret_cast<const char*>(image.bytes.data()), static_cast<std::streamsize>(image.bytes.size()));
    return out.flush() ? 0 : 2;
}
