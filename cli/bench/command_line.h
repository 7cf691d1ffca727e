// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/command_line.h
#pragma once

namespace dgm::bench {

/// The whole program but for its workers. @return the exit code
int bench_program(int argc, char** argv);

}  // namespace dgm::bench
