// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_hash.h
// Hashes that let a reader tell a damaged EXR: OpenEXR itself guards packed pixels only.
#pragma once
#include <string>

#include "model/map_set.h"

namespace dgm::formats {

/// XXH3-128 of the layer's bytes, 32 hexadecimal digits in canonical byte order: the attribute
/// `dgmChart<k>.hash.<layer>`.
[[nodiscard]] std::string exr_layer_hash(const model::Layer& layer);

/// XXH3-128 of all else that the file says: names, hashes, report, charts, shapes and attributes of layers. The
/// attribute `dgmHeaderHash`; SPEC.md section 5 has the text that is hashed.
[[nodiscard]] std::string exr_header_hash(const model::MapSet& maps);

}  // namespace dgm::formats
