// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/dgm_reader.cpp
// One walk over the file serves all entry points: read_dgm stops at the first finding, the others go on and keep the
// findings. The index is checked on the raw bytes first; HDF5 sees the file only once header, index and all hashes are
// good, and then has to agree with the index.
#include "dgm/dgm_reader.h"

#include <algorithm>
#include <cstring>
#include <set>

#include "dgm/h5_file.h"
#include "dgm/hash.h"
#include "dgm/index.h"
#include "dgm/raw_file.h"
#include "model/layer_names.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using layout::FileHeader;
using layout::LayerRecord;

constexpr std::size_t kMaxFindings = 100;
constexpr std::uint64_t kMaxReportBytes = std::uint64_t{256} << 20;

/// Thrown to leave the walk once there are enough findings.
struct EnoughFindings {};

class Walk {
 public:
    /// @param throws  the first finding, rather than collecting them
    Walk(const fs::path& path, const DgmReadLimits& limits, bool throws)
        : path_(path), limits_(limits), throws_(throws), raw_(path) {}

    FileFindings run(model::MapSet* out) {
        maps_ = out;
        try {
            if (read_header() && read_index() && check_charts() && check_layers()) {
                const std::size_t before = findings_.size();
                read_layers();
                check_rest();
                if (findings_.size() == before) walk_hdf5();
            }
        } catch (const EnoughFindings&) {
        } catch (const model::Error& error) {
            if (error.place().starts_with(path_.string())) throw;
            throw model::Error(error.code(), error.what(), path_.string() + ": " + error.place());
        }
        return std::move(findings_);
    }

 private:
    void add(const model::Code& code, std::string message, std::string place,
             std::optional<double> measured = std::nullopt, std::optional<double> limit = std::nullopt) {
        if (throws_) throw model::Error(code, std::move(message), std::move(place));
        findings_.push_back({&code, Severity::kError, std::move(message), std::move(place), measured, limit});
        if (findings_.size() >= kMaxFindings) throw EnoughFindings();
    }

    bool read_header() {
        if (!raw_.contains(0, sizeof layout::kMagic) ||
            std::memcmp(raw_.read(0, sizeof layout::kMagic).data(), layout::kMagic, sizeof layout::kMagic) != 0) {
            add(codes::kNotDgm, raw_.size() == 0 ? "the file is empty" : "no DGM index at the start of the file",
                "user block");
            return false;
        }
        if (!raw_.contains(0, layout::kUserBlockBytes)) {
            add(codes::kTruncated, std::to_string(raw_.size()) + " bytes are less than the user block", "user block",
                static_cast<double>(raw_.size()), static_cast<double>(layout::kUserBlockBytes));
            return false;
        }
        const std::vector<std::byte> bytes = raw_.read(0, sizeof header_);
        std::memcpy(&header_, bytes.data(), sizeof header_);
        const Hash128 hash = hash_bytes(std::span(bytes).first(offsetof(FileHeader, header_hash)));
        const bool hash_fits = std::equal(hash.begin(), hash.end(), header_.header_hash);
        const bool newer = header_.format_version > layout::kFormatVersion;
        // A newer format may keep its hash elsewhere, and then has another header size.
        if (newer && (hash_fits || header_.header_bytes != sizeof header_)) {
            add(codes::kBadVersion,
                "format version " + std::to_string(header_.format_version) + "; this tool reads up to " +
                    std::to_string(layout::kFormatVersion),
                "user block", header_.format_version, layout::kFormatVersion);
            return false;
        }
        if (!hash_fits) {
            add(codes::kHashMismatch, "the header differs from its hash", "user block");
            return false;
        }
        if (header_.format_version == 0 || header_.header_bytes != sizeof header_) {
            add(codes::kBadIndex, "impossible version or header size", "user block");
            return false;
        }
        if (header_.file_bytes != raw_.size()) {
            const bool shorter = raw_.size() < header_.file_bytes;
            add(shorter ? codes::kTruncated : codes::kBadIndex,
                "the file has " + std::to_string(raw_.size()) + " bytes, its index says " +
                    std::to_string(header_.file_bytes),
                "user block", static_cast<double>(raw_.size()), static_cast<double>(header_.file_bytes));
            return false;
        }
        return true;
    }

    bool read_index() {
        if (header_.chart_count > limits_.max_charts || header_.layer_count > limits_.max_layers) {
            add(codes::kBadIndex, "too many charts or layers", "user block");
            return false;
        }
        const std::uint64_t bytes = index_bytes(header_.chart_count, header_.layer_count);
        const bool in_block = header_.index_offset == sizeof header_;
        const bool placed =
            in_block ? bytes <= layout::kUserBlockBytes - sizeof header_
                     : header_.index_offset >= layout::kUserBlockBytes && raw_.contains(header_.index_offset, bytes);
        if (header_.index_bytes != bytes || !placed) {
            add(codes::kBadIndex, "size or place of the records is impossible", "user block");
            return false;
        }
        const std::vector<std::byte> records = raw_.read(header_.index_offset, bytes);
        const Hash128 hash = hash_bytes(records);
        if (!std::equal(hash.begin(), hash.end(), header_.index_hash)) {
            add(codes::kHashMismatch, "the records differ from their hash", in_block ? "user block" : "/index");
            return false;
        }
        index_ = decode_records(records, header_.chart_count, header_.layer_count);
        const std::uint64_t used = sizeof header_ + (in_block ? bytes : 0);
        const std::vector<std::byte> tail = raw_.read(used, layout::kUserBlockBytes - used);
        const auto stray = std::find_if(tail.begin(), tail.end(), [](std::byte b) { return b != std::byte{0}; });
        if (stray != tail.end())
            add(codes::kBadIndex, "the user block holds bytes behind the index that are not 0",
                "user block byte " + std::to_string(used + static_cast<std::uint64_t>(stray - tail.begin())));
        for (std::size_t k = 0; k < index_.charts.size(); ++k)
            if (std::any_of(std::begin(index_.charts[k].reserved), std::end(index_.charts[k].reserved),
                            [](std::uint8_t b) { return b != 0; }))
                add(codes::kBadIndex, "reserved bytes of the chart's record are not 0", h5_place(k));
        return stray == tail.end();
    }

    bool check_charts() {
        const std::size_t before = findings_.size();
        std::uint64_t next = 0;
        for (std::size_t k = 0; k < index_.charts.size(); ++k) {
            const layout::ChartRecord& chart = index_.charts[k];
            if (const std::string complaint = chart_complaint(chart); !complaint.empty())
                add(codes::kBadIndex, complaint, h5_place(k));
            if (chart.first_layer != next || chart.layer_count > index_.layers.size() - next) {
                add(codes::kBadIndex, "the chart's layers do not follow the chart's before it", h5_place(k));
                return false;
            }
            next += chart.layer_count;
        }
        if (next != index_.layers.size()) add(codes::kBadIndex, "layers that belong to no chart", "user block");
        return findings_.size() == before;
    }

    bool check_layers() {
        const std::size_t before = findings_.size();
        std::vector<std::pair<std::uint64_t, std::size_t>> places;
        for (std::size_t c = 0; c < index_.charts.size(); ++c) {
            const layout::ChartRecord& chart = index_.charts[c];
            std::set<std::string> names;
            for (std::size_t l = chart.first_layer; l < std::size_t{chart.first_layer} + chart.layer_count; ++l) {
                const LayerRecord& layer = index_.layers[l];
                const auto name = field_text(layer.name);
                const std::string place = h5_place(c, name.value_or("layer " + std::to_string(l)));
                if (!name || !names.insert(*name).second)
                    add(codes::kBadIndex, "the layer's name is not clean text, or used twice", place);
                check_layer(layer, c, name.value_or(std::string()), place);
                if (layer.bytes > 0) places.emplace_back(layer.offset, l);
            }
        }
        std::sort(places.begin(), places.end());
        for (std::size_t k = 0; k + 1 < places.size() && findings_.size() == before; ++k)
            if (index_.layers[places[k].second].bytes > places[k + 1].first - places[k].first)
                add(codes::kLayersOverlap,
                    "shares bytes with " + layer_place(places[k].second) + " from byte " +
                        std::to_string(places[k + 1].first) + " on",
                    layer_place(places[k + 1].second));
        return findings_.size() == before;
    }

    void check_layer(const LayerRecord& layer, std::size_t chart, const std::string& name, const std::string& place) {
        if (layer.chart != chart) add(codes::kBadIndex, "the record names another chart", place);
        if (layer.rank == 0 || layer.rank > layout::kMaxRank) {
            add(codes::kBadIndex, "rank " + std::to_string(layer.rank), place);
            return;
        }
        const std::span<const std::uint64_t> shape(layer.shape, layer.rank);
        const auto type = static_cast<layout::ElementType>(layer.type);
        const auto bytes = layer_bytes(type, shape);
        const bool tail_is_zero =
            std::all_of(layer.shape + layer.rank, std::end(layer.shape), [](auto s) { return s == 0; });
        if (!bytes || *bytes != layer.bytes || !tail_is_zero) {
            add(codes::kBadIndex, "type, shape and byte length disagree", place);
            return;
        }
        if (layer.bytes > limits_.max_layer_bytes) add(codes::kBadIndex, "the layer is too large for this tool", place);
        if (layer.offset % layout::kMinAlignment != 0)
            add(codes::kBadAlignment, "the layer starts at byte " + std::to_string(layer.offset), place,
                static_cast<double>(layer.offset % layout::kMinAlignment), 0);
        if (layer.offset < layout::kUserBlockBytes)
            add(codes::kBadIndex, "the layer starts inside the user block", place, static_cast<double>(layer.offset),
                static_cast<double>(layout::kUserBlockBytes));
        if (!raw_.contains(layer.offset, layer.bytes))
            add(codes::kTruncated, "the layer ends beyond the file", place, static_cast<double>(layer.offset),
                static_cast<double>(raw_.size()));
        if (const std::string complaint = shape_complaint(index_.charts[chart], name, type, shape); !complaint.empty())
            add(codes::kBadLayerShape, complaint, place);
        if ((layer.flags & layout::kLayerRequired) != 0 && !name.empty() && !is_known_layer(name))
            add(codes::kUnknownLayer, "the layer is marked as required", place);
    }

    [[nodiscard]] std::string layer_place(std::size_t number) const {
        const LayerRecord& layer = index_.layers[number];
        return h5_place(layer.chart, field_text(layer.name).value_or("layer " + std::to_string(number)));
    }

    /// Damage to HDF5's own structures is found here, before HDF5 sees them. Files of other writers may lack the hash.
    void check_rest() {
        if (std::all_of(std::begin(header_.rest_hash), std::end(header_.rest_hash), [](auto b) { return b == 0; }))
            return;
        constexpr std::uint64_t kBlock = std::uint64_t{1} << 20, kMost = std::uint64_t{1} << 30;
        const auto ranges = ranges_beside_layers(index_, raw_.size());
        std::uint64_t bytes = 0;
        for (const auto& [begin, end] : ranges) bytes += end - begin;
        if (bytes > kMost) {  // a sparse file may claim terabytes that no one wrote
            add(codes::kBadIndex, "the file is mostly not layers", "/", static_cast<double>(bytes),
                static_cast<double>(kMost));
            return;
        }
        Hasher hasher;
        for (auto [begin, end] : ranges)
            for (; begin < end; begin += std::min(kBlock, end - begin))
                hasher.add(raw_.read(begin, std::min(kBlock, end - begin)));
        const Hash128 hash = hasher.result();
        if (!std::equal(hash.begin(), hash.end(), header_.rest_hash))
            add(codes::kHashMismatch, "HDF5's own structures, or the report, differ from their hash", "/");
    }

    void read_layers() {
        if (maps_ != nullptr) fill_charts();
        for (const LayerRecord& record : index_.layers) {
            std::vector<std::byte> bytes = raw_.read(record.offset, record.bytes);
            const Hash128 hash = hash_bytes(bytes);
            const std::string name = field_text(record.name).value_or(std::string());
            if (!std::equal(hash.begin(), hash.end(), record.hash))
                add(codes::kHashMismatch, "the layer's bytes differ from their hash", h5_place(record.chart, name));
            if (maps_ == nullptr) continue;
            model::Layer& layer = maps_->charts[record.chart].layers.emplace_back();
            layer.name = name;
            layer.type = static_cast<layout::ElementType>(record.type);
            layer.shape.assign(record.shape, record.shape + record.rank);
            layer.bytes = std::move(bytes);
            layer.required = (record.flags & layout::kLayerRequired) != 0;
        }
    }

    void fill_charts() {
        maps_->format_version = header_.format_version;
        std::copy(std::begin(header_.source_hash), std::end(header_.source_hash), maps_->source_hash.begin());
        std::copy(std::begin(header_.settings_hash), std::end(header_.settings_hash), maps_->settings_hash.begin());
        for (const layout::ChartRecord& record : index_.charts) {
            model::Chart& chart = maps_->charts.emplace_back();
            chart.rows = record.rows;
            chart.cols = record.cols;
            chart.domain = static_cast<layout::Domain>(record.domain);
            chart.method = field_text(record.method).value_or(std::string());
            std::copy(std::begin(record.bbox), std::end(record.bbox), chart.bbox.begin());
            std::copy(std::begin(record.offset), std::end(record.offset), chart.offset.begin());
            std::copy(std::begin(record.scale), std::end(record.scale), chart.scale.begin());
        }
    }

    // HDF5 ----------------------------------------------------------------------------------------------------------

    void walk_hdf5() {
        const H5Session session;
        try {
            H5Check check{codes::kHdf5Unreadable, "/"};
            const H5Handle access = check.handle(H5Pcreate(H5P_FILE_ACCESS), "make a property list");
            const H5Handle file = check.handle(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, access), "open the file");
            check_root(file);
            const H5Handle charts = open_child(file, "charts", "/charts", H5I_GROUP);
            count_links(charts, index_.charts.size(), "/charts");
            for (std::size_t k = 0; k < index_.charts.size(); ++k) check_chart(charts, k);
            read_report(file);
        } catch (const model::Error& error) {
            if (throws_) throw;
            add(error.code(), error.what(), error.place());
        }
    }

    /// Opens a child through a hard link alone: soft and external links could lead anywhere.
    static H5Handle open_child(hid_t parent, const std::string& name, const std::string& place, H5I_type_t kind) {
        const H5Check check{codes::kHdf5Unreadable, place};
        H5L_info_t link;
        if (H5Lexists(parent, name.c_str(), H5P_DEFAULT) <= 0 ||
            H5Lget_info(parent, name.c_str(), &link, H5P_DEFAULT) < 0)
            check.fail("find it");
        if (link.type != H5L_TYPE_HARD) throw model::Error(codes::kForeignStorage, "a soft or external link", place);
        H5Handle object = check.handle(H5Oopen(parent, name.c_str(), H5P_DEFAULT), "open it");
        if (H5Iget_type(object) != kind) throw model::Error(codes::kIndexDiffers, "an object of another kind", place);
        return object;
    }

    void count_links(hid_t group, std::size_t expected, const std::string& place) {
        H5G_info_t info;
        if (H5Gget_info(group, &info) < 0 || info.nlinks != expected)
            add(codes::kUnknownObject, "the group does not hold what the index lists, and that alone", place,
                static_cast<double>(info.nlinks), static_cast<double>(expected));
    }

    void count_attributes(hid_t object, hsize_t expected, const std::string& place) {
        H5O_info_t info;
        if (H5Oget_info2(object, &info, H5O_INFO_NUM_ATTRS) < 0)
            H5Check{codes::kHdf5Unreadable, place}.fail("count its attributes");
        if (info.num_attrs != expected)
            add(codes::kUnknownObject, "not the attributes of the format, and those alone", place,
                static_cast<double>(info.num_attrs), static_cast<double>(expected));
    }

    void check_times(hid_t object, const std::string& place) {
        H5O_info_t info;
        if (H5Oget_info2(object, &info, H5O_INFO_TIME) < 0)
            H5Check{codes::kHdf5Unreadable, place}.fail("read its times");
        if (info.atime != 0 || info.mtime != 0 || info.ctime != 0 || info.btime != 0)
            add(codes::kNotReproducible, "the object carries the time of its making", place);
    }

    template <class Value>
    Value expect(hid_t object, const char* name, const std::string& place) {
        const H5Check check{codes::kBadAttribute, place};
        model::AttributeValue value = read_attribute(object, name, check);
        if (auto* typed = std::get_if<Value>(&value)) return std::move(*typed);
        check.fail((std::string("read attribute ") + name).c_str());
    }
    template <class Value>
    void compare(hid_t object, const char* name, const Value& wanted, const std::string& place) {
        // Bytes, not ==: attributes may hold NaN or -0 as long as both sides have the same.
        const Value found = expect<Value>(object, name, place);
        const bool same =
            found.size() == wanted.size() &&
            (found.empty() || std::memcmp(found.data(), wanted.data(), found.size() * sizeof found[0]) == 0);
        if (!same) add(codes::kIndexDiffers, std::string("attribute ") + name + " differs from the index", place);
    }

    void check_root(hid_t file) {
        using std::string;
        compare(file, "format_version", std::vector{header_.format_version}, "/");
        Hash128 source, settings;
        std::copy(std::begin(header_.source_hash), std::end(header_.source_hash), source.begin());
        std::copy(std::begin(header_.settings_hash), std::end(header_.settings_hash), settings.begin());
        compare(file, "source_hash", to_hex(source), "/");
        compare(file, "settings_hash", to_hex(settings), "/");
        string generator = expect<string>(file, "generator", "/"),
               source_name = expect<string>(file, "source_name", "/");
        count_attributes(file, 5, "/");
        count_links(file, header_.index_offset == sizeof header_ ? 2 : 3, "/");
        check_times(file, "/");
        if (source_name.find_first_of("/\\") != string::npos)
            add(codes::kNotReproducible, "source_name holds a folder: " + source_name, "/");
        if (maps_ == nullptr) return;
        maps_->generator = std::move(generator);
        maps_->source_name = std::move(source_name);
    }

    void check_chart(hid_t charts, std::size_t number) {
        const std::string place = h5_place(number);
        const layout::ChartRecord& record = index_.charts[number];
        const H5Handle group = open_child(charts, std::to_string(number), place, H5I_GROUP);
        const bool is_free = record.domain == static_cast<std::uint32_t>(layout::Domain::kFree);
        compare(group, "domain", std::string(is_free ? "free" : "square"), place);
        compare(group, "method", field_text(record.method).value_or(std::string()), place);
        compare(group, "rows", std::vector{record.rows}, place);
        compare(group, "cols", std::vector{record.cols}, place);
        compare(group, "bbox", std::vector<double>(std::begin(record.bbox), std::end(record.bbox)), place);
        count_attributes(group, 5, place);
        check_times(group, place);
        count_links(group, record.layer_count, place);
        for (std::uint32_t k = 0; k < record.layer_count; ++k) check_dataset(group, number, k);
    }

    void check_dataset(hid_t group, std::size_t number, std::uint32_t k) {
        const layout::ChartRecord& chart = index_.charts[number];
        const LayerRecord& record = index_.layers[chart.first_layer + k];
        const std::string name = field_text(record.name).value_or(std::string());
        const std::string place = h5_place(number, name);
        const H5Check check{codes::kHdf5Unreadable, place};
        const H5Handle set = open_child(group, name, place, H5I_DATASET);
        const H5Handle creation = check.handle(H5Dget_create_plist(set), "read its properties");
        if (H5Pget_layout(creation) != H5D_CONTIGUOUS || H5Pget_nfilters(creation) != 0 ||
            H5Pget_external_count(creation) != 0) {
            add(codes::kForeignStorage, "the dataset is chunked, filtered, virtual or stored outside the file", place);
            return;
        }
        check_times(set, place);
        const H5Handle space = check.handle(H5Dget_space(set), "read its shape");
        std::vector<hsize_t> extent(record.rank);
        const int rank = H5Sget_simple_extent_ndims(space);
        const bool same_shape = rank == static_cast<int>(record.rank) &&
                                H5Sget_simple_extent_dims(space, extent.data(), nullptr) == rank &&
                                std::equal(extent.begin(), extent.end(), record.shape);
        if (!same_shape) add(codes::kIndexDiffers, "HDF5 and the index disagree on the shape", place);
        const H5Handle type = check.handle(H5Dget_type(set), "read its type");
        const H5Handle wanted = h5_element_type(static_cast<layout::ElementType>(record.type), check);
        if (H5Tequal(type, wanted) <= 0)
            add(codes::kIndexDiffers, "HDF5 and the index disagree on the element type", place);
        if (record.bytes > 0) {
            const haddr_t offset = H5Dget_offset(set);
            if (offset != record.offset)
                add(codes::kIndexDiffers,
                    "HDF5 has the bytes at " + std::to_string(offset) + ", the index at " +
                        std::to_string(record.offset),
                    place, static_cast<double>(record.offset), static_cast<double>(offset));
        }
        const bool is_geometry = name == model::layers::kGeometry;
        if (is_geometry) {
            compare(set, "offset", std::vector<double>(std::begin(chart.offset), std::end(chart.offset)), place);
            compare(set, "scale", std::vector<double>(std::begin(chart.scale), std::end(chart.scale)), place);
        }
        if (maps_ != nullptr) read_layer_attributes(set, maps_->charts[number].layers[k], is_geometry, place);
    }

    static void read_layer_attributes(hid_t set, model::Layer& layer, bool is_geometry, const std::string& place) {
        const H5Check check{codes::kHdf5Unreadable, place};
        std::vector<std::string> names;
        hsize_t position = 0;
        const auto collect = [](hid_t, const char* name, const H5A_info_t*, void* out) -> herr_t {
            auto& list = *static_cast<std::vector<std::string>*>(out);
            list.emplace_back(name);
            return list.size() < 1000 ? 0 : -1;
        };
        check.done(H5Aiterate2(set, H5_INDEX_NAME, H5_ITER_INC, &position, collect, &names), "list its attributes");
        for (const std::string& name : names)
            if (!is_geometry || (name != "offset" && name != "scale"))
                layer.attributes.emplace(name, read_attribute(set, name, check));
    }

    void read_report(hid_t file) {
        const H5Check check{codes::kHdf5Unreadable, "/report"};
        const H5Handle set = open_child(file, "report", "/report", H5I_DATASET);
        const H5Handle creation = check.handle(H5Dget_create_plist(set), "read its properties");
        const H5Handle type = check.handle(H5Dget_type(set), "read its type");
        const H5Handle space = check.handle(H5Dget_space(set), "read its shape");
        const std::size_t size = H5Tget_size(type);
        if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 ||
            H5Sget_simple_extent_type(space) != H5S_SCALAR || H5Pget_layout(creation) != H5D_CONTIGUOUS ||
            H5Pget_nfilters(creation) != 0 || H5Pget_external_count(creation) != 0 || size == 0 ||
            size > kMaxReportBytes) {
            add(codes::kForeignStorage, "the report is not one text of fixed length", "/report");
            return;
        }
        const haddr_t offset = H5Dget_offset(set);
        if (offset == HADDR_UNDEF || !raw_.contains(offset, size)) {
            add(codes::kBadIndex, "the report lies outside the file", "/report");
            return;
        }
        const std::vector<std::byte> bytes = raw_.read(offset, size);
        const auto end = std::find(bytes.begin(), bytes.end(), std::byte{0});
        const std::span<const std::byte> text(bytes.data(), static_cast<std::size_t>(end - bytes.begin()));
        if (expect<std::string>(set, "hash", "/report") != to_hex(hash_bytes(text)))
            add(codes::kHashMismatch, "the report differs from its hash", "/report");
        if (maps_ != nullptr) maps_->report_json.assign(reinterpret_cast<const char*>(text.data()), text.size());
    }

    const fs::path& path_;
    const DgmReadLimits& limits_;
    bool throws_;
    RawFile raw_;
    FileHeader header_{};
    Index index_;
    FileFindings findings_;
    model::MapSet* maps_ = nullptr;
};

}  // namespace

model::MapSet read_dgm(const fs::path& path, const DgmReadLimits& limits) {
    model::MapSet maps;
    Walk(path, limits, true).run(&maps);
    return maps;
}

FileFindings check_container(const fs::path& path, const DgmReadLimits& limits) {
    return Walk(path, limits, false).run(nullptr);
}

FileFindings read_and_check(const fs::path& path, model::MapSet& maps, const DgmReadLimits& limits) {
    return Walk(path, limits, false).run(&maps);
}

}  // namespace dgm::formats
