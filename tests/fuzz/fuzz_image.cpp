// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_image.cpp
// Pictures that a mesh names, as a worker reads them. Promises: as many pixels as the size says, heights in 0..1;
// nothing but model::Error is thrown.
#include "bytes_file.h"
#include "image/image.h"
#include "model/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm;
    const test::BytesFile file(data, size);
    try {
        const formats::Image image = formats::read_image({file.path()});
        test::require(image.width > 0 && image.height > 0 &&
                      image.pixels.size() == std::size_t{image.width} * image.height);
    } catch (const model::Error&) {}  // a refusal
    try {
        const formats::FloatImage heights = formats::read_height({file.path()});
        test::require(heights.pixels.size() == std::size_t{heights.width} * heights.height);
        for (const float h : heights.pixels) test::require(h >= 0 && h <= 1);
    } catch (const model::Error&) {}
    return 0;
}
