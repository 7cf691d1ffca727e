// SPDX-License-Identifier: GPL-3.0-or-later
// tests/exact/bake_bits.cpp
// Bakes samples in this process and prints a hash of each file, so that processors can be compared.
//
//   dgm_bake_bits SAMPLES WORK [--threads N] [--few | --case NAME]
//
// SAMPLES: what dgm-make-samples wrote. WORK: a folder for the files. --few: the quickest cases, --case: one, for
// emulators. The first line, "control", is a hash of the C library's own functions: it shows whether a comparison
// compares anything.
// No worker process is started: emulators do not follow into it, and it may drop the environment that a test sets.
#include <tbb/global_control.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string>

#include "baking/methods.h"
#include "baking/pipeline.h"
#include "dgm/dgm_writer.h"
#include "dgm/hash.h"
#include "exr/exr_writer.h"

namespace {
namespace fs = std::filesystem;
using namespace dgm;
using bake::BakeOptions;
using bake::Fit;
using bake::Method;

struct Case {
    const char* name;
    const char* mesh;
    bool few;
    BakeOptions options;
};

BakeOptions at(std::uint32_t side, Method method = Method::kAuto, Fit fit = Fit::kL2) {
    BakeOptions out;
    out.size = {side, side};
    out.method = method;
    out.fit = fit;
    return out;
}
BakeOptions with_exr(BakeOptions options) {
    options.write_exr = true;
    return options;
}
BakeOptions within(BakeOptions options, double percent) {
    options.max_error = bake::ErrorGoal{.value = percent};
    options.precision = bake::Precision::kAuto;
    return options;
}

/// Every method, fit and kind of chart; organs, cloth, furniture of several components.
const Case kCases[] = {
    {"sheet", "sheet/sheet.obj", true, at(17)},
    {"sheet-mvc", "sheet/sheet.obj", true, at(17, Method::kMvc)},
    {"sheet-conformal", "sheet/sheet.obj", true, at(17, Method::kConformal)},
    {"back-arap", "chair/back.obj", true, at(17, Method::kArap)},
    {"back-sample", "chair/back.obj", true, at(17, Method::kAuto, Fit::kSample)},
    {"chair", "chair/chair.obj", false, at(33)},
    {"seat-best", "chair/seat.obj", false, at(33, Method::kAuto, Fit::kBest)},
    {"cover-exr", "cushion/cover.obj", false, with_exr(at(33))},
    {"cushion-best", "cushion/cushion.obj", false, at(33, Method::kAuto, Fit::kBest)},
    {"cushion-uv", "cushion/cushion.obj", false, at(33, Method::kUv)},
    {"cover-goal", "cushion/cover.obj", false, within(at(65), 0.5)},
    {"stomach-3ds", "stomach/stomach.3ds", false, at(33)},
    {"stomach", "stomach/stomach.obj", false, at(65)},
    {"stomach-sphere", "stomach/stomach.obj", false, at(33, Method::kSphere, Fit::kSample)},
    {"stomach-lscm", "stomach/stomach.obj", false, at(33, Method::kLscm)},
    {"cover-lscm", "cushion/cover.obj", false, at(33, Method::kLscm)},
    {"cover-arap", "cushion/cover.obj", false, at(33, Method::kArap)},
    {"cover-slim", "cushion/cover.obj", false, at(33, Method::kSlim)},
    {"cover-mvc", "cushion/cover.obj", false, at(33, Method::kMvc)},
    {"cover-authalic", "cushion/cover.obj", false, at(33, Method::kAuthalic)},
    {"cover-conformal", "cushion/cover.obj", false, at(33, Method::kConformal)},
    {"cover-tutte", "cushion/cover.obj", false, at(33, Method::kTutte)},
    {"liver", "liver/liver.obj", false, at(33)},
};

/// A hash of what this process gets from the C library.
std::string control() {
    std::uint64_t hash = 14695981039346656037u;
    const auto add = [&](double value) { hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 1099511628211u; };
    for (int k = 1; k < 20000; ++k) {
        volatile double x = k * 0.003;  // at run time
        for (const double value : {std::sin(x), std::cos(x), std::tan(x), std::atan2(x, 2.0), std::exp(-x), std::log(x),
                                   std::pow(x, 0.3), std::acos(x / 100)})
            add(value);
    }
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

std::string bits_of(const Case& c, const fs::path& samples, const fs::path& work) {
    const bake::BakeResult result = bake::bake_asset(samples / c.mesh, c.options, {});
    const fs::path file = work / (std::string(c.name) + ".dgm");
    formats::write_dgm(result.maps, file);
    std::string out = formats::to_hex(formats::hash_file(file));
    if (!c.options.write_exr) return out;
    for (const fs::path& exr : formats::write_exr(result.maps, work / (std::string(c.name) + ".exr")))
        out += " " + formats::to_hex(formats::hash_file(exr));
    return out;
}
}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: dgm_bake_bits SAMPLES WORK [--threads N] [--few | --case NAME]\n");
        return 1;
    }
    bool few = false;
    const char* only = nullptr;
    std::size_t threads = 2;
    for (int k = 3; k < argc; ++k) {
        if (std::strcmp(argv[k], "--few") == 0) few = true;
        if (std::strcmp(argv[k], "--case") == 0 && k + 1 < argc) only = argv[++k];
        if (std::strcmp(argv[k], "--threads") == 0 && k + 1 < argc) threads = std::strtoul(argv[++k], nullptr, 10);
    }
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    std::printf("control %s\n", control().c_str());
    int code = 0;
    for (const Case& c : kCases) {
        if ((few && !c.few) || (only != nullptr && std::strcmp(only, c.name) != 0)) continue;
        try {
            std::printf("%s %s\n", c.name, bits_of(c, argv[1], argv[2]).c_str());
        } catch (const std::exception& e) {
            std::printf("%s failed: %s\n", c.name, e.what());
            code = 2;
        }
        std::fflush(stdout);
    }
    return code;
}
