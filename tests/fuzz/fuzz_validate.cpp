// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_validate.cpp
// The validator behind the container: a good map set in which the bytes change layers, tables and report. (Bytes of a
// file would hardly ever get past its hashes.) Promises: findings carry codes; nothing is thrown.
//
// The bytes are a list of edits: chart, layer, kind, then two numbers. Kinds: write a byte, write a 32-bit word, change
// an extent, drop the layer, rename it, change the type, change the grid's size, change a byte of the report.
#include <cstring>

#include "target.h"
#include "unit/validate/validation_maps.h"
#include "validate/validation.h"

namespace {

/// Reads numbers from the bytes, zeros behind their end.
class Edits {
 public:
    Edits(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
    [[nodiscard]] bool more() const { return left_ > 0; }
    std::uint32_t next(std::size_t bytes) {
        std::uint32_t value = 0;
        const std::size_t n = std::min(bytes, left_);
        if (n > 0) std::memcpy(&value, data_, n);
        data_ += n;
        left_ -= n;
        return value;
    }

 private:
    const std::uint8_t* data_;
    std::size_t left_;
};

/// The layer's bytes follow its shape, as both readers promise; up to a size that a validator can look at quickly.
void fit_bytes(dgm::model::Layer& layer) {
    std::uint64_t bytes = dgm::layout::element_size(layer.type);
    for (std::uint64_t& extent : layer.shape) {
        if (bytes * std::max<std::uint64_t>(extent, 1) > 1 << 16) extent = 1;
        bytes *= extent;
    }
    layer.bytes.resize(bytes);
}

void edit(dgm::model::MapSet& maps, Edits& edits) {
    dgm::model::Chart& chart = maps.charts[edits.next(1) % maps.charts.size()];
    const std::uint32_t which = edits.next(1), kind = edits.next(1) % 8, at = edits.next(2), value = edits.next(4);
    if (kind == 6) {
        (at % 2 == 0 ? chart.rows : chart.cols) = value % 64;
        return;
    }
    if (kind == 7) {
        maps.report_json[at % maps.report_json.size()] = static_cast<char>(value);
        return;
    }
    if (chart.layers.empty()) return;
    dgm::model::Layer& layer = chart.layers[which % chart.layers.size()];
    if (kind == 0 && !layer.bytes.empty()) layer.bytes[at % layer.bytes.size()] = static_cast<std::byte>(value);
    if (kind == 1 && layer.bytes.size() >= 4) std::memcpy(&layer.bytes[at % (layer.bytes.size() / 4) * 4], &value, 4);
    if (kind == 2) {
        layer.shape[at % layer.shape.size()] = value % 1024;
        fit_bytes(layer);
    }
    if (kind == 3) chart.layers.erase(chart.layers.begin() + which % chart.layers.size());
    if (kind == 4) layer.name[at % layer.name.size()] = static_cast<char>('a' + value % 26);
    if (kind == 5) {
        layer.type = static_cast<dgm::model::ElementType>(1 + value % 6);
        fit_bytes(layer);
    }
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm;
    model::MapSet maps = test::good_maps();
    Edits edits(data, size);
    for (int k = 0; k < 16 && edits.more(); ++k) edit(maps, edits);
    const validate::FileValidation result = validate::validate_maps(maps);
    for (const formats::Finding& finding : result.findings)
        test::require(finding.code != nullptr && !finding.message.empty());
    return 0;
}
