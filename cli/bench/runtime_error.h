// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/runtime_error.h
#pragma once
#include <dgm/result.h>

#include <utility>

#include "model/codes.h"

namespace dgm::bench {

/// The value of a runtime's answer. @throws model::Error kReadFailed with its message
template <class T>
T take(Result<T> result) {
    if (!result) throw model::Error(model::codes::kReadFailed, result.error().message);
    return std::move(result).value();
}

}  // namespace dgm::bench
