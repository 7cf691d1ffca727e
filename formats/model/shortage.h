// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/shortage.h
// Failures that say nothing about the input: whoever tries another way after them makes a worse map without need.
#pragma once
#include <new>
#include <system_error>

#include "model/codes.h"

namespace dgm::model {

/// A fault of this machine for now, which may be gone at the next try.
[[nodiscard]] inline bool may_pass(const Error& error) {
    return error.code().exit == ExitCode::kTransient || error.code().number == codes::kWorkerMemory.number;
}

/// A fault of this machine. Trying the next method must not hide it: the same input would have another map
/// where threads, memory or descriptors are short.
[[nodiscard]] inline bool is_shortage(const Error& error) {
    return may_pass(error) || error.code().exit == ExitCode::kIo;
}

/// An exception of a library as an error of ours: what is short for now (memory, threads, descriptors) is kSystemBusy,
/// the rest kInternal.
[[nodiscard]] inline Error error_of(const std::exception& exception) {
    if (dynamic_cast<const std::bad_alloc*>(&exception) != nullptr) return {codes::kSystemBusy, "out of memory"};
    if (const auto* error = dynamic_cast<const std::system_error*>(&exception))
        for (const std::errc shortage : {std::errc::resource_unavailable_try_again, std::errc::not_enough_memory,
                                         std::errc::too_many_files_open, std::errc::too_many_files_open_in_system})
            if (error->code() == shortage) return {codes::kSystemBusy, error->what()};
    return {codes::kInternal, exception.what()};
}

}  // namespace dgm::model
