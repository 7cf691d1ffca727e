// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/sample_asset.cpp
#include "bench/sample_asset.h"

#include "generate/organs.h"

namespace dgm::bench {

std::filesystem::path make_sample_asset(const std::filesystem::path& folder) {
    return samples::write_organ(samples::make_stomach(samples::kOrganTexture), folder);
}

}  // namespace dgm::bench
