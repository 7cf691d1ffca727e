// SPDX-License-Identifier: MIT
// libdgm/include/dgm/result.h
// A value or an Error: the way every fallible function of the runtime answers. Nothing throws.
#pragma once
#include <cstdint>
#include <cstdlib>
#include <new>
#include <utility>

#include <dgm/export.h>

namespace dgm {

/// What went wrong. Numbers are part of the C ABI: never reused, new ones at the end.
enum class ErrorCode : std::uint32_t {
    Ok = 0,
    BadArgument = 1,      ///< a parameter is out of range or not finite; nothing was changed
    OutOfMemory = 2,      ///< the allocator returned null
    FileMissing = 3,      ///< no such file
    ReadFailed = 4,       ///< the file exists but cannot be read or mapped
    NotDgm = 5,           ///< the magic is not there
    BadVersion = 6,       ///< format version 0, or newer than this library
    Truncated = 7,        ///< fewer bytes than the header says
    HashMismatch = 8,     ///< stored bytes differ from their XXH3-128
    BadIndex = 9,         ///< header, chart or layer record is inconsistent
    BadLayer = 10,        ///< a known layer has the wrong type or shape
    BadValue = 11,        ///< a table holds a value outside its range
    BadSeamTable = 12,    ///< pairs out of range, not lowest first, or repeated
    SeamGap = 13,         ///< copies of one seam class differ
    NotFinite = 14,       ///< NaN or infinity on the surface
    MissingLayer = 15,    ///< the call needs a layer the chart does not hold
    UnknownLayer = 16,    ///< a required layer this library does not know
    LimitExceeded = 17,   ///< beyond OpenOptions, StateOptions or the address space
    BufferTooSmall = 18,  ///< the caller's memory cannot hold the answer
    NotFound = 19,        ///< nothing fits the question, e.g. no sample on the surface
    Unsupported = 20,     ///< a valid wish this version cannot fulfil
    Busy = 21,            ///< a reader was overtaken by the writer again and again
};

/// Error without a place in a file.
inline constexpr std::uint64_t kNoOffset = ~std::uint64_t{0};

struct Error {
    ErrorCode code = ErrorCode::Ok;
    std::uint64_t byte_offset = kNoOffset;  ///< where in the file, or kNoOffset
    const char* message = "";               ///< static text, never freed
};

/// A T or an Error. `value()` on an error aborts: ask `ok()` first.
template <class T>
class [[nodiscard]] Result {
 public:
    Result(T value) noexcept : ok_(true), value_(std::move(value)) {}
    Result(Error error) noexcept : ok_(false), error_(error) {}
    Result(Result&& other) noexcept : ok_(other.ok_) {
        if (ok_)
            new (&value_) T(std::move(other.value_));
        else
            new (&error_) Error(other.error_);
    }
    Result& operator=(Result&&) = delete;
    ~Result() {
        if (ok_) value_.~T();
    }

    [[nodiscard]] bool ok() const noexcept { return ok_; }
    explicit operator bool() const noexcept { return ok_; }
    [[nodiscard]] T& value() & noexcept {
        if (!ok_) std::abort();
        return value_;
    }
    [[nodiscard]] const T& value() const& noexcept {
        if (!ok_) std::abort();
        return value_;
    }
    [[nodiscard]] T&& value() && noexcept {
        if (!ok_) std::abort();
        return std::move(value_);
    }
    [[nodiscard]] Error error() const noexcept { return ok_ ? Error{} : error_; }

 private:
    bool ok_;
    union {
        T value_;
        Error error_;
    };
};

template <>
class [[nodiscard]] Result<void> {
 public:
    Result() noexcept = default;
    Result(Error error) noexcept : error_(error) {}
    [[nodiscard]] bool ok() const noexcept { return error_.code == ErrorCode::Ok; }
    explicit operator bool() const noexcept { return ok(); }
    [[nodiscard]] Error error() const noexcept { return error_; }

 private:
    Error error_;
};

/// Stable upper-case name of a code, e.g. "BAD_INDEX"; "UNKNOWN" for a number that is none.
[[nodiscard]] DGM_API const char* error_name(ErrorCode code) noexcept;

}  // namespace dgm
