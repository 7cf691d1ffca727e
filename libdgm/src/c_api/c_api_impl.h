// SPDX-License-Identifier: MIT
// libdgm/src/c_api/c_api_impl.h
// Handles, sized structs and null checks, which the files behind dgm.h share.
#pragma once
#include <dgm/dgm.h>

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include <dgm/asset.h>
#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/snapshot.h>
#include <dgm/state.h>

#include "base/memory.h"

namespace dgm::c_api {

/// A handle points to this: an object and where its memory came from.
template <class T>
struct Held {
    Held(const dgm::Allocator& a, T&& v) noexcept : allocator(a), value(std::move(v)) {}
    dgm::Allocator allocator;
    T value;
};

}  // namespace dgm::c_api

struct dgm_asset : dgm::c_api::Held<dgm::Asset> {
    using Held::Held;
};
struct dgm_state : dgm::c_api::Held<dgm::State> {
    using Held::Held;
};
struct dgm_table : dgm::c_api::Held<dgm::DeformTable> {
    using Held::Held;
};
struct dgm_contact_solver : dgm::c_api::Held<dgm::ContactSolver> {
    using Held::Held;
};
struct dgm_snapshots : dgm::c_api::Held<dgm::Snapshots> {
    using Held::Held;
};

namespace dgm::c_api {

inline constexpr Error kNull{ErrorCode::BadArgument, kNoOffset, "a pointer is null"};
inline constexpr Error kBadSize{ErrorCode::BadArgument, kNoOffset, "struct_size is not set"};
inline constexpr std::size_t kMaxStruct = 4096;  // no struct of ours ever grows to this

/// For static_assert: an enumerator of dgm.h has the number of its C++ counterpart.
template <class E>
[[nodiscard]] constexpr bool same(int number, E value) noexcept {
    return number == static_cast<int>(value);
}

/// Writes the fields of an answer that both sides know; the caller's struct_size stays.
template <class T>
void put(T* to, T from) noexcept {
    if (to == nullptr || to->struct_size < sizeof(std::uint32_t)) return;
    from.struct_size = to->struct_size;
    std::memcpy(static_cast<void*>(to), &from, std::min<std::size_t>(to->struct_size, sizeof(T)));
}

inline dgm_code finish(const Error& e, dgm_error* error) noexcept {
    put(error, dgm_error{0, static_cast<std::uint32_t>(e.code), e.byte_offset, e.message});
    return static_cast<dgm_code>(e.code);
}

/// Reads the fields of the options that both sides know; the rest is 0. Null: all defaults.
template <class T>
Result<void> get(const T* from, T& to) noexcept {
    to = T{};
    if (from == nullptr) return {};
    const std::size_t size = from->struct_size;
    if (size < sizeof(std::uint32_t) || size > kMaxStruct) return kBadSize;
    std::memcpy(static_cast<void*>(&to), from, std::min(size, sizeof(T)));
    const auto* bytes = reinterpret_cast<const unsigned char*>(from);
    for (std::size_t k = sizeof(T); k < size; ++k)
        if (bytes[k] != 0) return Error{ErrorCode::Unsupported, kNoOffset, "an option is newer than this library"};
    return {};
}

inline Result<dgm::Allocator> allocator_of(const dgm_allocator* from) noexcept {
    dgm_allocator a;
    if (auto r = get(from, a); !r) return r.error();
    return dgm::Allocator{a.user, a.allocate, a.release};
}

/// Options and where the memory is to come from.
template <class T>
Result<dgm::Allocator> get(const T* from, T& to, const dgm_allocator* allocator) noexcept {
    if (auto r = get(from, to); !r) return r.error();
    return allocator_of(allocator);
}

/// Moves a C++ object into a handle from the same allocator.
template <class Handle, class T>
dgm_code hand_out(Result<T>&& made, const dgm::Allocator& allocator, Handle** out, dgm_error* error) noexcept {
    if (!made) return finish(made.error(), error);
    Handle* handle = dgm::detail::create<Handle>(allocator, allocator, std::move(made).value());
    if (handle == nullptr) return finish({ErrorCode::OutOfMemory, kNoOffset, "no memory for the handle"}, error);
    *out = handle;
    return finish({}, error);
}

inline Vec3 vec(const float* v) noexcept {
    return {v[0], v[1], v[2]};
}
inline void store(Vec3 v, float* to) noexcept {
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

/// Arrays of sized structs: as many bytes apart as the caller's version of the struct has.
template <class T>
T* element(T* first, std::size_t k) noexcept {
    using Byte = std::conditional_t<std::is_const_v<T>, const char, char>;
    return reinterpret_cast<T*>(reinterpret_cast<Byte*>(first) + k * first->struct_size);
}
/// Reads `count` of them, all of one size: take(k, read).
template <class T, class F>
Result<void> get_each(const T* first, std::size_t count, F take) noexcept {
    for (std::size_t k = 0; k < count; ++k) {
        if (k > 0 && element(first, k)->struct_size != first->struct_size) return kBadSize;
        T one;
        if (auto r = get(element(first, k), one); !r) return r;
        take(k, one);
    }
    return {};
}

inline Result<dgm::Obstacle> obstacle_of(const dgm_obstacle* from) noexcept {
    if (from == nullptr) return kNull;
    dgm_obstacle o;
    if (auto r = get(from, o); !r) return r.error();
    dgm::Obstacle to;
    to.kind = static_cast<dgm::ObstacleKind>(o.kind);
    to.point = vec(o.point);
    to.normal = vec(o.normal);
    to.end = vec(o.end);
    to.radius = o.radius;
    to.half = vec(o.half);
    // Zeros are the default: no rotation.
    if (std::any_of(o.rotation, o.rotation + 9, [](float v) { return v != 0; }))
        std::copy_n(o.rotation, 9, to.rotation);
    to.surface = o.surface == nullptr ? nullptr : &o.surface->value;
    to.reach = o.reach;
    const auto is_null = [](const float* p) { return p == nullptr; };
    if (to.surface != nullptr && !std::all_of(o.before, o.before + 3, is_null)) {
        if (std::any_of(o.before, o.before + 3, is_null)) return kNull;
        to.before = {o.before[0], o.before[1], o.before[2], to.surface->sample_count(), 1};
    }
    return to;
}

}  // namespace dgm::c_api
