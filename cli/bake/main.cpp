// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/bake_program.h"
#include "baking/pipeline.h"
#include "tool/guarded_main.h"

int main(int argc, char** argv) {
    return dgm::tool::guarded_main("dgm-bake",
                                   [&] { return dgm::bake::bake_program(argc, argv, dgm::bake::bake_asset); });
}
