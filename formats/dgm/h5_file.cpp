// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/h5_file.cpp
#include "dgm/h5_file.h"

#include <array>
#include <vector>

namespace dgm::formats {
namespace {

/// HDF5 keeps attributes in object headers, which end at 64 KiB.
constexpr std::size_t kMaxAttributeBytes = 60'000;

std::mutex& h5_mutex() {
    static std::mutex mutex;
    return mutex;
}

}  // namespace

H5Session::H5Session() : lock_(h5_mutex()) {
    // Every file is closed here; HDF5's own clean-up at exit complains about entries that a damaged file left in its
    // tables.
    static const herr_t no_exit_handler = H5dont_atexit();
    (void)no_exit_handler;
    H5Eget_auto2(H5E_DEFAULT, &report_, &report_data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

H5Session::~H5Session() {
    H5Eset_auto2(H5E_DEFAULT, report_, report_data_);
}

H5Handle h5_element_type(layout::ElementType type, const H5Check& check) {
    using layout::ElementType;
    switch (type) {
        case ElementType::kU8:
            return check.handle(H5Tcopy(H5T_STD_U8LE), "make a type");
        case ElementType::kU16:
            return check.handle(H5Tcopy(H5T_STD_U16LE), "make a type");
        case ElementType::kU32:
            return check.handle(H5Tcopy(H5T_STD_U32LE), "make a type");
        case ElementType::kI16:
            return check.handle(H5Tcopy(H5T_STD_I16LE), "make a type");
        case ElementType::kF32:
            return check.handle(H5Tcopy(H5T_IEEE_F32LE), "make a type");
        case ElementType::kF16:
            break;
    }
    // IEEE 754 binary16; fields before size and bias, or HDF5 refuses the smaller size.
    H5Handle half = check.handle(H5Tcopy(H5T_IEEE_F32LE), "make a type");
    check.done(H5Tset_fields(half, 15, 10, 5, 0, 10), "make a type");
    check.done(H5Tset_size(half, 2), "make a type");
    check.done(H5Tset_ebias(half, 15), "make a type");
    return half;
}

H5Handle h5_text_type(std::size_t length, const H5Check& check) {
    H5Handle type = check.handle(H5Tcopy(H5T_C_S1), "make a type");
    check.done(H5Tset_size(type, length == 0 ? 1 : length), "make a type");
    check.done(H5Tset_strpad(type, H5T_STR_NULLPAD), "make a type");
    check.done(H5Tset_cset(type, H5T_CSET_UTF8), "make a type");
    return type;
}

void write_attribute(hid_t object, const std::string& name, const model::AttributeValue& value, const H5Check& check,
                     std::size_t row_length) {
    H5Handle type, space;
    std::string padded;
    const void* data = nullptr;
    std::size_t count = 0;
    if (const auto* text = std::get_if<std::string>(&value)) {
        if (text->find('\0') != std::string::npos || text->size() > kMaxAttributeBytes)
            throw model::Error(model::codes::kBadLayerShape, "attribute " + name + " is too long or holds a zero byte",
                               check.place);
        padded = *text;
        if (padded.empty()) padded.push_back('\0');
        type = h5_text_type(padded.size(), check);
        space = check.handle(H5Screate(H5S_SCALAR), "make a space");
        data = padded.data();
    } else {
        if (const auto* doubles = std::get_if<std::vector<double>>(&value)) {
            type = check.handle(H5Tcopy(H5T_IEEE_F64LE), "make a type");
            data = doubles->data();
            count = doubles->size();
        } else {
            const auto& words = std::get<std::vector<std::uint32_t>>(value);
            type = check.handle(H5Tcopy(H5T_STD_U32LE), "make a type");
            data = words.data();
            count = words.size();
        }
        if (count * 8 > kMaxAttributeBytes)
            throw model::Error(model::codes::kBadLayerShape, "attribute " + name + " is too long", check.place);
        std::array<hsize_t, 2> extent{count, row_length};
        const bool in_rows = row_length > 0 && count % row_length == 0;
        if (in_rows) extent[0] = count / row_length;
        space = check.handle(H5Screate_simple(in_rows ? 2 : 1, extent.data(), nullptr), "make a space");
    }
    const H5Handle attribute = check.handle(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT),
                                            ("create attribute " + name).c_str());
    if (count == 0 && padded.empty()) return;
    check.done(H5Awrite(attribute, type, data), ("write attribute " + name).c_str());
}

model::AttributeValue read_attribute(hid_t object, const std::string& name, const H5Check& check) {
    const std::string action = "read attribute " + name;
    if (H5Aexists(object, name.c_str()) <= 0) check.fail(action.c_str());
    const H5Handle attribute = check.handle(H5Aopen(object, name.c_str(), H5P_DEFAULT), action.c_str());
    const H5Handle type = check.handle(H5Aget_type(attribute), action.c_str());
    const H5Handle space = check.handle(H5Aget_space(attribute), action.c_str());
    const std::size_t element = H5Tget_size(type);
    const hssize_t count = H5Sget_simple_extent_npoints(space);
    const H5T_class_t kind = H5Tget_class(type);
    constexpr std::size_t kMaxRead = 1u << 16;
    if (count < 0 || element == 0 || element > kMaxRead || static_cast<std::size_t>(count) > kMaxRead / element)
        check.fail(action.c_str());
    const auto size = static_cast<std::size_t>(count);
    if (kind == H5T_STRING && size == 1 && H5Tis_variable_str(type) == 0) {
        std::string text(element, '\0');
        check.done(H5Aread(attribute, type, text.data()), action.c_str());
        text.resize(std::min(text.find('\0'), text.size()));
        return text;
    }
    if (kind == H5T_FLOAT && element == 8) {
        std::vector<double> values(size);
        if (size > 0) check.done(H5Aread(attribute, H5T_NATIVE_DOUBLE, values.data()), action.c_str());
        return values;
    }
    if (kind == H5T_INTEGER && element == 4 && H5Tget_sign(type) == H5T_SGN_NONE) {
        std::vector<std::uint32_t> values(size);
        if (size > 0) check.done(H5Aread(attribute, H5T_NATIVE_UINT32, values.data()), action.c_str());
        return values;
    }
    check.fail(action.c_str());
}

}  // namespace dgm::formats
