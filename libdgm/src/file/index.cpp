// SPDX-License-Identifier: MIT
// libdgm/src/file/index.cpp
// Header and records of a .dgm (layout.h): every field is range-checked before it is used.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "file/asset_impl.h"

namespace dgm::detail {
namespace {
using layout::ChartRecord;
using layout::FileHeader;
using layout::LayerRecord;

Error bad_index(std::uint64_t offset, const char* message) noexcept {
    return {ErrorCode::BadIndex, offset, message};
}

bool same(const Hash& hash, const std::uint8_t (&stored)[16]) noexcept {
    return std::memcmp(hash.data(), stored, 16) == 0;
}

Result<void> read_header(AssetImpl& asset) noexcept {
    FileHeader& header = asset.header;
    const std::uint64_t size = asset.bytes.size();
    if (size < sizeof(FileHeader)) {
        if (size >= sizeof(header.magic) && std::memcmp(asset.bytes.data(), layout::kMagic, sizeof(header.magic)) != 0)
            return Error{ErrorCode::NotDgm, 0, "the file does not start with the .dgm magic"};
        return Error{ErrorCode::Truncated, size, "the file ends inside its header"};
    }
    std::memcpy(&header, asset.bytes.data(), sizeof header);
    if (std::memcmp(header.magic, layout::kMagic, sizeof header.magic) != 0)
        return Error{ErrorCode::NotDgm, 0, "the file does not start with the .dgm magic"};
    if (header.format_version == 0 || header.format_version > layout::kFormatVersion)
        return Error{ErrorCode::BadVersion, offsetof(FileHeader, format_version), "the format version is not known"};
    if (header.header_bytes != sizeof(FileHeader))
        return bad_index(offsetof(FileHeader, header_bytes), "the header has another length than its version says");
    if (!same(hash_bytes(asset.bytes.data(), offsetof(FileHeader, header_hash)), header.header_hash))
        return Error{ErrorCode::HashMismatch, offsetof(FileHeader, header_hash), "the header differs from its hash"};
    if (header.file_bytes > size) return Error{ErrorCode::Truncated, size, "the file is shorter than its header says"};
    if (header.file_bytes < size)
        return bad_index(offsetof(FileHeader, file_bytes), "the file is longer than its header says");
    if (size < layout::kUserBlockBytes)
        return Error{ErrorCode::Truncated, size, "the file is shorter than its user block"};
    return {};
}

/// Where the records stand: in the user block right behind the header, or beyond the block.
Result<void> check_index_range(const FileHeader& header, const OpenOptions& options) noexcept {
    if (header.chart_count == 0) return bad_index(offsetof(FileHeader, chart_count), "the file holds no charts");
    if (header.chart_count > options.max_charts)
        return Error{ErrorCode::LimitExceeded, offsetof(FileHeader, chart_count), "more charts than the limit allows"};
    if (header.layer_count > options.max_layers)
        return Error{ErrorCode::LimitExceeded, offsetof(FileHeader, layer_count), "more layers than the limit allows"};
    // 32-bit counts times small sizes cannot overflow 64 bits.
    const std::uint64_t bytes = header.chart_count * std::uint64_t{sizeof(ChartRecord)} +
                                header.layer_count * std::uint64_t{sizeof(LayerRecord)};
    if (header.index_bytes != bytes)
        return bad_index(offsetof(FileHeader, index_bytes), "the index length does not match the counts");
    const bool inside =
        header.index_offset == sizeof(FileHeader) && bytes <= layout::kUserBlockBytes - sizeof(FileHeader);
    const bool beyond = header.index_offset >= layout::kUserBlockBytes &&
                        header.index_offset % layout::kMinAlignment == 0 && header.index_offset <= header.file_bytes &&
                        bytes <= header.file_bytes - header.index_offset;
    if (!inside && !beyond) return bad_index(offsetof(FileHeader, index_offset), "the index lies outside the file");
    return {};
}

bool all_finite(const double* values, int count) noexcept {
    for (int k = 0; k < count; ++k)
        if (!std::isfinite(values[k])) return false;
    return true;
}

Result<void> check_chart(const ChartRecord& c, std::uint64_t at, std::uint64_t first_layer, const AssetImpl& asset,
                         const OpenOptions& options) noexcept {
    if (c.rows < 2 || c.rows > 65535) return bad_index(at + offsetof(ChartRecord, rows), "rows are not in 2..65535");
    if (c.cols < 2 || c.cols > 65535) return bad_index(at + offsetof(ChartRecord, cols), "columns are not in 2..65535");
    if (c.domain > static_cast<std::uint32_t>(layout::Domain::kFree))
        return bad_index(at + offsetof(ChartRecord, domain), "the domain is unknown");
    if (c.domain == static_cast<std::uint32_t>(layout::Domain::kSquare) && c.border_samples != 0)
        return bad_index(at + offsetof(ChartRecord, border_samples), "a square domain has no border samples");
    const std::uint64_t samples = std::uint64_t{c.rows} * c.cols + c.border_samples;
    if (samples > options.max_samples || samples > 0xFFFFFFFEu)
        return Error{ErrorCode::LimitExceeded, at, "more samples than the limit allows"};
    if (c.first_layer != first_layer || c.layer_count > asset.header.layer_count - first_layer)
        return bad_index(at + offsetof(ChartRecord, first_layer), "the charts' layers are not consecutive");
    if (!all_finite(c.bbox, 6) || c.bbox[0] > c.bbox[3] || c.bbox[1] > c.bbox[4] || c.bbox[2] > c.bbox[5])
        return bad_index(at + offsetof(ChartRecord, bbox), "the bounding box is not one");
    if (!all_finite(c.offset, 3)) return bad_index(at + offsetof(ChartRecord, offset), "the offset is not finite");
    if (!all_finite(c.scale, 3) || !(c.scale[0] > 0 && c.scale[1] > 0 && c.scale[2] > 0))
        return bad_index(at + offsetof(ChartRecord, scale), "the scale is not a positive number");
    return {};
}

/// Zero-terminated and zero-padded, printable ASCII, not empty.
bool is_name(const char (&name)[24]) noexcept {
    std::size_t length = 0;
    while (length < sizeof name && name[length] >= 0x21 && name[length] <= 0x7E) ++length;
    if (length == 0 || length == sizeof name) return false;
    return std::all_of(name + length, name + sizeof name, [](char c) { return c == 0; });
}

Result<void> check_layer_record(const LayerRecord& l, std::uint64_t at, std::uint32_t chart,
                                const FileHeader& header) noexcept {
    if (!is_name(l.name)) return bad_index(at, "the layer name is not a zero-padded ASCII word");
    if (l.chart != chart) return bad_index(at + offsetof(LayerRecord, chart), "the layer names another chart");
    std::uint64_t bytes = layout::element_size(static_cast<layout::ElementType>(l.type));
    if (bytes == 0) return bad_index(at + offsetof(LayerRecord, type), "the element type is unknown");
    if (l.rank < 1 || l.rank > layout::kMaxRank)
        return bad_index(at + offsetof(LayerRecord, rank), "the rank is not in 1..4");
    for (std::uint32_t k = 0; k < layout::kMaxRank; ++k) {
        const std::uint64_t place = at + offsetof(LayerRecord, shape) + 8 * k;
        if (k >= l.rank) {
            if (l.shape[k] != 0) return bad_index(place, "an unused shape entry is not 0");
        } else if (__builtin_mul_overflow(bytes, l.shape[k], &bytes)) {
            return bad_index(place, "the shape overflows");
        }
    }
    if (bytes != l.bytes) return bad_index(at + offsetof(LayerRecord, bytes), "the length does not match the shape");
    if (l.offset % layout::kMinAlignment != 0)
        return bad_index(at + offsetof(LayerRecord, offset), "the layer is not aligned");
    if (l.bytes == 0 && l.offset == 0) return {};  // an empty table needs no place
    if (l.offset < layout::kUserBlockBytes || l.offset > header.file_bytes || l.bytes > header.file_bytes - l.offset)
        return bad_index(at + offsetof(LayerRecord, offset), "the layer lies outside the file");
    return {};
}

struct Range {
    std::uint64_t begin, end, place;
};

/// No layer may share bytes with another or with the index: a repaired file would otherwise lie about both.
Result<void> check_overlaps(const AssetImpl& asset) noexcept {
    Array<Range> ranges;
    if (!ranges.allocate(asset.allocator, asset.layers.size() + 1))
        return Error{ErrorCode::OutOfMemory, kNoOffset, "no memory for the index"};
    std::size_t count = 0;
    if (asset.header.index_offset >= layout::kUserBlockBytes)
        ranges[count++] = {asset.header.index_offset, asset.header.index_offset + asset.header.index_bytes,
                           offsetof(FileHeader, index_offset)};
    for (const LayerInfo& l : asset.layers)
        if (l.record.bytes != 0)
            ranges[count++] = {l.record.offset, l.record.offset + l.record.bytes,
                               l.record_offset + offsetof(LayerRecord, offset)};
    std::sort(ranges.begin(), ranges.begin() + count, [](const Range& a, const Range& b) {
        return a.begin != b.begin ? a.begin < b.begin : a.place < b.place;
    });
    for (std::size_t k = 1; k < count; ++k)
        if (ranges[k].begin < ranges[k - 1].end) return bad_index(ranges[k].place, "the layer overlaps another one");
    return {};
}

/// Names are unique within a chart. Sorted copies, so that thousands of layers stay cheap.
Result<void> check_names(const AssetImpl& asset) noexcept {
    Array<const LayerInfo*> order;
    if (!order.allocate(asset.allocator, asset.layers.size()))
        return Error{ErrorCode::OutOfMemory, kNoOffset, "no memory for the index"};
    for (std::size_t k = 0; k < asset.layers.size(); ++k) order[k] = &asset.layers[k];
    const auto compare = [](const LayerInfo* a, const LayerInfo* b) {
        return a->record.chart != b->record.chart ? (a->record.chart < b->record.chart ? -1 : 1)
                                                  : std::memcmp(a->record.name, b->record.name, sizeof a->record.name);
    };
    std::sort(order.begin(), order.end(), [&](const LayerInfo* a, const LayerInfo* b) {
        const int order_of = compare(a, b);
        return order_of != 0 ? order_of < 0 : a->record_offset < b->record_offset;
    });
    for (std::size_t k = 1; k < order.size(); ++k)
        if (compare(order[k - 1], order[k]) == 0) return bad_index(order[k]->record_offset, "a layer stands twice");
    return {};
}
}  // namespace

Result<void> read_index(AssetImpl& asset, const OpenOptions& options) noexcept {
    if (auto r = read_header(asset); !r) return r;
    const FileHeader& header = asset.header;
    if (auto r = check_index_range(header, options); !r) return r;
    const std::byte* records = asset.bytes.data() + header.index_offset;
    if (!same(hash_bytes(records, static_cast<std::size_t>(header.index_bytes)), header.index_hash))
        return Error{ErrorCode::HashMismatch, offsetof(FileHeader, index_hash), "the index differs from its hash"};
    if (!asset.charts.allocate(asset.allocator, header.chart_count) ||
        !asset.layers.allocate(asset.allocator, header.layer_count))
        return Error{ErrorCode::OutOfMemory, kNoOffset, "no memory for the index"};

    std::uint64_t layer = 0;
    const std::uint64_t layers_at = header.index_offset + header.chart_count * std::uint64_t{sizeof(ChartRecord)};
    for (std::uint32_t k = 0; k < header.chart_count; ++k) {
        const std::uint64_t at = header.index_offset + k * std::uint64_t{sizeof(ChartRecord)};
        ChartInfo& chart = asset.charts[k];
        std::memcpy(&chart.record, asset.bytes.data() + at, sizeof(ChartRecord));
        std::memcpy(chart.method, chart.record.method, sizeof chart.record.method);
        chart.method[16] = 0;
        if (auto r = check_chart(chart.record, at, layer, asset, options); !r) return r;
        for (std::uint32_t l = 0; l < chart.record.layer_count; ++l, ++layer) {
            LayerInfo& info = asset.layers[static_cast<std::size_t>(layer)];
            info.record_offset = layers_at + layer * sizeof(LayerRecord);
            std::memcpy(&info.record, asset.bytes.data() + info.record_offset, sizeof(LayerRecord));
            if (auto r = check_layer_record(info.record, info.record_offset, k, header); !r) return r;
            if (auto r = check_layer(chart.record, info); !r) return r;
        }
    }
    if (layer != header.layer_count)
        return bad_index(offsetof(FileHeader, layer_count), "some layers belong to no chart");
    if (auto r = check_overlaps(asset); !r) return r;
    return check_names(asset);
}

}  // namespace dgm::detail
