// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/guarded_main.h
// The outermost frame of every program.
#pragma once
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

#include "model/codes.h"

namespace dgm::tool {

/// Says on stderr that memory ran out, without taking any: not by fprintf(), which may allocate.
inline int say_out_of_memory(const char* program) {
    for (const char* part : {program, ": DGM9007: out of memory\n  next: ", model::codes::kSystemBusy.hint, "\n"})
        std::fputs(part, stderr);
    return static_cast<int>(model::codes::kSystemBusy.exit);
}

/// Runs `body`, which tells of its errors itself; where there is no memory even for that, says so without any. Neither
/// does a destructor that finds no memory (those of nlohmann::json allocate) end a program by a signal.
template <class Body>
int guarded_main(const char* program, Body body) noexcept {
    static const char* name = program;
    std::set_terminate([] {
        try {
            if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
        } catch (const std::bad_alloc&) { std::_Exit(say_out_of_memory(name)); } catch (...) {
        }
        std::abort();
    });
    try {
        return body();
    } catch (const std::bad_alloc&) { return say_out_of_memory(program); } catch (...) {
        for (const char* part : {program, ": internal error\n"}) std::fputs(part, stderr);
    }
    return static_cast<int>(model::ExitCode::kInternal);
}

}  // namespace dgm::tool
