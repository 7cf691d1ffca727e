// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_open.h
#pragma once
#include <cstddef>
#include <cstdint>

/// Opens the bytes, as they are and with their hashes made right, and makes every call that may follow.
/// Aborts if a promise is broken (seam copies that differ, a sample out of range).
void exercise_runtime(const std::uint8_t* data, std::size_t size);
