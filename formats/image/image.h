// SPDX-License-Identifier: GPL-3.0-or-later
// formats/image/image.h
// Pictures in and out: textures and bump maps from disk, PNG to disk.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "model/tri_mesh.h"

namespace dgm::formats {

/// Largest side of a picture that is read or written.
inline constexpr std::uint32_t kMaxImageSide = 16384;

/// 8-bit RGBA, sRGB, straight alpha; row-major, row 0 at the top.
struct Image {
    std::uint32_t width = 0, height = 0;
    std::vector<model::Rgba8> pixels;  ///< width * height
    [[nodiscard]] const model::Rgba8& at(std::uint32_t x, std::uint32_t y) const {
        return pixels[std::size_t{y} * width + x];
    }
    friend bool operator==(const Image&, const Image&) = default;
};

/// One plane of heights, 0..1; row 0 at the top.
struct FloatImage {
    std::uint32_t width = 0, height = 0;
    std::vector<float> pixels;  ///< width * height
    [[nodiscard]] float at(std::uint32_t x, std::uint32_t y) const { return pixels[std::size_t{y} * width + x]; }
    friend bool operator==(const FloatImage&, const FloatImage&) = default;
};

/// 16-bit gray; row 0 at the top.
struct GrayImage16 {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint16_t> pixels;  ///< width * height
    friend bool operator==(const GrayImage16&, const GrayImage16&) = default;
};

/// Reads PNG, JPEG, BMP, TGA, GIF (first frame), PSD or PNM as 8-bit RGBA. The size is checked before decoding.
/// Thread-safe. @throws model::Error kFileMissing, kReadFailed, kImageUnreadable, kTooLarge; std::bad_alloc if memory
/// is short, which says nothing about the picture
[[nodiscard]] Image read_image(const model::PictureFile& picture);

/// The same, as heights 0..1: 16-bit pictures keep their 16 bits; colours become gray by stb_image's integer luma.
/// Thread-safe. @throws as read_image
[[nodiscard]] FloatImage read_height(const model::PictureFile& picture);

/// Bits of a number of the picture: 8, or 16 where read_height keeps them. Thread-safe. @throws as read_image
[[nodiscard]] unsigned image_bits(const model::PictureFile& picture);

/// What the three functions above do, by another way; thread-safe and with their errors.
struct ImageReader {
    std::function<Image(const model::PictureFile&)> image;
    std::function<FloatImage(const model::PictureFile&)> height;
    std::function<unsigned(const model::PictureFile&)> bits;
};
/// They in this process, whatever set_image_reader() says.
[[nodiscard]] const ImageReader& image_reader_here();
/// From now on they call `reader`; an empty one ends that. Not thread-safe.
void set_image_reader(ImageReader reader);

/// PNG file bytes: RGBA, no time or text chunks, so equal pictures give equal bytes.
/// @throws model::Error kTooLarge if a side is 0 or beyond kMaxImageSide, kInternal if pixels do not fit the size
[[nodiscard]] std::vector<std::byte> encode_png(const Image& image);
[[nodiscard]] std::vector<std::byte> encode_png(const GrayImage16& image);

/// JPEG file bytes, without alpha; `quality` 1..100, colours at full resolution above 90. Equal pictures give equal
/// bytes.
/// @throws model::Error as encode_png
[[nodiscard]] std::vector<std::byte> encode_jpeg(const Image& image, int quality);

/// Writes encode_png(image) to exactly `path`. @throws also kWriteFailed; nothing is left behind then
void write_png(const std::filesystem::path& path, const Image& image);
void write_png(const std::filesystem::path& path, const GrayImage16& image);

}  // namespace dgm::formats
