// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/bake_program.h
// dgm-bake as a function, so that a test can run the real program around a bake that crashes.
#pragma once
#include "worker/worker.h"

namespace dgm::bake {

/// Runs the command line, or one worker if that is what the arguments ask for. Prints results on stdout, everything
/// else on stderr; never throws. @return the process's exit code (docs/design.md section 8)
[[nodiscard]] int bake_program(int argc, char** argv, const BakeFunction& bake);

}  // namespace dgm::bake
