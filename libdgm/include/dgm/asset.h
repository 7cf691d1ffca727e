// SPDX-License-Identifier: MIT
// libdgm/include/dgm/asset.h
// Opening a .dgm: the file is mapped and its index checked before any view is handed out.
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

struct OpenOptions {
    std::span<const char* const> required_layers = {};  ///< names every chart must hold, else MissingLayer
    /// If not empty: only these and the tables every reader needs (seams, diagonals, mask, border_*) are listed,
    /// checked by verify() and ever read. (What is not read is not loaded either way: files are mapped.)
    std::span<const char* const> layers = {};
    bool verify_hashes = false;  ///< hash every layer now (see Asset::verify)
    std::uint64_t max_file_bytes = ~std::uint64_t{0};
    std::uint32_t max_charts = 1u << 16;
    std::uint32_t max_layers = 1u << 20;
    std::uint32_t max_samples = 0xFFFFFFFEu;  ///< rows * cols + border samples of one chart
    Allocator allocator = {};
};

/// What an asset costs. Pages of the mapping are loaded when they are read, and shared between processes.
struct AssetUsage {
    std::uint64_t mapped_bytes = 0;  ///< of address space; 0 for open_memory()
    std::uint64_t heap_bytes = 0;    ///< taken from the allocator
};

/// One chart of an asset: a small value, valid while the Asset lives. All members are O(1) but find().
class Chart {
 public:
    [[nodiscard]] DGM_API std::uint32_t rows() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t cols() const noexcept;
    [[nodiscard]] DGM_API layout::Domain domain() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t border_samples() const noexcept;
    /// Grid samples (index i * cols + j), then border samples (rows * cols + b).
    [[nodiscard]] DGM_API std::uint32_t sample_count() const noexcept;
    /// min xyz, max xyz in the source frame.
    [[nodiscard]] DGM_API std::span<const double, 6> bbox() const noexcept;
    /// Source frame = offset + local; local = scale * stored (docs/design.md section 4).
    [[nodiscard]] DGM_API std::span<const double, 3> offset() const noexcept;
    [[nodiscard]] DGM_API std::span<const double, 3> scale() const noexcept;
    /// Parameterization method, zero-terminated.
    [[nodiscard]] DGM_API const char* method() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t layer_count() const noexcept;
    /// @return BadArgument if k >= layer_count().
    [[nodiscard]] DGM_API Result<LayerView> layer(std::uint32_t k) const noexcept;
    /// Layer by name. @return MissingLayer if the chart does not hold it.
    [[nodiscard]] DGM_API Result<LayerView> find(const char* name) const noexcept;

 private:
    friend class Asset;
    Chart(const detail::AssetImpl* impl, std::uint32_t index) noexcept : impl_(impl), index_(index) {}
    const detail::AssetImpl* impl_;
    std::uint32_t index_;
};

/// A mapped .dgm file. Read-only after open: any number of threads may use it at once.
///
/// Opening checks magic, version, header and index hash, file size, ranges (overflow-checked), alignment, names,
/// overlaps, and types and shapes of the known layers; unknown optional layers are listed with known = false, unknown
/// required ones are refused. It does not read the layers: see verify() for their hashes and validate_chart() for
/// their values. The file must not be shortened while it is mapped: pages beyond its end cannot be read (SIGBUS, an
/// access violation). If it is overwritten in place, calls that read it give values of either content, or an error;
/// indices they write still lie in the range promised, and a State or an index once read stays what it is.
class Asset {
 public:
    /// Maps a file. @return FileMissing, ReadFailed, or what open_memory answers.
    [[nodiscard]] DGM_API static Result<Asset> open(const char* path, const OpenOptions& options = {}) noexcept;
    /// The same for bytes the caller keeps alive, aligned to 16.
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
    /// XXH3-128 of every layer against the index; reads the whole file. @return HashMismatch with the layer's offset.
    [[nodiscard]] DGM_API Result<void> verify() const noexcept;
    [[nodiscard]] DGM_API AssetUsage usage() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t format_version() const noexcept;
    [[nodiscard]] DGM_API std::span<const std::uint8_t, 16> source_hash() const noexcept;
    [[nodiscard]] DGM_API std::span<const std::uint8_t, 16> settings_hash() const noexcept;

 private:
    explicit Asset(detail::AssetImpl* impl) noexcept : impl_(impl) {}
    [[nodiscard]] Result<void> check_wishes(const OpenOptions& options) const noexcept;
    detail::AssetImpl* impl_;
};

}  // namespace dgm
