// SPDX-License-Identifier: MIT
// libdgm/src/file/asset_impl.h
// An opened asset: checked copies of the records, and the place of the bytes.
#pragma once
#include <array>
#include <span>

#include <dgm/asset.h>
#include <dgm/layout.h>

#include "base/memory.h"
#include "file/mapped_file.h"

namespace dgm::detail {

struct ChartInfo {
    layout::ChartRecord record;
    char method[17];  ///< zero-terminated copy
};

struct LayerInfo {
    layout::LayerRecord record;  ///< name is checked to be zero-terminated
    std::uint64_t record_offset;
    bool known;
};

struct AssetImpl {
    AssetImpl(const Allocator& a, MappedFile&& f, std::span<const std::byte> b) noexcept
        : allocator(a), file(std::move(f)), bytes(b) {}
    Allocator allocator;
    MappedFile file;  ///< empty if the caller owns the bytes
    std::span<const std::byte> bytes;
    layout::FileHeader header = {};
    Array<ChartInfo> charts;
    Array<LayerInfo> layers;
};

/// Reads and checks header and records of `asset.bytes` into `asset` (every check that needs no layer bytes).
[[nodiscard]] Result<void> read_index(AssetImpl& asset, const OpenOptions& options) noexcept;

/// Type and shape of a layer against the table of docs/design.md section 4. Sets `known`.
/// @return BadLayer at the record, UnknownLayer if it is required and not in the table.
[[nodiscard]] Result<void> check_layer(const layout::ChartRecord& chart, LayerInfo& layer) noexcept;

using Hash = std::array<std::uint8_t, 16>;
/// XXH3-128 in canonical byte order.
[[nodiscard]] Hash hash_bytes(const void* data, std::size_t bytes) noexcept;

}  // namespace dgm::detail
