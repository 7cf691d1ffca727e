// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/rehash.h
// Makes all hashes and checksums of a changed .dgm fit again: what anybody can do who has read SPEC.md.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "dgm/hash.h"
#include "dgm/index.h"

// HDF5's own checksum of its structures (lookup3): exported by the library, not declared by its headers.
extern "C" std::uint32_t H5_checksum_metadata(const void* data, std::size_t bytes, std::uint32_t start);

namespace dgm::test {

/// A structure of HDF5's: bytes with their checksum behind them.
struct Hdf5Block {
    std::size_t begin, bytes;
};

/// Those of a file whose checksums fit.
inline std::vector<Hdf5Block> hdf5_blocks(std::string_view file) {
    std::vector<Hdf5Block> out;
    for (const char* signature : {"\211HDF", "OHDR", "OCHK", "BTHD", "BTLF", "BTIN", "FRHP", "FHIB", "FSHD"})
        for (std::size_t at = file.find(signature); at != std::string_view::npos; at = file.find(signature, at + 1))
            for (std::size_t bytes = 8; bytes < 1024 && at + bytes + 4 <= file.size(); ++bytes) {
                std::uint32_t stored = 0;
                std::memcpy(&stored, file.data() + at + bytes, sizeof stored);
                if (stored != H5_checksum_metadata(file.data() + at, bytes, 0)) continue;
                out.push_back({at, bytes});
                break;
            }
    return out;
}

inline void mend_checksums(std::string& file, const std::vector<Hdf5Block>& blocks) {
    for (const Hdf5Block& b : blocks) {
        const std::uint32_t sum = H5_checksum_metadata(file.data() + b.begin, b.bytes, 0);
        std::memcpy(file.data() + b.begin + b.bytes, &sum, sizeof sum);
    }
}

template <std::size_t N>
void hash_into(std::uint8_t (&to)[N], std::string_view bytes) {
    const auto hash = formats::hash_bytes(std::as_bytes(std::span(bytes)));
    std::copy(hash.begin(), hash.end(), to);
}

/// Hashes of layers, as far as their records name bytes of the file; of the index; of the rest, or none as of another
/// writer where layers overlap; of the header.
inline void mend_hashes(std::string& file) {
    layout::FileHeader header;
    if (file.size() < layout::kUserBlockBytes) return;
    std::memcpy(&header, file.data(), sizeof header);
    const auto inside = [&](std::uint64_t offset, std::uint64_t bytes) {
        return bytes <= file.size() && offset <= file.size() - bytes;
    };
    std::fill(std::begin(header.rest_hash), std::end(header.rest_hash), std::uint8_t{0});
    if (header.chart_count < 1024 && header.layer_count < 4096 && inside(header.index_offset, header.index_bytes) &&
        header.index_bytes == formats::index_bytes(header.chart_count, header.layer_count)) {
        const auto records = std::as_bytes(std::span(file)).subspan(header.index_offset, header.index_bytes);
        formats::Index index = formats::decode_records(records, header.chart_count, header.layer_count);
        bool sound = true;
        std::vector<std::pair<std::uint64_t, std::uint64_t>> taken;
        for (layout::LayerRecord& layer : index.layers) {
            sound = sound && layer.offset >= layout::kUserBlockBytes && inside(layer.offset, layer.bytes);
            if (!inside(layer.offset, layer.bytes)) continue;
            hash_into(layer.hash, std::string_view(file).substr(layer.offset, layer.bytes));
            if (layer.bytes > 0) taken.emplace_back(layer.offset, layer.offset + layer.bytes);
        }
        std::sort(taken.begin(), taken.end());
        for (std::size_t k = 1; k < taken.size(); ++k) sound = sound && taken[k - 1].second <= taken[k].first;
        const std::vector<std::byte> again = formats::encode_records(index);
        std::memcpy(file.data() + header.index_offset, again.data(), again.size());
        if (sound) {
            formats::Hasher rest;
            for (const auto& [begin, end] : formats::ranges_beside_layers(index, file.size()))
                rest.add(std::as_bytes(std::span(file)).subspan(begin, end - begin));
            const auto hash = rest.result();
            std::copy(hash.begin(), hash.end(), header.rest_hash);
        }
    }
    if (inside(header.index_offset, header.index_bytes))
        hash_into(header.index_hash, std::string_view(file).substr(header.index_offset, header.index_bytes));
    const std::string_view head(reinterpret_cast<const char*>(&header), offsetof(layout::FileHeader, header_hash));
    hash_into(header.header_hash, head);
    std::memcpy(file.data(), &header, sizeof header);
}

}  // namespace dgm::test
