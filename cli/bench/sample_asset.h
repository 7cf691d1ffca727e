// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/sample_asset.h
// The asset that is measured if none is named.
#pragma once
#include <filesystem>

namespace dgm::bench {

/// Makes the sample stomach of dgm-make-samples, textures and all, in `folder`: the same bytes on every run, so that
/// figures of two machines are of one mesh. @return path of stomach.obj. @throws model::Error kWriteFailed
[[nodiscard]] std::filesystem::path make_sample_asset(const std::filesystem::path& folder);

}  // namespace dgm::bench
