// SPDX-License-Identifier: GPL-3.0-or-later
// tests/e2e/faulty_bake.cpp
// dgm-bake around a bake that fails in the way the mesh's file name asks for: what test_isolation.py runs. Everything
// but bake_asset is the real program, so the real one needs no switch for its own tests.
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "bake/bake_program.h"
#include "baking/pipeline.h"
#include "model/codes.h"

namespace {

using dgm::bake::BakeOptions;
using dgm::bake::BakeResult;
using dgm::model::Progress;

[[noreturn]] void sleep_for_ever() {
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

[[noreturn]] void eat_memory() {
    std::vector<std::unique_ptr<char[]>> eaten;
    for (;;) {
        eaten.push_back(std::make_unique<char[]>(std::size_t{16} << 20));
        // A limit that does not hold must fail the test, not the machine.
        if (eaten.size() > 256) std::_Exit(3);
    }
}

/// A library that swallows the failed allocation, and then falls over what it did not get.
[[noreturn]] void eat_memory_and_abort() {
    try {
        eat_memory();
    } catch (const std::bad_alloc&) { std::abort(); }
}

/// A 3x3 sheet; the z coordinate is 0.25 throughout.
BakeResult small_sheet(const std::filesystem::path& source, const BakeOptions&) {
    dgm::model::Layer geometry{"geometry", dgm::model::ElementType::kF32, {3, 3, 3}, {}, {}, true};
    geometry.bytes.resize(27 * sizeof(float));
    for (std::size_t k = 0; k < 9; ++k) {
        const float point[3] = {0.5F * static_cast<float>(k / 3), 0.5F * static_cast<float>(k % 3), 0.25F};
        std::memcpy(&geometry.bytes[k * sizeof(point)], point, sizeof(point));
    }
    dgm::model::Chart chart;
    chart.rows = chart.cols = 3;
    chart.method = "uv";
    chart.bbox = {0, 0, 0.25, 1, 1, 0.25};
    chart.layers.push_back(std::move(geometry));
    BakeResult out;
    out.maps.generator = "faulty";
    out.maps.source_name = source.filename().string();
    out.maps.charts.push_back(std::move(chart));
    out.report.source_name = out.maps.source_name;
    out.report.error.diagonal = 1.5;
    out.report.error.rms = 1.5e-4;
    out.report.charts.push_back({});
    out.report.charts[0].method = "uv";
    out.report.charts[0].rows = out.report.charts[0].cols = 3;
    out.maps.report_json = dgm::bake::to_json(out.report, false);
    return out;
}

int mark = -1;  ///< file that is empty until the worker was killed once

BakeResult bake(const std::filesystem::path& source, const BakeOptions& options, const Progress& progress) {
    const std::string fault = source.stem().string();
    progress.update("cut", 0.5);
    if (fault == "killed-once") {  // as the system kills where memory runs out; the second time there is enough
        if (lseek(mark, 0, SEEK_END) == 0 && write(mark, "x", 1) == 1) std::raise(SIGKILL);
        return dgm::bake::bake_asset(source, options, progress);
    }
    if (fault.starts_with("real-")) return dgm::bake::bake_asset(source, options, progress);
    if (fault == "segfault") std::raise(SIGSEGV);
    if (fault == "processor-time") std::raise(SIGXCPU);
    if (fault == "abort") {
        std::fputs("free(): invalid pointer\n", stderr);
        std::abort();
    }
    if (fault == "hang") sleep_for_ever();
    if (fault == "hang-deaf") {  // closes everything, and still does not go
        for (int fd = 0; fd < 16; ++fd) close(fd);
        sleep_for_ever();
    }
    if (fault == "memory") eat_memory();
    if (fault == "memory-abort") eat_memory_and_abort();
    if (fault == "quit") std::_Exit(0);
    if (fault == "quit-5") std::_Exit(5);
    if (fault == "throw") throw std::runtime_error("vector::_M_range_check");
    if (fault == "babble")  // a flood without an end of line
        for (const std::vector<char> junk(1 << 20, 'x');;)
            if (write(3, junk.data(), junk.size()) < 0) std::_Exit(0);
    if (fault == "lie") {
        const char claim[] = "{\"type\":\"result\",\"report\":\"{}\"}\n";  // says it is done, has written nothing
        if (write(3, claim, sizeof(claim) - 1) < 0) std::_Exit(1);
        std::_Exit(0);
    }
    if (fault == "chatty")
        for (int k = 0; k < 100000; ++k) std::puts("a library says something on stdout");
    if (fault == "refuse")
        throw dgm::model::Error(dgm::model::codes::kNonOrientable, "component 2 has one side only", "");
    return small_sheet(source, options);
}

}  // namespace

int main(int argc, char** argv) {
    // A worker in its sandbox writes into the output folder alone, and into files that are open already.
    if (const char* path = std::getenv("DGM_KILLED_MARK")) mark = open(path, O_RDWR | O_CREAT, 0600);
    return dgm::bake::bake_program(argc, argv, bake);
}
