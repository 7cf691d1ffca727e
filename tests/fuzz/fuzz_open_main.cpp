// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_open_main.cpp
// libFuzzer's way in.
#include "fuzz_open.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    exercise_runtime(data, size);
    return 0;
}
