// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/attempt.h
// A value, or the error by which it could not be made: for work that tries several things and expects some to fail.
#pragma once
#include <type_traits>
#include <utility>
#include <variant>

#include "model/codes.h"
#include "model/error.h"
#include "model/shortage.h"

namespace dgm::bake {

enum class Failure {
    kGridTooSmall,  ///< a finer grid may do
    kMapInvalid,    ///< another cut, method or grid may do
    kOther,
};

[[nodiscard]] inline Failure failure_of(const model::Error& error) {
    if (&error.code() == &model::codes::kGridTooSmall) return Failure::kGridTooSmall;
    return &error.code() == &model::codes::kMapInvalid ? Failure::kMapInvalid : Failure::kOther;
}

template <class T>
class [[nodiscard]] Attempt {
 public:
    Attempt(T value) : result_(std::move(value)) {}
    Attempt(model::Error error) : result_(std::move(error)) {}

    [[nodiscard]] explicit operator bool() const { return std::holds_alternative<T>(result_); }
    [[nodiscard]] T& operator*() { return std::get<T>(result_); }
    [[nodiscard]] const T& operator*() const { return std::get<T>(result_); }
    [[nodiscard]] T* operator->() { return &std::get<T>(result_); }
    [[nodiscard]] const T* operator->() const { return &std::get<T>(result_); }
    [[nodiscard]] const model::Error& error() const { return std::get<model::Error>(result_); }
    [[nodiscard]] Failure failure() const { return failure_of(error()); }

 private:
    std::variant<T, model::Error> result_;
};

/// Calls `body`, which may throw model::Error. This is the only place where such an exception becomes a result: a
/// request to stop (kInterrupted) passes through, and so does a shortage, which says nothing about what was tried.
template <class Body>
[[nodiscard]] Attempt<std::invoke_result_t<Body>> attempt(Body&& body) {
    try {
        return std::forward<Body>(body)();
    } catch (const model::Error& error) {
        if (&error.code() == &model::codes::kInterrupted || model::is_shortage(error)) throw;
        return error;
    }
}

}  // namespace dgm::bake
