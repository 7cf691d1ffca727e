// SPDX-License-Identifier: GPL-3.0-or-later
// formats/image/image_read.cpp
#include <algorithm>
#include <climits>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <string_view>
#include <utility>

#include "files/regular_file.h"
#include "image/image.h"
#include "model/codes.h"

#ifndef __clang_analyzer__  // which finds leaks in it, where memory runs out
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#endif
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_MAX_DIMENSIONS 16384
// stb copies the empty chunk of a PNG to a null pointer, which memcpy() must not be given even for no bytes.
#define memcpy(to, from, count) ((count) > 0 ? std::memcpy(to, from, static_cast<std::size_t>(count)) : (to))
#include <stb_image.h>
#undef memcpy

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 30;
static_assert(STBI_MAX_DIMENSIONS == kMaxImageSide);

struct StbFree {
    void operator()(void* pixels) const { stbi_image_free(pixels); }
};

/// A picture file in memory, its header read and its size within the limits.
struct EncodedImage {
    std::shared_ptr<const std::string> file;
    int width = 0, height = 0, channels = 0;
    [[nodiscard]] const stbi_uc* bytes() const { return reinterpret_cast<const stbi_uc*>(file->data()); }
    [[nodiscard]] int size() const { return static_cast<int>(file->size()); }
    [[nodiscard]] std::size_t pixels() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
};

bool is_16_bit(const EncodedImage& image) {
    return stbi_is_16_bit_from_memory(image.bytes(), image.size()) != 0;
}

/// stb takes the bytes of such a picture for those of one with 8 bits when it changes the number of channels, and reads
/// beyond them; it also leaves them in the wrong order.
void refuse_16_bit_pnm(const EncodedImage& image, const fs::path& path) {
    if (image.file->starts_with('P') && is_16_bit(image))
        throw model::Error(codes::kImageUnreadable, "a PGM or PPM picture of 16 bits: store it as PNG", path.string());
}

/// stb sums up the digits of the three numbers at the head of a PGM or PPM picture as an int, however many there are.
bool has_long_number(std::string_view file) {
    constexpr std::size_t kMostDigits = 9;
    if (!file.starts_with("P5") && !file.starts_with("P6")) return false;
    constexpr std::string_view kSpace = " \t\n\v\f\r", kDigits = "0123456789";
    std::size_t at = 2;
    for (int number = 0; number < 3; ++number) {
        at = file.find_first_not_of(kSpace, at);
        while (at < file.size() && file[at] == '#') {
            at = file.find_first_of("\n\r", at);
            at = at < file.size() ? file.find_first_not_of(kSpace, at) : file.size();
        }
        if (at >= file.size()) return false;
        const std::size_t end = std::min(file.find_first_not_of(kDigits, at), file.size());
        if (end - at > kMostDigits) return true;
        at = end;
    }
    return false;
}

/// More than any format packs into a byte: PNG 8 x 1032 (deflate's longest match, of one-bit pixels), GIF 2730, JPEG
/// 512. So a few bytes that promise a picture of gigabytes take no memory.
constexpr std::uint64_t kMostPixelsPerByte = 16384;

void refuse_empty_promises(const EncodedImage& image, const fs::path& path) {
    if (image.pixels() / kMostPixelsPerByte > image.file->size())
        throw model::Error(codes::kImageUnreadable,
                           std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels in " +
                               std::to_string(image.file->size()) + " bytes: the file ends too early",
                           path.string());
}

/// stb counts the bytes of decoded pixels as an int.
void check_decoded(const EncodedImage& image, std::uint64_t channels, const fs::path& path) {
    const std::uint64_t bytes = std::uint64_t{image.pixels()} * channels * (is_16_bit(image) ? 2 : 1);
    if (bytes > static_cast<std::uint64_t>(INT_MAX))
        throw model::Error(codes::kTooLarge,
                           std::to_string(image.width) + " x " + std::to_string(image.height) +
                               " pixels of 16 bits: decoded it has 2 GiB or more; store it with 8 bits, or smaller",
                           path.string());
}

/// After check_decoded(): "outofmem" is then what it says.
[[noreturn]] void unreadable(const fs::path& path) {
    const char* reason = stbi_failure_reason();
    if (reason != nullptr && std::string_view(reason) == "outofmem") throw std::bad_alloc();
    throw model::Error(codes::kImageUnreadable, reason != nullptr ? reason : "unknown kind of picture", path.string());
}

void check_file_size(std::uint64_t size, const fs::path& path) {
    if (size > kMaxFileBytes)
        throw model::Error(codes::kTooLarge, "a picture file of " + std::to_string(size) + " bytes", path.string());
}

EncodedImage load(const model::PictureFile& picture) {
    const fs::path& path = picture.path;
    EncodedImage out;
    out.file =
        picture.bytes ? picture.bytes : std::make_shared<const std::string>(RegularFile(path).read_text(kMaxFileBytes));
    check_file_size(out.file->size(), path);
    if (has_long_number(*out.file))
        throw model::Error(codes::kImageUnreadable, "a PGM or PPM picture whose head has a number of over 9 digits",
                           path.string());
    if (out.size() == 0 || stbi_info_from_memory(out.bytes(), out.size(), &out.width, &out.height, &out.channels) == 0)
        unreadable(path);
    constexpr int kLimit = static_cast<int>(kMaxImageSide);
    if (out.width < 1 || out.height < 1 || out.width > kLimit || out.height > kLimit)
        throw model::Error(codes::kTooLarge,
                           std::to_string(out.width) + " x " + std::to_string(out.height) + " pixels; the limit is " +
                               std::to_string(kLimit) + " a side",
                           path.string());
    refuse_16_bit_pnm(out, path);
    refuse_empty_promises(out, path);
    return out;
}

Image image_here(const model::PictureFile& picture) {
    const EncodedImage encoded = load(picture);
    check_decoded(encoded, 4, picture.path);
    Image out;
    int width = 0, height = 0, channels = 0;
    const std::unique_ptr<stbi_uc, StbFree> pixels(
        stbi_load_from_memory(encoded.bytes(), encoded.size(), &width, &height, &channels, 4));
    if (!pixels || width != encoded.width || height != encoded.height) unreadable(picture.path);
    out.width = static_cast<std::uint32_t>(width);
    out.height = static_cast<std::uint32_t>(height);
    out.pixels.resize(encoded.pixels());
    for (std::size_t k = 0; k < out.pixels.size(); ++k) {
        const stbi_uc* p = pixels.get() + 4 * k;
        out.pixels[k] = {p[0], p[1], p[2], p[3]};
    }
    return out;
}

unsigned bits_here(const model::PictureFile& picture) {
    return is_16_bit(load(picture)) ? 16 : 8;
}

FloatImage height_here(const model::PictureFile& picture) {
    const EncodedImage encoded = load(picture);
    check_decoded(encoded, static_cast<std::uint64_t>(encoded.channels), picture.path);
    FloatImage out;
    int width = 0, height = 0, channels = 0;
    out.pixels.resize(encoded.pixels());
    if (is_16_bit(encoded)) {
        const std::unique_ptr<stbi_us, StbFree> pixels(
            stbi_load_16_from_memory(encoded.bytes(), encoded.size(), &width, &height, &channels, 1));
        if (!pixels || width != encoded.width || height != encoded.height) unreadable(picture.path);
        for (std::size_t k = 0; k < out.pixels.size(); ++k)
            out.pixels[k] = static_cast<float>(pixels.get()[k]) / 65535.0f;
    } else {
        const std::unique_ptr<stbi_uc, StbFree> pixels(
            stbi_load_from_memory(encoded.bytes(), encoded.size(), &width, &height, &channels, 1));
        if (!pixels || width != encoded.width || height != encoded.height) unreadable(picture.path);
        for (std::size_t k = 0; k < out.pixels.size(); ++k)
            out.pixels[k] = static_cast<float>(pixels.get()[k]) / 255.0f;
    }
    out.width = static_cast<std::uint32_t>(width);
    out.height = static_cast<std::uint32_t>(height);
    return out;
}

ImageReader& image_reader() {
    static ImageReader reader = image_reader_here();
    return reader;
}

}  // namespace

Image read_image(const model::PictureFile& picture) {
    return image_reader().image(picture);
}

FloatImage read_height(const model::PictureFile& picture) {
    return image_reader().height(picture);
}

unsigned image_bits(const model::PictureFile& picture) {
    return image_reader().bits(picture);
}

const ImageReader& image_reader_here() {
    static const ImageReader here{image_here, height_here, bits_here};
    return here;
}

void set_image_reader(ImageReader reader) {
    if (!reader.image) reader = image_reader_here();
    image_reader() = std::move(reader);
}

}  // namespace dgm::formats
