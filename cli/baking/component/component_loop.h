// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/component_loop.h
// The same work on every component of a mesh, several at a time.
#pragma once
#include <cstddef>
#include <functional>

#include "model/progress.h"

namespace dgm::bake {

/// Calls work(k, progress) for k = 0 .. count - 1, on several threads; each call may change the data of k alone, so
/// that results do not depend on the order. The progress handed on counts 0..1 of component k and may be used by its
/// call alone; `progress` gets all of them, one at a time, with the stage that the call named.
/// @throws the exception of the failed call of the lowest k; later components may then not have been started
void for_each_component(std::size_t count, const model::Progress& progress,
                        const std::function<void(std::size_t, const model::Progress&)>& work);

}  // namespace dgm::bake
