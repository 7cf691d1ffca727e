// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/raw_dgm.h
// A .dgm as bytes: changing header and records, with hashes that fit again, so that only the change is wrong.
#pragma once
#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include <dgm/layout.h>

#include "dgm/hash.h"

namespace dgm::test {

class RawDgm {
 public:
    explicit RawDgm(std::string bytes) : bytes_(std::move(bytes)) {
        std::memcpy(&header, bytes_.data(), sizeof header);
        charts.resize(header.chart_count);
        std::memcpy(charts.data(), bytes_.data() + header.index_offset, charts.size() * sizeof(layout::ChartRecord));
        layers.resize(header.layer_count);
        std::memcpy(layers.data(), bytes_.data() + layers_at(), layers.size() * sizeof(layout::LayerRecord));
    }
    /// The bytes with `header`, `charts` and `layers` as they are now and the index hashed again.
    /// @param rest_hash  false: takes out the hash of what is not a layer, as another writer may leave it out
    [[nodiscard]] std::string bytes(bool rest_hash = true) {
        std::memcpy(bytes_.data() + header.index_offset, charts.data(), charts.size() * sizeof(layout::ChartRecord));
        std::memcpy(bytes_.data() + layers_at(), layers.data(), layers.size() * sizeof(layout::LayerRecord));
        const std::span<const char> records(bytes_.data() + header.index_offset, header.index_bytes);
        const auto index_hash = formats::hash_bytes(std::as_bytes(records));
        std::copy(index_hash.begin(), index_hash.end(), header.index_hash);
        if (!rest_hash) std::fill(std::begin(header.rest_hash), std::end(header.rest_hash), std::uint8_t{0});
        header.file_bytes = claimed_size != 0 ? claimed_size : bytes_.size();
        const auto hash =
            formats::hash_bytes(std::as_bytes(std::span(&header, 1)).first(offsetof(layout::FileHeader, header_hash)));
        std::copy(hash.begin(), hash.end(), header.header_hash);
        std::memcpy(bytes_.data(), &header, sizeof header);
        return bytes_;
    }
    /// First layer of this name; there must be one.
    [[nodiscard]] layout::LayerRecord& layer(const std::string& name) {
        return *std::find_if(layers.begin(), layers.end(), [&](const auto& l) { return l.name == name; });
    }

    layout::FileHeader header{};
    std::vector<layout::ChartRecord> charts;
    std::vector<layout::LayerRecord> layers;
    std::uint64_t claimed_size = 0;  ///< what the header says instead of the truth

 private:
    [[nodiscard]] std::size_t layers_at() const {
        return header.index_offset + header.chart_count * sizeof(layout::ChartRecord);
    }
    std::string bytes_;
};

}  // namespace dgm::test
