// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/main.cpp
// dgm-bench: speed against error, on the user's own assets.
#include "baking/pipeline.h"
#include "bench/command_line.h"
#include "tool/guarded_main.h"
#include "worker/worker.h"

int main(int argc, char** argv) {
    return dgm::tool::guarded_main("dgm-bench", [&] {
        if (dgm::bake::is_worker(argc, argv)) return dgm::bake::run_worker(dgm::bake::bake_asset);
        return dgm::bench::bench_program(argc, argv);
    });
}
