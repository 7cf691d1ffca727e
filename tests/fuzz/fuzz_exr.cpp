// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_exr.cpp
// The EXR reader. Promises: a layer has as many bytes as its shape says; nothing but model::Error is thrown.
#include "bytes_file.h"
#include "exr/exr_reader.h"
#include "model/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm;
    const test::BytesFile file(data, size);
    formats::ExrReadLimits limits;
    limits.max_pixels_per_part = 1 << 20;
    limits.max_total_bytes = 1 << 26;
    limits.max_parts = 1 << 8;
    try {
        for (const model::Chart& chart : formats::read_exr(file.path(), limits).charts)
            for (const model::Layer& layer : chart.layers) {
                std::uint64_t bytes = layout::element_size(layer.type);
                for (const std::uint64_t extent : layer.shape) bytes *= extent;
                test::require(bytes == layer.bytes.size());
            }
    } catch (const model::Error&) {
        // A refusal.
    }
    return 0;
}
