// SPDX-License-Identifier: MIT
// libdgm/src/base/memory.h
// Arrays that take memory from the caller's allocator and report when there is none: nothing here throws.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include <dgm/allocator.h>
#include <dgm/export.h>
#include <dgm/result.h>

namespace dgm::detail {

inline constexpr std::size_t kMaxAlignment = 64;
/// What an object answers that needs more bytes than its options' `max_bytes`.
constexpr Error over_max_bytes() noexcept {
    return {ErrorCode::LimitExceeded, kNoOffset, "this would take more memory than the limit allows"};
}

[[nodiscard]] DGM_API void* allocate(const Allocator& allocator, std::size_t bytes, std::size_t alignment) noexcept;
DGM_API void release(const Allocator& allocator, void* memory, std::size_t bytes) noexcept;
/// Both functions given, or neither.
[[nodiscard]] DGM_API bool is_valid(const Allocator& allocator) noexcept;

/// Fixed array of trivial elements; starts empty, filled once by allocate().
template <class T>
class Array {
    static_assert(std::is_trivially_destructible_v<T> && std::is_trivially_copyable_v<T>);

 public:
    Array() noexcept = default;
    Array(const Array&) = delete;
    Array& operator=(const Array&) = delete;
    Array(Array&& other) noexcept
        : allocator_(other.allocator_),
          data_(std::exchange(other.data_, nullptr)),
          size_(std::exchange(other.size_, 0)) {}
    Array& operator=(Array&& other) noexcept {
        std::swap(allocator_, other.allocator_);
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        return *this;
    }
    ~Array() {
        if (data_ != nullptr) release(allocator_, data_, size_ * sizeof(T));
    }

    /// Elements are set to `fill`. @return false if there is no memory; the array is then empty.
    [[nodiscard]] bool allocate(const Allocator& allocator, std::uint64_t count, const T& fill = T{}) noexcept {
        if (count == 0) return true;
        if (count > std::numeric_limits<std::size_t>::max() / 2 / sizeof(T)) return false;
        void* memory = detail::allocate(allocator, static_cast<std::size_t>(count) * sizeof(T), kMaxAlignment);
        if (memory == nullptr) return false;
        allocator_ = allocator;
        data_ = static_cast<T*>(memory);
        size_ = static_cast<std::size_t>(count);
        for (std::size_t k = 0; k < size_; ++k) new (data_ + k) T(fill);
        return true;
    }

    [[nodiscard]] T& operator[](std::size_t k) noexcept { return data_[k]; }
    [[nodiscard]] const T& operator[](std::size_t k) const noexcept { return data_[k]; }
    [[nodiscard]] T* data() noexcept { return data_; }
    [[nodiscard]] const T* data() const noexcept { return data_; }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
    [[nodiscard]] T* begin() noexcept { return data_; }
    [[nodiscard]] T* end() noexcept { return data_ + size_; }
    [[nodiscard]] const T* begin() const noexcept { return data_; }
    [[nodiscard]] const T* end() const noexcept { return data_ + size_; }

 private:
    Allocator allocator_;
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

/// A T in the caller's memory, or null. T may own arrays; it is destroyed by destroy().
template <class T, class... Args>
[[nodiscard]] T* create(const Allocator& allocator, Args&&... args) noexcept {
    void* memory = allocate(allocator, sizeof(T), alignof(T));
    return memory == nullptr ? nullptr : new (memory) T(std::forward<Args>(args)...);
}
template <class T>
void destroy(T* object) noexcept {
    if (object == nullptr) return;
    const Allocator allocator = object->allocator;  // outlives the object it is kept in
    object->~T();
    release(allocator, object, sizeof(T));
}

}  // namespace dgm::detail
