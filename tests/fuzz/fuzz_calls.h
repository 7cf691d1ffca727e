// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_calls.h
// The parts of fuzz_calls: kernels, meshes, and the same calls through the C interface.
#pragma once
#include <span>
#include <vector>

#include <dgm/asset.h>
#include <dgm/deform.h>
#include <dgm/reconstruct.h>

#include "support/dice.h"

namespace dgm::test {

/// Any kernel, legal more often than not. `values` keeps the user's table.
[[nodiscard]] KernelOptions random_kernel(Dice& dice, std::vector<float>& values);

/// Meshes in any format, stride and topology; indices must name vertices, and nothing beyond the memory is written.
void reconstruct_any(Dice& dice, const Chart& chart);
void reconstruct_any(Dice& dice, const State& state);

/// Makes any calls on states of the asset's charts, and keeps the promises of fuzz_calls_program.cpp.
void call_all(Dice& dice, const Asset& asset);

/// Opens the bytes and makes any calls of dgm.h.
void call_c(Dice& dice, std::span<const std::byte> bytes);

}  // namespace dgm::test
