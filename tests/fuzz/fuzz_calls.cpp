// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_calls.cpp
// Makes a map, opens it and makes any calls with any options, in any order. The bytes are decisions (dice.h): no file
// is read. Promise: no map that passes validate_chart() can crash, abort or tear the runtime (fuzz_calls_program.cpp).
#include "fuzz_calls.h"
#include "random_maps.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm::test;
    Dice dice({data, size});
    std::vector<ChartSpec> charts;
    for (std::uint32_t k = dice.one_in(4) ? dice.between(2, 3) : 1; k > 0; --k) {
        charts.push_back(random_chart(dice));
        if (dice.one_in(5)) spoil(dice, charts.back());
    }
    const Image image = build(charts);
    dgm::OpenOptions options;
    options.verify_hashes = true;
    auto asset = dgm::Asset::open_memory(image.bytes, options);
    if (!asset) return 0;  // a scale, say, that is none
    if (dice.one_in(3))
        call_c(dice, image.bytes);
    else
        call_all(dice, asset.value());
    return 0;
}
