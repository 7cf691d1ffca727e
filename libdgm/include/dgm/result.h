// SPDX-License-Identifier: MIT
// libdgm/include/dgm/result.h
// Defines a value or an Error: every function of the runtime that can fail returns one. Nothing throws.
#pragma once
#include <cstdint>
#include <cstdlib>
#include <new>
#include <utility>

#include <dgm/export.h>

namespace dgm {

/// Result of a call. Numbers are part of the C ABI: never reused, new ones at the end.
enum class ErrorCode : std::uint32_t {
    Ok = 0,
    BadArgument = 1,      ///< a parameter is out of range or not finite; nothing was changed
    OutOfMemory = 2,      ///< the allocator returned null
    FileMissing = 3,      ///< no such file
    ReadFailed = 4,       ///< the file exists but cannot be read or mapped
    NotDgm = 5,           ///< the file does not start with the magic of a .dgm
    BadVersion = 6,       ///< format version 0, or newer than this library
    Truncated = 7,        ///< fewer bytes than the header says
    HashMismatch = 8,     ///< stored bytes differ from their XXH3-128
    BadIndex = 9,         ///< header, chart or layer record is inconsistent
    BadLayer = 10,        ///< a known layer has the wrong type or shape
    BadValue = 11,        ///< a layer contains a value outside its range
    BadSeamTable = 12,    ///< pairs out of range, not lowest first, or repeated
    SeamGap = 13,         ///< copies of one weld class differ
    NotFinite = 14,       ///< NaN or infinity on the surface
    MissingLayer = 15,    ///< the chart does not have a layer that the call needs
    UnknownLayer = 16,    ///< the file requires a layer that this library does not know
    LimitExceeded = 17,   ///< beyond OpenOptions, StateOptions or the address space
    BufferTooSmall = 18,  ///< the caller's memory cannot hold the answer
    NotFound = 19,        ///< no sample on the surface, no triangle on the ray, no frame yet
    Unsupported = 20,     ///< a choice that this version or platform does not support
    Busy = 21,            ///< a reader was overtaken by the writer too often
};

/// No place in a file.
inline constexpr std::uint64_t kNoOffset = ~std::uint64_t{0};

/// An error: its code, its place and a message.
struct Error {
    ErrorCode code = ErrorCode::Ok;
    std::uint64_t byte_offset = kNoOffset;  ///< place in the file, or kNoOffset
    const char* message = "";               ///< static text, never freed
};

/// A T or an Error. value() of an error aborts: ask ok() first.
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

/// Returns the upper-case name of a code, e.g. "BAD_INDEX"; "UNKNOWN" for any other number. Names do not change.
[[nodiscard]] DGM_API const char* error_name(ErrorCode code) noexcept;

}  // namespace dgm
