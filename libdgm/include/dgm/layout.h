// SPDX-License-Identifier: MIT
// libdgm/include/dgm/layout.h
// Defines the bytes of the index in a .dgm file's user block; formats/SPEC.md describes them.
//
// A .dgm is an HDF5 file with a 4096-byte user block. The user block starts with a FileHeader; the chart records and
// the layer records follow it directly when they fit into the block; else they are in the HDF5 dataset `/index`
// (u8, contiguous) and the header gives their absolute offset. All numbers are little-endian.
#pragma once
#include <cstddef>
#include <cstdint>

namespace dgm::layout {

inline constexpr char kMagic[8] = {'D', 'G', 'M', 'v', '\r', '\n', '\x1a', '\n'};
inline constexpr std::uint32_t kFormatVersion = 1;
inline constexpr std::size_t kUserBlockBytes = 4096;
inline constexpr std::size_t kMinAlignment = 64;
inline constexpr std::uint32_t kMaxRank = 4;

enum class ElementType : std::uint32_t { kU8 = 1, kU16 = 2, kU32 = 3, kI16 = 4, kF16 = 5, kF32 = 6 };
enum class Domain : std::uint32_t { kSquare = 0, kFree = 1 };

/// Size in bytes of one element; 0 for any other value.
[[nodiscard]] constexpr std::uint32_t element_size(ElementType type) noexcept {
    switch (type) {
        case ElementType::kU8:
            return 1;
        case ElementType::kU16:
        case ElementType::kI16:
        case ElementType::kF16:
            return 2;
        case ElementType::kU32:
        case ElementType::kF32:
            return 4;
    }
    return 0;
}

/// A reader that does not know a layer must reject the file if the layer has this flag, and else skip the layer.
inline constexpr std::uint32_t kLayerRequired = 1u;

struct FileHeader {                // 128 bytes at offset 0
    char magic[8];                 // kMagic
    std::uint32_t format_version;  // kFormatVersion
    std::uint32_t header_bytes;    // sizeof(FileHeader)
    std::uint64_t file_bytes;      // size of the whole file
    std::uint64_t index_offset;    // absolute offset of the records: 128, or that of dataset /index
    std::uint64_t index_bytes;     // chart_count * sizeof(ChartRecord) + layer_count * sizeof(LayerRecord)
    std::uint32_t chart_count;
    std::uint32_t layer_count;       // of all charts together
    std::uint8_t index_hash[16];     // XXH3-128 of the records, canonical (big-endian) byte order of xxHash
    std::uint8_t source_hash[16];    // XXH3-128 of the source mesh file
    std::uint8_t settings_hash[16];  // XXH3-128 of the bake settings
    std::uint8_t rest_hash[16];      // XXH3-128 of the file from byte 4096 on without the layers; all 0: none
    std::uint8_t header_hash[16];    // XXH3-128 of the 112 bytes before it
};
static_assert(sizeof(FileHeader) == 128);

struct ChartRecord {  // 192 bytes
    std::uint32_t rows, cols;
    std::uint32_t domain;       // Domain
    std::uint32_t first_layer;  // index of this chart's first LayerRecord; charts' layers are consecutive
    std::uint32_t layer_count;
    std::uint32_t border_samples;  // extra samples of a free domain, else 0
    double bbox[6];                // min xyz, max xyz of the reconstruction, source units and frame
    double offset[3], scale[3];    // position = offset + scale * stored geometry
    char method[16];               // zero-padded ASCII, e.g. "stretch"
    std::uint8_t reserved[56];     // 0
};
static_assert(sizeof(ChartRecord) == 192);

struct LayerRecord {  // 104 bytes
    char name[24];    // zero-padded ASCII
    std::uint32_t chart;
    std::uint32_t type;  // ElementType
    std::uint32_t rank;  // 1..kMaxRank
    std::uint32_t flags;
    std::uint64_t shape[4];  // unused entries are 0
    std::uint64_t offset;    // absolute, a multiple of kMinAlignment
    std::uint64_t bytes;     // product of shape * element size
    std::uint8_t hash[16];   // XXH3-128 of the bytes, canonical byte order
};
static_assert(sizeof(LayerRecord) == 104);

}  // namespace dgm::layout
