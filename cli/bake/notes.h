// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/notes.h
// Notes that many meshes of a batch share, said once at the end.
#pragma once
#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "baking/bake_options.h"

namespace dgm::bake {

class Notes {
 public:
    void add(std::size_t asset, const Notice& notice);
    /// "notes: open border (fine for cloth, odd for an organ) on 43 of 45 meshes; ...; -v tells which". Empty if there
    /// are none.
    [[nodiscard]] std::string line(std::size_t assets) const;

 private:
    std::vector<std::pair<std::string, std::set<std::size_t>>> kinds_;  ///< with their assets, in order of appearance
};

}  // namespace dgm::bake
