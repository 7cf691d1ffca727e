// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_image.h
// One picture as an EXR of one part, as every program reads it.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace dgm::formats {

/// Writes FLOAT channels with ZIP compression; the windows are the picture. Equal pictures give equal bytes.
/// @param channels  one letter each: "RGBA" or "RGB"
/// @param pixels    row-major from the top, channels interleaved in the order of `channels`
/// @throws model::Error kWriteFailed (nothing is left behind), kInternal if the pixels do not fit the size
void write_exr_image(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
                     std::string_view channels, std::span<const float> pixels);

}  // namespace dgm::formats
