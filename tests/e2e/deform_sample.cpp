// SPDX-License-Identifier: GPL-3.0-or-later
// tests/e2e/deform_sample.cpp
// Deforms chart 0 of a .dgm by one touch through the runtime's public interface and puts all positions, before and
// after, into FOLDER/rest.bin and FOLDER/now.bin (f32, x y z a sample), for test_deform.py. Prints the table's error
// bound, the number of samples in reach and whether a seam was crossed.
#include <dgm/asset.h>
#include <dgm/deform.h>
#include <dgm/state.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

namespace {

int refuse(const dgm::Error& error) {
    std::fprintf(stderr, "%s: %s\n", dgm::error_name(error.code), error.message);
    return 1;
}

bool write_points(const std::string& path, const dgm::PointView& points) {
    std::ofstream out(path, std::ios::binary);
    for (std::size_t k = 0; k < points.count; ++k) {
        const dgm::Vec3 p = points[k];
        const float xyz[3] = {p.x, p.y, p.z};
        out.write(reinterpret_cast<const char*>(xyz), sizeof xyz);
    }
    return static_cast<bool>(out.flush());
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 11) {
        std::fprintf(stderr, "usage: dgm_deform_sample FILE FOLDER I J B SIGMA DX DY DZ D_MAX\n");
        return 2;
    }
    const std::string folder = argv[2];
    const auto whole = [&](int k) { return static_cast<std::uint32_t>(std::strtoul(argv[k], nullptr, 10)); };
    const auto real = [&](int k) { return std::strtof(argv[k], nullptr); };

    const auto asset = dgm::Asset::open(argv[1]);
    if (!asset) return refuse(asset.error());
    const auto chart = asset.value().chart(0);
    if (!chart) return refuse(chart.error());
    auto created = dgm::State::create(chart.value());
    if (!created) return refuse(created.error());
    dgm::State& state = created.value();

    dgm::KernelOptions kernel;
    kernel.reach = whole(5);
    kernel.sigma = real(6);
    const auto table = dgm::DeformTable::create(kernel);
    if (!table) return refuse(table.error());
    dgm::Touch touch;
    touch.sample = whole(3) * state.cols() + whole(4);
    touch.displacement = {real(7), real(8), real(9)};
    touch.d_max = real(10);
    touch.footprint = dgm::Footprint::Grid;
    const auto report = dgm::deform(state, table.value(), touch);
    if (!report) return refuse(report.error());

    std::printf("%.9g %u %d\n", static_cast<double>(table.value().error_bound()), report.value().samples,
                report.value().crossed_seam ? 1 : 0);
    return write_points(folder + "/rest.bin", state.rest_positions()) &&
                   write_points(folder + "/now.bin", state.positions())
               ? 0
               : 2;
}
