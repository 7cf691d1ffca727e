// SPDX-License-Identifier: MIT
// libdgm/include/dgm/asset.h
// Opens a .dgm file: maps it and checks its index before it hands out any view.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/allocator.h>
#include <dgm/map_view.h>
#include <dgm/result.h>

namespace dgm {

namespace detail {
struct AssetImpl;
}

/// Limits and choices for Asset::open().
struct OpenOptions {
    std::span<const char* const> required_layers = {};  ///< names that every chart must have, else MissingLayer
    /// If not empty, only these layers and the tables that every reader needs (seams, diagonals, mask, border_*) are
    /// listed, verified and read. Layers that are not read are not loaded either way, because files are mapped.
    std::span<const char* const> layers = {};
    bool verify_hashes = false;                        ///< check the hash of every layer now, see Asset::verify()
    std::uint64_t max_file_bytes = ~std::uint64_t{0};  ///< more than these limits allow: LimitExceeded
    std::uint32_t max_charts = 1u << 16;
    std::uint32_t max_layers = 1u << 20;      ///< all charts together
    std::uint32_t max_samples = 0xFFFFFFFEu;  ///< rows * cols + border samples of one chart
    Allocator allocator = {};
};

/// Memory of an asset. Pages of the mapping are loaded when they are read, and shared between processes.
struct AssetUsage {
    std::uint64_t mapped_bytes = 0;  ///< address space; 0 for open_memory()
    std::uint64_t heap_bytes = 0;    ///< taken from the allocator
};

/// One chart of an asset: a small value, valid while the Asset lives. All members are O(1) except find().
class Chart {
 public:
    [[nodiscard]] DGM_API std::uint32_t rows() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t cols() const noexcept;
    [[nodiscard]] DGM_API layout::Domain domain() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t border_samples() const noexcept;
    /// Counts all samples: those of the grid (index i * cols + j), then those of the border (rows * cols + b).
    [[nodiscard]] DGM_API std::uint32_t sample_count() const noexcept;
    /// Returns min x, y, z, then max x, y, z, in the frame of the source mesh.
    [[nodiscard]] DGM_API std::span<const double, 6> bbox() const noexcept;
    /// Both relate the frames: source = offset + local, and local = scale * value stored in the layer `geometry`.
    [[nodiscard]] DGM_API std::span<const double, 3> offset() const noexcept;
    [[nodiscard]] DGM_API std::span<const double, 3> scale() const noexcept;
    /// Names the parameterization, e.g. "stretch"; zero-terminated.
    [[nodiscard]] DGM_API const char* method() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t layer_count() const noexcept;
    /// @return BadArgument if k >= layer_count().
    [[nodiscard]] DGM_API Result<LayerView> layer(std::uint32_t k) const noexcept;
    /// Finds a layer by its name. @return MissingLayer if the chart does not have it; BadArgument if `name` is null.
    [[nodiscard]] DGM_API Result<LayerView> find(const char* name) const noexcept;

 private:
    friend class Asset;
    Chart(const detail::AssetImpl* impl, std::uint32_t index) noexcept : impl_(impl), index_(index) {}
    const detail::AssetImpl* impl_;
    std::uint32_t index_;
};

/// A mapped .dgm file. It is read-only once open: any number of threads may use it at the same time.
///
/// Opening checks magic, version, header and index hash, file size, ranges (without overflow), alignment, names,
/// overlaps, and types and shapes of the known layers. Unknown optional layers are listed with known = false; unknown
/// required layers are an error. Opening does not read the layers: verify() checks their hashes, and validate_chart()
/// checks their values.
///
/// The file must not become shorter while it is mapped: reading pages beyond its end is a fault (SIGBUS, an access
/// violation). If it is overwritten in place, calls that read it return old values, new values or an error; the indices
/// that they write stay in range. A State, and an index once read, do not change.
class Asset {
 public:
    /// Maps a file. On Windows `path` is UTF-8. @return FileMissing, ReadFailed, Unsupported (a platform that maps no
    ///         files), or an error of open_memory().
    [[nodiscard]] DGM_API static Result<Asset> open(const char* path, const OpenOptions& options = {}) noexcept;
    /// Reads bytes in memory instead. The caller keeps them alive; they are aligned to 16.
    ///
    /// @return Truncated, NotDgm, BadVersion, HashMismatch, BadIndex, BadLayer, UnknownLayer, MissingLayer,
    ///         LimitExceeded, OutOfMemory, BadArgument, each with the byte offset of the field or layer at fault.
    [[nodiscard]] DGM_API static Result<Asset> open_memory(std::span<const std::byte> bytes,
                                                           const OpenOptions& options = {}) noexcept;
    DGM_API Asset(Asset&& other) noexcept;
    DGM_API Asset& operator=(Asset&& other) noexcept;
    DGM_API ~Asset();

    [[nodiscard]] DGM_API std::uint32_t chart_count() const noexcept;
    /// @return BadArgument if k >= chart_count().
    [[nodiscard]] DGM_API Result<Chart> chart(std::uint32_t k) const noexcept;
    /// Compares the XXH3-128 of every layer with the index. Reads the whole file. @return HashMismatch with the offset
    ///         of the layer.
    [[nodiscard]] DGM_API Result<void> verify() const noexcept;
    [[nodiscard]] DGM_API AssetUsage usage() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t format_version() const noexcept;
    /// XXH3-128 of the source mesh file and of the bake settings.
    [[nodiscard]] DGM_API std::span<const std::uint8_t, 16> source_hash() const noexcept;
    [[nodiscard]] DGM_API std::span<const std::uint8_t, 16> settings_hash() const noexcept;

 private:
    explicit Asset(detail::AssetImpl* impl) noexcept : impl_(impl) {}
    [[nodiscard]] Result<void> check_wishes(const OpenOptions& options) const noexcept;
    detail::AssetImpl* impl_;
};

}  // namespace dgm
