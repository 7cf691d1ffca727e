// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/dgm_writer.cpp
#include "dgm/dgm_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <set>
#include <system_error>

#include "dgm/h5_file.h"
#include "dgm/hash.h"
#include "dgm/index.h"
#include "files/atomic_file.h"
#include "model/layer_names.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::Chart;
using model::Layer;
using model::MapSet;

/// Layers start on pages of their own where that costs little: with so many pages a layer, on average, the padding,
/// half a page a layer, is a thirty-second of the data.
constexpr std::uint64_t kPagesToAlign = 16;
constexpr std::size_t kMaxPagedLayers = 64;  ///< charts by the thousand are packed, whatever they hold

/// HDF5 takes room for its own structures in blocks; the rest of the last one is lost.
constexpr hsize_t kMetadataBlock = 16384, kSmallMetadataBlock = 4096;

/// A chart's group keeps its links in its header, which has room for them and, counted in links, for its attributes
/// from the start: headers that grow leave gaps, among which HDF5 looks for each new one, in time quadratic in charts.
constexpr unsigned kMostLinks = 64, kLinkName = 12, kAttributesInLinks = 14;

[[noreturn]] void refuse(const std::string& message, const std::string& place) {
    throw model::Error(codes::kBadLayerShape, message, place);
}

/// Records of everything but offsets; checks all that the format demands, before a byte is written.
Index plan_index(const MapSet& maps) {
    if (maps.format_version == 0 || maps.format_version > layout::kFormatVersion)
        refuse("format version " + std::to_string(maps.format_version) + " cannot be written", "/");
    Index index;
    for (std::size_t k = 0; k < maps.charts.size(); ++k) {
        const Chart& chart = maps.charts[k];
        layout::ChartRecord record{};
        record.rows = chart.rows;
        record.cols = chart.cols;
        record.domain = static_cast<std::uint32_t>(chart.domain);
        record.first_layer = static_cast<std::uint32_t>(index.layers.size());
        record.layer_count = static_cast<std::uint32_t>(chart.layers.size());
        if (const Layer* border = chart.find(model::layers::kBorderUv); border != nullptr && !border->shape.empty())
            record.border_samples = static_cast<std::uint32_t>(border->shape[0]);
        std::copy(chart.bbox.begin(), chart.bbox.end(), record.bbox);
        std::copy(chart.offset.begin(), chart.offset.end(), record.offset);
        std::copy(chart.scale.begin(), chart.scale.end(), record.scale);
        set_field_text(record.method, chart.method, h5_place(k) + "/method");
        if (const std::string complaint = chart_complaint(record); !complaint.empty()) refuse(complaint, h5_place(k));

        std::set<std::string> names;
        for (const Layer& layer : chart.layers) {
            const std::string place = h5_place(k, layer.name);
            layout::LayerRecord entry{};
            set_field_text(entry.name, layer.name, place);
            if (!names.insert(layer.name).second) refuse("the chart has two layers of this name", place);
            const auto bytes = layer_bytes(layer.type, layer.shape);
            if (!bytes || *bytes != layer.bytes.size())
                refuse(std::to_string(layer.bytes.size()) + " bytes do not fit type and shape", place);
            if (const std::string complaint = shape_complaint(record, layer.name, layer.type, layer.shape);
                !complaint.empty())
                refuse(complaint, place);
            if (layer.name == model::layers::kGeometry &&
                (layer.attributes.contains("offset") || layer.attributes.contains("scale")))
                refuse("offset and scale belong to the chart", place);
            entry.chart = static_cast<std::uint32_t>(k);
            entry.type = static_cast<std::uint32_t>(layer.type);
            entry.rank = static_cast<std::uint32_t>(layer.shape.size());
            entry.flags = layer.required ? layout::kLayerRequired : 0;
            std::copy(layer.shape.begin(), layer.shape.end(), entry.shape);
            entry.bytes = *bytes;
            const Hash128 hash = hash_bytes(layer.bytes);
            std::copy(hash.begin(), hash.end(), entry.hash);
            index.layers.push_back(entry);
        }
        index.charts.push_back(record);
    }
    if (index.charts.size() > DgmReadLimits{}.max_charts || index.layers.size() > DgmReadLimits{}.max_layers)
        refuse("too many charts or layers", "/charts");
    return index;
}

/// The HDF5 part of the file. Creation order, library version bounds and the absence of times make it deterministic.
class H5Writer {
 public:
    /// @param smallest  bytes of the smallest layer that has any
    /// @param all       bytes of all layers together
    H5Writer(const fs::path& path, std::size_t layer_count, std::uint64_t smallest, std::uint64_t all)
        : check_{codes::kWriteFailed, path.string()} {
        const H5Handle creation = untimed(H5P_FILE_CREATE);
        check_.done(H5Pset_userblock(creation, layout::kUserBlockBytes), "set the user block");
        // No H5Pset_file_space_strategy here: any but the default puts an object before the root group that keeps
        // times.
        const H5Handle access = check_.handle(H5Pcreate(H5P_FILE_ACCESS), "make a property list");
        check_.done(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110), "pin the version");
        // HDF5 aligns objects that are at least as large as a threshold, metadata too: below the smallest layer they
        // stay packed.
        const bool paged =
            layer_count <= kMaxPagedLayers && all >= kPagesToAlign * layout::kUserBlockBytes * layer_count;
        check_.done(H5Pset_alignment(access, smallest, paged ? layout::kUserBlockBytes : layout::kMinAlignment),
                    "align");
        check_.done(H5Pset_meta_block_size(access, paged ? kMetadataBlock : kSmallMetadataBlock), "set the block size");
        file_ = check_.handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access), "create the file");

        chart_creation_ = untimed(H5P_GROUP_CREATE);
        check_.done(H5Pset_link_phase_change(chart_creation_, kMostLinks, 0), "keep links in the header");
        dataset_creation_ = untimed(H5P_DATASET_CREATE);
        check_.done(H5Pset_layout(dataset_creation_, H5D_CONTIGUOUS), "set the layout");
        check_.done(H5Pset_alloc_time(dataset_creation_, H5D_ALLOC_TIME_EARLY), "set the allocation time");
        check_.done(H5Pset_fill_time(dataset_creation_, H5D_FILL_TIME_NEVER), "set the fill time");
    }

    void write_root(const MapSet& maps) {
        attribute(file_, "format_version", std::vector{maps.format_version});
        attribute(file_, "generator", maps.generator);
        attribute(file_, "source_name", maps.source_name);
        attribute(file_, "source_hash", to_hex(maps.source_hash));
        attribute(file_, "settings_hash", to_hex(maps.settings_hash));
        charts_ = group(file_, "charts", untimed(H5P_GROUP_CREATE));
    }

    /// Fills in the offsets of the chart's layers.
    void write_chart(const Chart& chart, std::size_t number, std::span<layout::LayerRecord> records) {
        check_.place = h5_place(number);
        const auto links = static_cast<unsigned>(std::min<std::size_t>(chart.layers.size(), kMostLinks));
        check_.done(H5Pset_est_link_info(chart_creation_, links + kAttributesInLinks, kLinkName), "reserve a header");
        const H5Handle target = group(charts_, std::to_string(number), chart_creation_);
        attribute(target, "domain", std::string(chart.domain == model::Domain::kFree ? "free" : "square"));
        attribute(target, "method", chart.method);
        attribute(target, "rows", std::vector{chart.rows});
        attribute(target, "cols", std::vector{chart.cols});
        attribute(target, "bbox", std::vector<double>(chart.bbox.begin(), chart.bbox.end()));
        for (std::size_t k = 0; k < chart.layers.size(); ++k) {
            const Layer& layer = chart.layers[k];
            check_.place = h5_place(number, layer.name);
            const H5Handle set =
                dataset(target, layer.name, h5_element_type(layer.type, check_), layer.shape, layer.bytes);
            records[k].offset = offset_of(set, layer.bytes.size());
            if (layer.name == model::layers::kGeometry) {
                attribute(set, "offset", std::vector<double>(chart.offset.begin(), chart.offset.end()));
                attribute(set, "scale", std::vector<double>(chart.scale.begin(), chart.scale.end()));
            }
            for (const auto& [name, value] : layer.attributes)
                write_attribute(set, name, value, check_, name == "levels" ? 2 : 0);
        }
    }

    void write_report(const std::string& report) {
        check_.place = "/report";
        if (report.find('\0') != std::string::npos) refuse("the report holds a zero byte", check_.place);
        std::string padded = report;
        if (padded.empty()) padded.push_back('\0');
        const H5Handle set =
            dataset(file_, "report", h5_text_type(padded.size(), check_), {}, std::as_bytes(std::span(padded)));
        attribute(set, "hash", to_hex(hash_bytes(std::as_bytes(std::span(report)))));
    }

    /// Dataset for records that do not fit into the user block. @return its absolute offset
    std::uint64_t reserve_index(std::uint64_t bytes) {
        check_.place = "/index";
        const std::vector<std::uint64_t> shape{bytes};
        index_ = create(file_, "index", h5_element_type(layout::ElementType::kU8, check_), shape);
        return offset_of(index_, bytes);
    }
    void write_index(const std::vector<std::byte>& records) {
        check_.done(H5Dwrite(index_, H5T_STD_U8LE, H5S_ALL, H5S_ALL, H5P_DEFAULT, records.data()), "write the index");
    }

    void close() {
        for (H5Handle* handle : {&index_, &charts_, &chart_creation_, &dataset_creation_})
            if (handle->is_valid() && !handle->close()) check_.fail("close an object");
        if (!file_.close()) check_.fail("write the file to its end");
    }

 private:
    /// A property list for the creation of objects that keep no times.
    [[nodiscard]] H5Handle untimed(hid_t kind) const {
        H5Handle out = check_.handle(H5Pcreate(kind), "make a property list");
        check_.done(H5Pset_obj_track_times(out, false), "turn off times");
        return out;
    }

    void attribute(hid_t object, const char* name, const model::AttributeValue& value) {
        write_attribute(object, name, value, check_);
    }

    H5Handle group(hid_t parent, const std::string& name, const H5Handle& creation) {
        return check_.handle(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), "create a group");
    }

    H5Handle create(hid_t parent, const std::string& name, const H5Handle& type, std::span<const std::uint64_t> shape) {
        const std::vector<hsize_t> extent(shape.begin(), shape.end());
        const H5Handle space =
            extent.empty() ? check_.handle(H5Screate(H5S_SCALAR), "make a space")
                           : check_.handle(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr),
                                           "make a space");
        return check_.handle(H5Dcreate2(parent, name.c_str(), type, space, H5P_DEFAULT, dataset_creation_, H5P_DEFAULT),
                             "create a dataset (is the disk full?)");
    }

    H5Handle dataset(hid_t parent, const std::string& name, const H5Handle& type, std::span<const std::uint64_t> shape,
                     std::span<const std::byte> bytes) {
        H5Handle set = create(parent, name, type, shape);
        if (!bytes.empty())
            check_.done(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()),
                        "write a dataset (is the disk full?)");
        return set;
    }

    /// Place of a dataset in the file, counted from its first byte. An empty one has no place: it gets the end of the
    /// user block, which passes every range check.
    std::uint64_t offset_of(const H5Handle& set, std::uint64_t bytes) const {
        if (bytes == 0) return layout::kUserBlockBytes;
        const haddr_t offset = H5Dget_offset(set);
        if (offset == HADDR_UNDEF || offset % layout::kMinAlignment != 0) check_.fail("place a dataset");
        return offset;
    }

    H5Check check_;
    H5Handle file_, charts_, chart_creation_, dataset_creation_, index_;
};

template <std::size_t N>
void set_hash(std::uint8_t (&field)[N], const Hash128& hash) {
    static_assert(N == std::tuple_size_v<Hash128>);
    std::copy(hash.begin(), hash.end(), field);
}

/// The first bytes of the user block: header, and the records if they fit.
std::vector<std::byte> user_block(const MapSet& maps, const std::vector<std::byte>& records, std::uint64_t index_offset,
                                  std::size_t layer_count, std::uint64_t file_bytes, const Hash128& rest_hash) {
    layout::FileHeader header{};
    std::memcpy(header.magic, layout::kMagic, sizeof header.magic);
    header.format_version = maps.format_version;
    header.header_bytes = sizeof header;
    header.file_bytes = file_bytes;
    header.index_offset = index_offset;
    header.index_bytes = records.size();
    header.chart_count = static_cast<std::uint32_t>(maps.charts.size());
    header.layer_count = static_cast<std::uint32_t>(layer_count);
    set_hash(header.index_hash, hash_bytes(records));
    set_hash(header.source_hash, maps.source_hash);
    set_hash(header.settings_hash, maps.settings_hash);
    set_hash(header.rest_hash, rest_hash);
    set_hash(header.header_hash,
             hash_bytes(std::as_bytes(std::span(&header, 1)).first(offsetof(layout::FileHeader, header_hash))));
    std::vector<std::byte> out(sizeof header);
    std::memcpy(out.data(), &header, sizeof header);
    if (index_offset == sizeof header) out.insert(out.end(), records.begin(), records.end());
    return out;
}

[[noreturn]] void fail(const char* action, const fs::path& path) {
    throw model::Error(codes::kWriteFailed, std::string(action) + ": " + std::generic_category().message(errno),
                       path.string());
}

/// Hash of the bytes that HDF5 has written around the layers.
Hash128 hash_rest(const fs::path& path, const Index& index, std::uint64_t file_bytes) {
    std::ifstream file(path, std::ios::binary);
    Hasher hasher;
    std::vector<char> block;
    for (const auto& [begin, end] : ranges_beside_layers(index, file_bytes)) {
        block.resize(end - begin);
        file.seekg(static_cast<std::streamoff>(begin));
        file.read(block.data(), static_cast<std::streamsize>(block.size()));
        hasher.add(std::as_bytes(std::span(block)));
    }
    if (!file) throw model::Error(codes::kWriteFailed, "what was written cannot be read back", path.string());
    return hasher.result();
}

void write_user_block(const fs::path& path, const std::vector<std::byte>& block) {
    const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (file < 0) fail("open", path);
    const ssize_t written = ::pwrite(file, block.data(), block.size(), 0);
    const int error = errno;
    if (::close(file) != 0 || written != static_cast<ssize_t>(block.size())) {
        errno = written < 0 ? error : ENOSPC;
        fail("write the index", path);
    }
}

void write_file(const MapSet& maps, Index index, const fs::path& path) {
    const std::uint64_t records_bytes = index_bytes(index.charts.size(), index.layers.size());
    const bool fits = sizeof(layout::FileHeader) + records_bytes <= layout::kUserBlockBytes;
    std::uint64_t index_offset = sizeof(layout::FileHeader);
    std::vector<std::byte> records;
    {
        std::uint64_t smallest = fits ? std::numeric_limits<std::uint64_t>::max() : records_bytes, all = 0;
        for (const layout::LayerRecord& layer : index.layers) {
            if (layer.bytes > 0) smallest = std::min(smallest, layer.bytes);
            all += layer.bytes;
        }
        H5Writer writer(path, index.layers.size(), smallest, all);
        writer.write_root(maps);
        for (std::size_t k = 0; k < maps.charts.size(); ++k)
            writer.write_chart(
                maps.charts[k], k,
                std::span(index.layers).subspan(index.charts[k].first_layer, index.charts[k].layer_count));
        writer.write_report(maps.report_json);
        if (!fits) index_offset = writer.reserve_index(records_bytes);
        records = encode_records(index);
        if (!fits) writer.write_index(records);
        writer.close();
    }
    std::error_code error;
    const std::uint64_t file_bytes = fs::file_size(path, error);
    if (error) throw model::Error(codes::kWriteFailed, error.message(), path.string());
    write_user_block(path, user_block(maps, records, index_offset, index.layers.size(), file_bytes,
                                      hash_rest(path, index, file_bytes)));
    sync_file(path);
}

}  // namespace

void write_dgm(const MapSet& maps, const fs::path& path) {
    Index index = plan_index(maps);
    // The system's own words for why a file cannot be made are better than HDF5's.
    const int probe = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (probe < 0) fail("create", path);
    ::close(probe);
    try {
        const H5Session session;
        write_file(maps, std::move(index), path);
    } catch (...) {
        std::error_code error;
        if (fs::is_regular_file(path, error)) fs::remove(path, error);
        throw;
    }
}

}  // namespace dgm::formats
