// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/h5_file.h
// HDF5's handles and types in C++: closed when they leave scope, errors as exceptions, nothing printed.
#pragma once
#include <hdf5.h>

#include <filesystem>
#include <mutex>
#include <string>
#include <utility>

#include <dgm/layout.h>

#include "model/codes.h"
#include "model/map_set.h"

namespace dgm::formats {

/// Held while HDF5 is in use: the serial library is not thread-safe. Also keeps it from printing to stderr.
class H5Session {
 public:
    H5Session();
    ~H5Session();
    H5Session(const H5Session&) = delete;
    H5Session& operator=(const H5Session&) = delete;

 private:
    std::unique_lock<std::mutex> lock_;
    H5E_auto2_t report_ = nullptr;
    void* report_data_ = nullptr;
};

/// Owns any kind of HDF5 object.
class H5Handle {
 public:
    H5Handle() = default;
    explicit H5Handle(hid_t id) : id_(id) {}
    H5Handle(H5Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
    H5Handle& operator=(H5Handle&& other) noexcept {
        std::swap(id_, other.id_);
        return *this;
    }
    ~H5Handle() {
        if (id_ >= 0) H5Idec_ref(id_);
    }
    operator hid_t() const { return id_; }
    [[nodiscard]] bool is_valid() const { return id_ >= 0; }
    /// Closes now. @return false if HDF5 could not: data may be lost
    [[nodiscard]] bool close() { return H5Idec_ref(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

 private:
    hid_t id_ = H5I_INVALID_HID;
};

/// Turns HDF5's negative results into errors of one code and place.
struct H5Check {
    const model::Code& code;
    std::string place;

    [[nodiscard]] H5Handle handle(hid_t id, const char* action) const {
        if (id < 0) fail(action);
        return H5Handle(id);
    }
    void done(herr_t status, const char* action) const {
        if (status < 0) fail(action);
    }
    [[noreturn]] void fail(const char* action) const {
        throw model::Error(code, std::string("HDF5 cannot ") + action, place);
    }
};

/// The HDF5 type of an element, little-endian; kF16 is the IEEE half that h5py calls float16.
[[nodiscard]] H5Handle h5_element_type(layout::ElementType type, const H5Check& check);
/// Text of exactly `length` bytes (at least 1), zero-padded.
[[nodiscard]] H5Handle h5_text_type(std::size_t length, const H5Check& check);

/// Writes one attribute: text as a scalar, numbers as an array of one dimension, or of `row_length` numbers a row.
/// @throws model::Error with check's code; kBadLayerShape for text with zeros inside or more than 60000 bytes
void write_attribute(hid_t object, const std::string& name, const model::AttributeValue& value, const H5Check& check,
                     std::size_t row_length = 0);

/// Reads any attribute of the kinds that write_attribute makes, up to 64 KiB.
/// @throws model::Error with check's code if there is none, or it is of another kind
[[nodiscard]] model::AttributeValue read_attribute(hid_t object, const std::string& name, const H5Check& check);

}  // namespace dgm::formats
