// SPDX-License-Identifier: MIT
// libdgm/src/base/memory.h
// Arrays that take memory from the caller's allocator and report when there is none: nothing here throws.
#pragma once
#include <cstddef>
#include <cstdint>
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

/// Memory of an array, whatever its elements are.
struct ArrayMemory {
    Allocator allocator;
    void* data = nullptr;
    std::size_t size = 0;  ///< elements

    /// For `count` elements of `each` bytes, aligned to kMaxAlignment. @return false if there is no memory, or elements
    /// are more than memory can have; nothing is changed then, nor for none
    [[nodiscard]] DGM_API bool take(const Allocator& from, std::uint64_t count, std::size_t each) noexcept;
    DGM_API void give_back(std::size_t each) noexcept;
};

/// Fixed array of trivial elements; starts empty, filled once by allocate().
template <class T>
class Array {
    static_assert(std::is_trivially_destructible_v<T> && std::is_trivially_copyable_v<T>);

 public:
    Array() noexcept = default;
    Array(const Array&) = delete;
    Array& operator=(const Array&) = delete;
    Array(Array&& other) noexcept : memory_(std::exchange(other.memory_, {})) {}
    Array& operator=(Array&& other) noexcept {
        std::swap(memory_, other.memory_);
        return *this;
    }
    ~Array() { memory_.give_back(sizeof(T)); }

    /// Elements are set to `fill`. @return false if there is no memory; the array is then empty.
    [[nodiscard]] bool allocate(const Allocator& allocator, std::uint64_t count, const T& fill = T{}) noexcept {
        if (!memory_.take(allocator, count, sizeof(T))) return false;
        for (T& element : *this) new (&element) T(fill);
        return true;
    }

    [[nodiscard]] T& operator[](std::size_t k) noexcept { return data()[k]; }
    [[nodiscard]] const T& operator[](std::size_t k) const noexcept { return data()[k]; }
    [[nodiscard]] T* data() noexcept { return static_cast<T*>(memory_.data); }
    [[nodiscard]] const T* data() const noexcept { return static_cast<const T*>(memory_.data); }
    [[nodiscard]] std::size_t size() const noexcept { return memory_.size; }
    [[nodiscard]] bool empty() const noexcept { return size() == 0; }
    [[nodiscard]] T* begin() noexcept { return data(); }
    [[nodiscard]] T* end() noexcept { return data() + size(); }
    [[nodiscard]] const T* begin() const noexcept { return data(); }
    [[nodiscard]] const T* end() const noexcept { return data() + size(); }

 private:
    ArrayMemory memory_;
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
