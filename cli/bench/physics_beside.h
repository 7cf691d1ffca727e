// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/physics_beside.h
// What obstacles add to the time of an implicit step of dgm::physics.
#pragma once
#include "bench/physics_sweep.h"
#include "bench/run_sweep.h"

namespace dgm::bench {

/// An empty table for add_beside_rows().
[[nodiscard]] Table beside_table();
/// Times of steps of a body alone, under a plane, and under a surface of its own shape that stays, goes or is written
/// anew. One cycle; multigrid; the first length of a step. No rows if the body refuses physics.
/// @throws model::Error kInterrupted
void add_beside_rows(Table& table, const Subject& subject, const PhysicsSweepOptions& options);

}  // namespace dgm::bench
