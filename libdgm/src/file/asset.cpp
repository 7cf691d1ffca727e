// SPDX-License-Identifier: MIT
// libdgm/src/file/asset.cpp
#include <dgm/asset.h>

#include <bit>
#include <cstring>

#include "file/asset_impl.h"

// Layers are handed out as they stand in the file.
static_assert(std::endian::native == std::endian::little, "libdgm maps little-endian files without conversion");

namespace dgm {
namespace {
using detail::AssetImpl;

constexpr std::size_t kMemoryAlignment = 16;

LayerView view_of(const AssetImpl& asset, const detail::LayerInfo& info) noexcept {
    const layout::LayerRecord& record = info.record;
    LayerView view;
    view.name = info.record.name;
    view.type = static_cast<layout::ElementType>(record.type);
    view.rank = record.rank;
    view.flags = record.flags;
    std::memcpy(view.shape, record.shape, sizeof view.shape);
    view.file_offset = record.offset;
    view.data = asset.bytes.data() + record.offset;
    view.bytes = static_cast<std::size_t>(record.bytes);
    view.known = info.known;
    return view;
}

/// Is this a table that every reader needs to understand a chart?
bool is_table(const char* name) noexcept {
    for (const char* table : {"seams", "reversed", "diagonals", "mask"})
        if (std::strcmp(name, table) == 0) return true;
    return std::strncmp(name, "border_", 7) == 0;
}

/// Forgets the layers that were not asked for.
Result<void> keep_layers(AssetImpl& asset, std::span<const char* const> names) noexcept {
    if (names.empty()) return {};
    for (const char* name : names)
        if (name == nullptr) return Error{ErrorCode::BadArgument, kNoOffset, "a layer name is null"};
    std::uint32_t kept = 0;
    for (detail::ChartInfo& chart : asset.charts) {
        const std::uint32_t first = kept;
        for (std::uint32_t k = 0; k < chart.record.layer_count; ++k) {
            const detail::LayerInfo& info = asset.layers[chart.record.first_layer + k];
            bool wanted = is_table(info.record.name);
            for (const char* name : names) wanted = wanted || std::strcmp(info.record.name, name) == 0;
            if (wanted) asset.layers[kept++] = info;  // never ahead of what is read
        }
        chart.record.first_layer = first;
        chart.record.layer_count = kept - first;
    }
    asset.header.layer_count = kept;
    return {};
}

Result<AssetImpl*> open_bytes(detail::MappedFile&& file, std::span<const std::byte> bytes,
                              const OpenOptions& options) noexcept {
    AssetImpl* impl = detail::create<AssetImpl>(options.allocator, options.allocator, std::move(file), bytes);
    if (impl == nullptr) return Error{ErrorCode::OutOfMemory, kNoOffset, "no memory for the asset"};
    const auto read = [&]() -> Result<void> {
        if (auto r = read_index(*impl, options); !r) return r;
        return keep_layers(*impl, options.layers);
    };
    if (auto r = read(); !r) {
        detail::destroy(impl);
        return r.error();
    }
    return impl;
}
}  // namespace

const char* error_name(ErrorCode code) noexcept {
    switch (code) {
        case ErrorCode::Ok:
            return "OK";
        case ErrorCode::BadArgument:
            return "BAD_ARGUMENT";
        case ErrorCode::OutOfMemory:
            return "OUT_OF_MEMORY";
        case ErrorCode::FileMissing:
            return "FILE_MISSING";
        case ErrorCode::ReadFailed:
            return "READ_FAILED";
        case ErrorCode::NotDgm:
            return "NOT_DGM";
        case ErrorCode::BadVersion:
            return "BAD_VERSION";
        case ErrorCode::Truncated:
            return "TRUNCATED";
        case ErrorCode::HashMismatch:
            return "HASH_MISMATCH";
        case ErrorCode::BadIndex:
            return "BAD_INDEX";
        case ErrorCode::BadLayer:
            return "BAD_LAYER";
        case ErrorCode::BadValue:
            return "BAD_VALUE";
        case ErrorCode::BadSeamTable:
            return "BAD_SEAM_TABLE";
        case ErrorCode::SeamGap:
            return "SEAM_GAP";
        case ErrorCode::NotFinite:
            return "NOT_FINITE";
        case ErrorCode::MissingLayer:
            return "MISSING_LAYER";
        case ErrorCode::UnknownLayer:
            return "UNKNOWN_LAYER";
        case ErrorCode::LimitExceeded:
            return "LIMIT_EXCEEDED";
        case ErrorCode::BufferTooSmall:
            return "BUFFER_TOO_SMALL";
        case ErrorCode::NotFound:
            return "NOT_FOUND";
        case ErrorCode::Unsupported:
            return "UNSUPPORTED";
        case ErrorCode::Busy:
            return "BUSY";
    }
    return "UNKNOWN";
}

std::uint32_t Chart::rows() const noexcept {
    return impl_->charts[index_].record.rows;
}
std::uint32_t Chart::cols() const noexcept {
    return impl_->charts[index_].record.cols;
}
layout::Domain Chart::domain() const noexcept {
    return static_cast<layout::Domain>(impl_->charts[index_].record.domain);
}
std::uint32_t Chart::border_samples() const noexcept {
    return impl_->charts[index_].record.border_samples;
}
std::uint32_t Chart::sample_count() const noexcept {
    return rows() * cols() + border_samples();
}
std::span<const double, 6> Chart::bbox() const noexcept {
    return std::span<const double, 6>(impl_->charts[index_].record.bbox);
}
std::span<const double, 3> Chart::offset() const noexcept {
    return std::span<const double, 3>(impl_->charts[index_].record.offset);
}
std::span<const double, 3> Chart::scale() const noexcept {
    return std::span<const double, 3>(impl_->charts[index_].record.scale);
}
const char* Chart::method() const noexcept {
    return impl_->charts[index_].method;
}
std::uint32_t Chart::layer_count() const noexcept {
    return impl_->charts[index_].record.layer_count;
}

Result<LayerView> Chart::layer(std::uint32_t k) const noexcept {
    if (k >= layer_count()) return Error{ErrorCode::BadArgument, kNoOffset, "the chart has no such layer"};
    return view_of(*impl_, impl_->layers[impl_->charts[index_].record.first_layer + k]);
}

Result<LayerView> Chart::find(const char* name) const noexcept {
    if (name == nullptr) return Error{ErrorCode::BadArgument, kNoOffset, "the layer name is null"};
    const layout::ChartRecord& chart = impl_->charts[index_].record;
    for (std::uint32_t k = 0; k < chart.layer_count; ++k) {
        const detail::LayerInfo& info = impl_->layers[chart.first_layer + k];
        if (std::strcmp(info.record.name, name) == 0) return view_of(*impl_, info);
    }
    return Error{ErrorCode::MissingLayer, kNoOffset, "the chart does not hold this layer"};
}

Result<Asset> Asset::open(const char* path, const OpenOptions& options) noexcept {
    if (path == nullptr) return Error{ErrorCode::BadArgument, kNoOffset, "the path is null"};
    auto file = detail::MappedFile::open(path, options.max_file_bytes);
    if (!file) return file.error();
    const std::span<const std::byte> bytes = file.value().bytes();
    if (!detail::is_valid(options.allocator))
        return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    auto impl = open_bytes(std::move(file).value(), bytes, options);
    if (!impl) return impl.error();
    Asset asset(impl.value());
    if (auto r = asset.check_wishes(options); !r) return r.error();
    return asset;
}

Result<Asset> Asset::open_memory(std::span<const std::byte> bytes, const OpenOptions& options) noexcept {
    if (!detail::is_valid(options.allocator))
        return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    if (bytes.size() > options.max_file_bytes)
        return Error{ErrorCode::LimitExceeded, kNoOffset, "the file is longer than the limit allows"};
    if (reinterpret_cast<std::uintptr_t>(bytes.data()) % kMemoryAlignment != 0)
        return Error{ErrorCode::BadArgument, kNoOffset, "the memory is not aligned to 16 bytes"};
    auto impl = open_bytes({}, bytes, options);
    if (!impl) return impl.error();
    Asset asset(impl.value());
    if (auto r = asset.check_wishes(options); !r) return r.error();
    return asset;
}

Result<void> Asset::check_wishes(const OpenOptions& options) const noexcept {
    for (std::uint32_t k = 0; k < chart_count(); ++k)
        for (const char* name : options.required_layers)
            if (!Chart(impl_, k).find(name))
                return Error{ErrorCode::MissingLayer,
                             impl_->header.index_offset + k * std::uint64_t{sizeof(layout::ChartRecord)},
                             "a chart does not hold a layer the caller needs"};
    return options.verify_hashes ? verify() : Result<void>{};
}

Asset::Asset(Asset&& other) noexcept : impl_(std::exchange(other.impl_, nullptr)) {}
Asset& Asset::operator=(Asset&& other) noexcept {
    std::swap(impl_, other.impl_);
    return *this;
}
Asset::~Asset() {
    detail::destroy(impl_);
}

std::uint32_t Asset::chart_count() const noexcept {
    return impl_->header.chart_count;
}
Result<Chart> Asset::chart(std::uint32_t k) const noexcept {
    if (k >= chart_count()) return Error{ErrorCode::BadArgument, kNoOffset, "the asset has no such chart"};
    return Chart(impl_, k);
}
std::uint32_t Asset::format_version() const noexcept {
    return impl_->header.format_version;
}
std::span<const std::uint8_t, 16> Asset::source_hash() const noexcept {
    return std::span<const std::uint8_t, 16>(impl_->header.source_hash);
}
std::span<const std::uint8_t, 16> Asset::settings_hash() const noexcept {
    return std::span<const std::uint8_t, 16>(impl_->header.settings_hash);
}

Result<void> Asset::verify() const noexcept {
    for (std::uint32_t k = 0; k < impl_->header.layer_count; ++k) {
        const detail::LayerInfo& info = impl_->layers[k];
        const layout::LayerRecord& l = info.record;
        const detail::Hash hash = detail::hash_bytes(impl_->bytes.data() + l.offset, static_cast<std::size_t>(l.bytes));
        if (std::memcmp(hash.data(), l.hash, sizeof l.hash) != 0)
            return Error{ErrorCode::HashMismatch, l.offset, "a layer differs from its hash"};
    }
    return {};
}

}  // namespace dgm
