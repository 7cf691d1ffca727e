// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/rehashed_maps.h
// Maps that somebody has made to do harm: content of every kind, then changes of index, layers, attributes and HDF5's
// structures, and all hashes and checksums made to fit again.
#pragma once
#include <filesystem>
#include <string>

#include "model/map_set.h"
#include "support/dice.h"

namespace dgm::test {

/// A map that validators accept, more often than not.
[[nodiscard]] model::MapSet random_map_set(Dice& dice);

/// The bytes of a changed file. `scratch` is a file that may be overwritten.
[[nodiscard]] std::string rehashed_dgm(Dice& dice, const std::filesystem::path& scratch);
/// An EXR whose hashes fit, since it is written with them; every other one is then changed beside what they guard.
[[nodiscard]] std::string rehashed_exr(Dice& dice, const std::filesystem::path& scratch);

}  // namespace dgm::test
