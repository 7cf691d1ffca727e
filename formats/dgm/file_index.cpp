// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/file_index.cpp
#include "dgm/file_index.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <set>

#include "dgm/hash.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
using layout::FileHeader;
using layout::LayerRecord;

bool has_magic(const RawFile& raw) {
    return raw.contains(0, sizeof layout::kMagic) &&
           std::memcmp(raw.read(0, sizeof layout::kMagic).data(), layout::kMagic, sizeof layout::kMagic) == 0;
}

bool check_header(const FileHeader& header, bool hash_fits, const RawFile& raw, FindingList& findings) {
    const bool newer = header.format_version > layout::kFormatVersion;
    // A newer format may keep its hash elsewhere, and then has another header size.
    if (newer && (hash_fits || header.header_bytes != sizeof header)) {
        findings.add(codes::kBadVersion,
                     "format version " + std::to_string(header.format_version) + "; this tool reads up to " +
                         std::to_string(layout::kFormatVersion),
                     "user block", header.format_version, layout::kFormatVersion);
        return false;
    }
    if (!hash_fits) {
        findings.add(codes::kHashMismatch, "the header differs from its hash", "user block");
        return false;
    }
    if (header.format_version == 0 || header.header_bytes != sizeof header) {
        findings.add(codes::kBadIndex, "impossible version or header size", "user block");
        return false;
    }
    if (header.file_bytes != raw.size()) {
        const bool shorter = raw.size() < header.file_bytes;
        findings.add(shorter ? codes::kTruncated : codes::kBadIndex,
                     "the file has " + std::to_string(raw.size()) + " bytes, its index says " +
                         std::to_string(header.file_bytes),
                     "user block", static_cast<double>(raw.size()), static_cast<double>(header.file_bytes));
        return false;
    }
    return true;
}

std::optional<FileHeader> read_header(const RawFile& raw, FindingList& findings) {
    if (!has_magic(raw)) {
        findings.add(codes::kNotDgm, raw.size() == 0 ? "the file is empty" : "no DGM index at the start of the file",
                     "user block");
        return std::nullopt;
    }
    if (!raw.contains(0, layout::kUserBlockBytes)) {
        findings.add(codes::kTruncated, std::to_string(raw.size()) + " bytes are less than the user block",
                     "user block", static_cast<double>(raw.size()), static_cast<double>(layout::kUserBlockBytes));
        return std::nullopt;
    }
    FileHeader header{};
    const std::vector<std::byte> bytes = raw.read(0, sizeof header);
    std::memcpy(&header, bytes.data(), sizeof header);
    const Hash128 hash = hash_bytes(std::span(bytes).first(offsetof(FileHeader, header_hash)));
    const bool hash_fits = std::equal(hash.begin(), hash.end(), header.header_hash);
    if (!check_header(header, hash_fits, raw, findings)) return std::nullopt;
    return header;
}

/// The records as bytes that fit their hash; nothing if they cannot be had.
std::optional<std::vector<std::byte>> read_records(const RawFile& raw, const DgmReadLimits& limits,
                                                   const FileIndex& file, FindingList& findings) {
    const FileHeader& header = file.header;
    if (header.chart_count > limits.max_charts || header.layer_count > limits.max_layers) {
        findings.add(codes::kBadIndex, "too many charts or layers", "user block");
        return std::nullopt;
    }
    const std::uint64_t bytes = index_bytes(header.chart_count, header.layer_count);
    const bool placed = file.in_user_block() ? bytes <= layout::kUserBlockBytes - sizeof header
                                             : header.index_offset >= layout::kUserBlockBytes &&
                                                   raw.contains(header.index_offset, bytes);
    if (header.index_bytes != bytes || !placed) {
        findings.add(codes::kBadIndex, "size or place of the records is impossible", "user block");
        return std::nullopt;
    }
    std::vector<std::byte> records = raw.read(header.index_offset, bytes);
    const Hash128 hash = hash_bytes(records);
    if (!std::equal(hash.begin(), hash.end(), header.index_hash)) {
        findings.add(codes::kHashMismatch, "the records differ from their hash",
                     file.in_user_block() ? "user block" : "/index");
        return std::nullopt;
    }
    return records;
}

/// Whether the bytes that the format leaves open in the user block are 0; those of chart records are findings alone.
bool check_padding(const RawFile& raw, const FileIndex& file, FindingList& findings) {
    const std::uint64_t used = sizeof file.header + (file.in_user_block() ? file.header.index_bytes : 0);
    const std::vector<std::byte> tail = raw.read(used, layout::kUserBlockBytes - used);
    const auto stray = std::find_if(tail.begin(), tail.end(), [](std::byte b) { return b != std::byte{0}; });
    if (stray != tail.end())
        findings.add(codes::kBadIndex, "the user block holds bytes behind the index that are not 0",
                     "user block byte " + std::to_string(used + static_cast<std::uint64_t>(stray - tail.begin())));
    for (std::size_t k = 0; k < file.index.charts.size(); ++k) {
        const auto& reserved = file.index.charts[k].reserved;
        if (std::any_of(std::begin(reserved), std::end(reserved), [](std::uint8_t b) { return b != 0; }))
            findings.add(codes::kBadIndex, "reserved bytes of the chart's record are not 0", h5_place(k));
    }
    return stray == tail.end();
}

bool check_charts(const Index& index, FindingList& findings) {
    const std::size_t before = findings.size();
    std::uint64_t next = 0;
    for (std::size_t k = 0; k < index.charts.size(); ++k) {
        const layout::ChartRecord& chart = index.charts[k];
        if (const std::string complaint = chart_complaint(chart); !complaint.empty())
            findings.add(codes::kBadIndex, complaint, h5_place(k));
        if (chart.first_layer != next || chart.layer_count > index.layers.size() - next) {
            findings.add(codes::kBadIndex, "the chart's layers do not follow the chart's before it", h5_place(k));
            return false;
        }
        next += chart.layer_count;
    }
    if (next != index.layers.size()) findings.add(codes::kBadIndex, "layers that belong to no chart", "user block");
    return findings.size() == before;
}

/// Whether the layer lies in the file, outside of the user block, at a multiple of the alignment.
void check_place(const LayerRecord& layer, const RawFile& raw, const std::string& place, FindingList& findings) {
    if (layer.offset % layout::kMinAlignment != 0)
        findings.add(codes::kBadAlignment, "the layer starts at byte " + std::to_string(layer.offset), place,
                     static_cast<double>(layer.offset % layout::kMinAlignment), 0);
    if (layer.offset < layout::kUserBlockBytes)
        findings.add(codes::kBadIndex, "the layer starts inside the user block", place,
                     static_cast<double>(layer.offset), static_cast<double>(layout::kUserBlockBytes));
    if (!raw.contains(layer.offset, layer.bytes))
        findings.add(codes::kTruncated, "the layer ends beyond the file", place, static_cast<double>(layer.offset),
                     static_cast<double>(raw.size()));
}

/// Where a layer is, for a finding: by its name, or by its number if that cannot be read.
std::string layer_place(const Index& index, std::size_t number) {
    const LayerRecord& layer = index.layers[number];
    return h5_place(layer.chart, field_text(layer.name).value_or("layer " + std::to_string(number)));
}

class LayerCheck {
 public:
    LayerCheck(const Index& index, const RawFile& raw, const DgmReadLimits& limits, FindingList& findings)
        : index_(index), raw_(raw), limits_(limits), findings_(findings) {}

    void check_chart(std::size_t c) {
        const layout::ChartRecord& chart = index_.charts[c];
        std::set<std::string> names;
        for (std::size_t l = chart.first_layer; l < std::size_t{chart.first_layer} + chart.layer_count; ++l) {
            const LayerRecord& layer = index_.layers[l];
            const auto name = field_text(layer.name);
            const std::string place = h5_place(c, name.value_or("layer " + std::to_string(l)));
            if (!name || !names.insert(*name).second)
                findings_.add(codes::kBadIndex, "the layer's name is not clean text, or used twice", place);
            check_layer(layer, c, name.value_or(std::string()), place);
            if (layer.bytes > 0) starts_.emplace_back(layer.offset, l);
        }
    }

    /// Reports the first layer, by offset, that begins before the one in front of it ends.
    void check_overlap() {
        std::sort(starts_.begin(), starts_.end());
        for (std::size_t k = 0; k + 1 < starts_.size(); ++k) {
            if (index_.layers[starts_[k].second].bytes <= starts_[k + 1].first - starts_[k].first) continue;
            findings_.add(codes::kLayersOverlap,
                          "shares bytes with " + layer_place(index_, starts_[k].second) + " from byte " +
                              std::to_string(starts_[k + 1].first) + " on",
                          layer_place(index_, starts_[k + 1].second));
            return;
        }
    }

 private:
    void check_layer(const LayerRecord& layer, std::size_t chart, const std::string& name, const std::string& place) {
        if (layer.chart != chart) findings_.add(codes::kBadIndex, "the record names another chart", place);
        if (layer.rank == 0 || layer.rank > layout::kMaxRank) {
            findings_.add(codes::kBadIndex, "rank " + std::to_string(layer.rank), place);
            return;
        }
        const std::span<const std::uint64_t> shape(layer.shape, layer.rank);
        const auto type = static_cast<layout::ElementType>(layer.type);
        const auto bytes = layer_bytes(type, shape);
        const bool tail_is_zero =
            std::all_of(layer.shape + layer.rank, std::end(layer.shape), [](auto s) { return s == 0; });
        if (!bytes || *bytes != layer.bytes || !tail_is_zero) {
            findings_.add(codes::kBadIndex, "type, shape and byte length disagree", place);
            return;
        }
        if (layer.bytes > limits_.max_layer_bytes)
            findings_.add(codes::kBadIndex, "the layer is too large for this tool", place);
        check_place(layer, raw_, place, findings_);
        if (const std::string complaint = shape_complaint(index_.charts[chart], name, type, shape); !complaint.empty())
            findings_.add(codes::kBadLayerShape, complaint, place);
        if ((layer.flags & layout::kLayerRequired) != 0 && !name.empty() && !is_known_layer(name))
            findings_.add(codes::kUnknownLayer, "the layer is marked as required", place);
    }

    const Index& index_;
    const RawFile& raw_;
    const DgmReadLimits& limits_;
    FindingList& findings_;
    std::vector<std::pair<std::uint64_t, std::size_t>> starts_;  // offset and number of each layer with bytes
};

bool check_layers(const Index& index, const RawFile& raw, const DgmReadLimits& limits, FindingList& findings) {
    const std::size_t before = findings.size();
    LayerCheck check(index, raw, limits, findings);
    for (std::size_t c = 0; c < index.charts.size(); ++c) check.check_chart(c);
    if (findings.size() == before) check.check_overlap();
    return findings.size() == before;
}

}  // namespace

std::optional<FileIndex> read_file_index(const RawFile& raw, const DgmReadLimits& limits, FindingList& findings) {
    const auto header = read_header(raw, findings);
    if (!header) return std::nullopt;
    FileIndex file{*header, {}};
    const auto records = read_records(raw, limits, file, findings);
    if (!records) return std::nullopt;
    file.index = decode_records(*records, header->chart_count, header->layer_count);
    if (!check_padding(raw, file, findings) || !check_charts(file.index, findings) ||
        !check_layers(file.index, raw, limits, findings))
        return std::nullopt;
    return file;
}

}  // namespace dgm::formats
