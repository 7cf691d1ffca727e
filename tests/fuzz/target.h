// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/target.h
// Interface of every fuzz_*.cpp: to libFuzzer under DGM_FUZZ, to replay.cpp in all other builds.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstdlib>

/// Untrusted bytes. Aborts if a promise is broken.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace dgm::test {

inline void require(bool claim) {
    if (!claim) std::abort();
}

}  // namespace dgm::test
