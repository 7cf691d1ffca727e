// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/h5_comparison.cpp
#include "dgm/h5_comparison.h"

#include <algorithm>
#include <cstring>
#include <span>

#include "dgm/h5_file.h"
#include "dgm/hash.h"
#include "model/codes.h"
#include "model/layer_names.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
using layout::LayerRecord;

constexpr std::uint64_t kMaxReportBytes = std::uint64_t{256} << 20;

/// Opens a child through a hard link alone: soft and external links could lead anywhere.
H5Handle open_child(hid_t parent, const std::string& name, const std::string& place, H5I_type_t kind) {
    const H5Check check{codes::kHdf5Unreadable, place};
    H5L_info_t link;
    if (H5Lexists(parent, name.c_str(), H5P_DEFAULT) <= 0 || H5Lget_info(parent, name.c_str(), &link, H5P_DEFAULT) < 0)
        check.fail("find it");
    if (link.type != H5L_TYPE_HARD) throw model::Error(codes::kForeignStorage, "a soft or external link", place);
    H5Handle object = check.handle(H5Oopen(parent, name.c_str(), H5P_DEFAULT), "open it");
    if (H5Iget_type(object) != kind) throw model::Error(codes::kIndexDiffers, "an object of another kind", place);
    return object;
}

/// Whether a dataset's bytes lie in the file as they are, in one piece.
bool is_plain_storage(hid_t creation) {
    return H5Pget_layout(creation) == H5D_CONTIGUOUS && H5Pget_nfilters(creation) == 0 &&
           H5Pget_external_count(creation) == 0;
}

template <class Value>
Value expect(hid_t object, const char* name, const std::string& place) {
    const H5Check check{codes::kBadAttribute, place};
    model::AttributeValue value = read_attribute(object, name, check);
    if (auto* typed = std::get_if<Value>(&value)) return std::move(*typed);
    check.fail((std::string("read attribute ") + name).c_str());
}

using Attributes = std::map<std::string, model::AttributeValue>;

Attributes read_layer_attributes(hid_t set, bool is_geometry, const std::string& place) {
    const H5Check check{codes::kHdf5Unreadable, place};
    std::vector<std::string> names;
    hsize_t position = 0;
    const auto collect = [](hid_t, const char* name, const H5A_info_t*, void* out) -> herr_t {
        auto& list = *static_cast<std::vector<std::string>*>(out);
        list.emplace_back(name);
        return list.size() < 1000 ? 0 : -1;
    };
    check.done(H5Aiterate2(set, H5_INDEX_NAME, H5_ITER_INC, &position, collect, &names), "list its attributes");
    Attributes attributes;
    for (const std::string& name : names)
        if (!is_geometry || (name != "offset" && name != "scale"))
            attributes.emplace(name, read_attribute(set, name, check));
    return attributes;
}

/// Checks that any object of the format has to pass.
class ObjectCheck {
 public:
    explicit ObjectCheck(FindingList& findings) : findings_(findings) {}

    void count_links(hid_t group, std::size_t expected, const std::string& place) {
        H5G_info_t info;
        if (H5Gget_info(group, &info) < 0 || info.nlinks != expected)
            findings_.add(codes::kUnknownObject, "the group does not hold what the index lists, and that alone", place,
                          static_cast<double>(info.nlinks), static_cast<double>(expected));
    }

    void count_attributes(hid_t object, hsize_t expected, const std::string& place) {
        H5O_info_t info;
        if (H5Oget_info2(object, &info, H5O_INFO_NUM_ATTRS) < 0)
            H5Check{codes::kHdf5Unreadable, place}.fail("count its attributes");
        if (info.num_attrs != expected)
            findings_.add(codes::kUnknownObject, "not the attributes of the format, and those alone", place,
                          static_cast<double>(info.num_attrs), static_cast<double>(expected));
    }

    void check_times(hid_t object, const std::string& place) {
        H5O_info_t info;
        if (H5Oget_info2(object, &info, H5O_INFO_TIME) < 0)
            H5Check{codes::kHdf5Unreadable, place}.fail("read its times");
        if (info.atime != 0 || info.mtime != 0 || info.ctime != 0 || info.btime != 0)
            findings_.add(codes::kNotReproducible, "the object carries the time of its making", place);
    }

    template <class Value>
    void compare(hid_t object, const char* name, const Value& wanted, const std::string& place) {
        // Bytes, not ==: attributes may hold NaN or -0 as long as both sides have the same.
        const Value found = expect<Value>(object, name, place);
        const bool same =
            found.size() == wanted.size() &&
            (found.empty() || std::memcmp(found.data(), wanted.data(), found.size() * sizeof found[0]) == 0);
        if (!same)
            findings_.add(codes::kIndexDiffers, std::string("attribute ") + name + " differs from the index", place);
    }

 private:
    FindingList& findings_;
};

class Comparison {
 public:
    Comparison(const RawFile& raw, const FileIndex& file, FindingList& findings, Hdf5Part& part)
        : raw_(raw), header_(file.header), file_(file), findings_(findings), objects_(findings), part_(part) {
        part_.attributes.resize(file.index.layers.size());
    }

    void walk(hid_t file) {
        check_root(file);
        const H5Handle charts = open_child(file, "charts", "/charts", H5I_GROUP);
        objects_.count_links(charts, file_.index.charts.size(), "/charts");
        for (std::size_t k = 0; k < file_.index.charts.size(); ++k) check_chart(charts, k);
        read_report(file);
    }

 private:
    void check_root(hid_t file) {
        using std::string;
        objects_.compare(file, "format_version", std::vector{header_.format_version}, "/");
        Hash128 source, settings;
        std::copy(std::begin(header_.source_hash), std::end(header_.source_hash), source.begin());
        std::copy(std::begin(header_.settings_hash), std::end(header_.settings_hash), settings.begin());
        objects_.compare(file, "source_hash", to_hex(source), "/");
        objects_.compare(file, "settings_hash", to_hex(settings), "/");
        part_.generator = expect<string>(file, "generator", "/");
        part_.source_name = expect<string>(file, "source_name", "/");
        objects_.count_attributes(file, 5, "/");
        objects_.count_links(file, file_.in_user_block() ? 2 : 3, "/");
        objects_.check_times(file, "/");
        if (part_.source_name.find_first_of("/\\") != string::npos)
            findings_.add(codes::kNotReproducible, "source_name holds a folder: " + part_.source_name, "/");
    }

    void check_chart(hid_t charts, std::size_t number) {
        const std::string place = h5_place(number);
        const layout::ChartRecord& record = file_.index.charts[number];
        const H5Handle group = open_child(charts, std::to_string(number), place, H5I_GROUP);
        const bool is_free = record.domain == static_cast<std::uint32_t>(layout::Domain::kFree);
        objects_.compare(group, "domain", std::string(is_free ? "free" : "square"), place);
        objects_.compare(group, "method", field_text(record.method).value_or(std::string()), place);
        objects_.compare(group, "rows", std::vector{record.rows}, place);
        objects_.compare(group, "cols", std::vector{record.cols}, place);
        objects_.compare(group, "bbox", std::vector<double>(std::begin(record.bbox), std::end(record.bbox)), place);
        objects_.count_attributes(group, 5, place);
        objects_.check_times(group, place);
        objects_.count_links(group, record.layer_count, place);
        for (std::uint32_t k = 0; k < record.layer_count; ++k) check_layer(group, number, k);
    }

    void check_layer(hid_t group, std::size_t number, std::uint32_t k) {
        const layout::ChartRecord& chart = file_.index.charts[number];
        const LayerRecord& record = file_.index.layers[chart.first_layer + k];
        const std::string name = field_text(record.name).value_or(std::string());
        const std::string place = h5_place(number, name);
        const H5Check check{codes::kHdf5Unreadable, place};
        const H5Handle set = open_child(group, name, place, H5I_DATASET);
        const H5Handle creation = check.handle(H5Dget_create_plist(set), "read its properties");
        if (!is_plain_storage(creation)) {
            findings_.add(codes::kForeignStorage,
                          "the dataset is chunked, filtered, virtual or stored outside the file", place);
            return;
        }
        objects_.check_times(set, place);
        check_dataset(set, record, check);
        const bool is_geometry = name == model::layers::kGeometry;
        if (is_geometry) {
            objects_.compare(set, "offset", std::vector<double>(std::begin(chart.offset), std::end(chart.offset)),
                             place);
            objects_.compare(set, "scale", std::vector<double>(std::begin(chart.scale), std::end(chart.scale)), place);
        }
        part_.attributes[chart.first_layer + k] = read_layer_attributes(set, is_geometry, place);
    }

    /// Shape, element type and offset are those of the record.
    void check_dataset(hid_t set, const LayerRecord& record, const H5Check& check) {
        const H5Handle space = check.handle(H5Dget_space(set), "read its shape");
        std::vector<hsize_t> extent(record.rank);
        const int rank = H5Sget_simple_extent_ndims(space);
        const bool same_shape = rank == static_cast<int>(record.rank) &&
                                H5Sget_simple_extent_dims(space, extent.data(), nullptr) == rank &&
                                std::equal(extent.begin(), extent.end(), record.shape);
        if (!same_shape) findings_.add(codes::kIndexDiffers, "HDF5 and the index disagree on the shape", check.place);
        const H5Handle type = check.handle(H5Dget_type(set), "read its type");
        const H5Handle wanted = h5_element_type(static_cast<layout::ElementType>(record.type), check);
        if (H5Tequal(type, wanted) <= 0)
            findings_.add(codes::kIndexDiffers, "HDF5 and the index disagree on the element type", check.place);
        if (record.bytes == 0) return;
        const haddr_t offset = H5Dget_offset(set);
        if (offset != record.offset)
            findings_.add(
                codes::kIndexDiffers,
                "HDF5 has the bytes at " + std::to_string(offset) + ", the index at " + std::to_string(record.offset),
                check.place, static_cast<double>(record.offset), static_cast<double>(offset));
    }

    void read_report(hid_t file) {
        const H5Check check{codes::kHdf5Unreadable, "/report"};
        const H5Handle set = open_child(file, "report", "/report", H5I_DATASET);
        const H5Handle creation = check.handle(H5Dget_create_plist(set), "read its properties");
        const H5Handle type = check.handle(H5Dget_type(set), "read its type");
        const H5Handle space = check.handle(H5Dget_space(set), "read its shape");
        const std::size_t size = H5Tget_size(type);
        if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 ||
            H5Sget_simple_extent_type(space) != H5S_SCALAR || !is_plain_storage(creation) || size == 0 ||
            size > kMaxReportBytes) {
            findings_.add(codes::kForeignStorage, "the report is not one text of fixed length", "/report");
            return;
        }
        const haddr_t offset = H5Dget_offset(set);
        if (offset == HADDR_UNDEF || !raw_.contains(offset, size)) {
            findings_.add(codes::kBadIndex, "the report lies outside the file", "/report");
            return;
        }
        const std::vector<std::byte> bytes = raw_.read(offset, size);
        const auto end = std::find(bytes.begin(), bytes.end(), std::byte{0});
        const std::span<const std::byte> text(bytes.data(), static_cast<std::size_t>(end - bytes.begin()));
        if (expect<std::string>(set, "hash", "/report") != to_hex(hash_bytes(text)))
            findings_.add(codes::kHashMismatch, "the report differs from its hash", "/report");
        part_.report_json.assign(reinterpret_cast<const char*>(text.data()), text.size());
    }

    const RawFile& raw_;
    const layout::FileHeader& header_;
    const FileIndex& file_;
    FindingList& findings_;
    ObjectCheck objects_;
    Hdf5Part& part_;
};

}  // namespace

void compare_with_hdf5(const std::filesystem::path& path, const RawFile& raw, const FileIndex& file,
                       FindingList& findings, Hdf5Part& part) {
    const H5Session session;
    try {
        const H5Check check{codes::kHdf5Unreadable, "/"};
        const H5Handle access = check.handle(H5Pcreate(H5P_FILE_ACCESS), "make a property list");
        const H5Handle opened = check.handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), "open the file");
        Comparison(raw, file, findings, part).walk(opened);
    } catch (const model::Error& error) {
        if (findings.throws()) throw;
        findings.add(error);
    }
}

}  // namespace dgm::formats
