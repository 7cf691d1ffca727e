// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/bake_result.h
#pragma once
#include "baking/bake_report.h"
#include "model/map_set.h"

namespace dgm::bake {

struct BakeResult {
    model::MapSet maps;
    BakeReport report;
};

}  // namespace dgm::bake
