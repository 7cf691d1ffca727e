// SPDX-License-Identifier: GPL-3.0-or-later
// formats/image/image_read.cpp
#include <climits>
#include <cstdio>
#include <memory>
#include <span>

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
#include <stb_image.h>

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
    std::vector<stbi_uc> bytes;
    int width = 0, height = 0;
    [[nodiscard]] int size() const { return static_cast<int>(bytes.size()); }
    [[nodiscard]] std::size_t pixels() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
};

[[noreturn]] void unreadable(const fs::path& path) {
    const char* reason = stbi_failure_reason();
    throw model::Error(codes::kImageUnreadable, reason != nullptr ? reason : "unknown kind of picture", path.string());
}

EncodedImage load(const fs::path& path) {
    RegularFile file(path);
    const std::uint64_t size = file.size();
    if (size > kMaxFileBytes)
        throw model::Error(codes::kTooLarge, "a picture file of " + std::to_string(size) + " bytes", path.string());
    EncodedImage out;
    out.bytes.resize(size);
    out.bytes.resize(file.read(std::as_writable_bytes(std::span(out.bytes))));
    int channels = 0;
    if (out.bytes.empty() ||
        stbi_info_from_memory(out.bytes.data(), out.size(), &out.width, &out.height, &channels) == 0)
        unreadable(path);
    constexpr int kLimit = static_cast<int>(kMaxImageSide);
    if (out.width < 1 || out.height < 1 || out.width > kLimit || out.height > kLimit)
        throw model::Error(codes::kTooLarge,
                           std::to_string(out.width) + " x " + std::to_string(out.height) + " pixels; the limit is " +
                               std::to_string(kLimit) + " a side",
                           path.string());
    return out;
}

}  // namespace

Image read_image(const fs::path& path) {
    const EncodedImage encoded = load(path);
    Image out;
    int width = 0, height = 0, channels = 0;
    const std::unique_ptr<stbi_uc, StbFree> pixels(
        stbi_load_from_memory(encoded.bytes.data(), encoded.size(), &width, &height, &channels, 4));
    if (!pixels || width != encoded.width || height != encoded.height) unreadable(path);
    out.width = static_cast<std::uint32_t>(width);
    out.height = static_cast<std::uint32_t>(height);
    out.pixels.resize(encoded.pixels());
    for (std::size_t k = 0; k < out.pixels.size(); ++k) {
        const stbi_uc* p = pixels.get() + 4 * k;
        out.pixels[k] = {p[0], p[1], p[2], p[3]};
    }
    return out;
}

FloatImage read_height(const fs::path& path) {
    const EncodedImage encoded = load(path);
    FloatImage out;
    int width = 0, height = 0, channels = 0;
    out.pixels.resize(encoded.pixels());
    if (stbi_is_16_bit_from_memory(encoded.bytes.data(), encoded.size()) != 0) {
        const std::unique_ptr<stbi_us, StbFree> pixels(
            stbi_load_16_from_memory(encoded.bytes.data(), encoded.size(), &width, &height, &channels, 1));
        if (!pixels || width != encoded.width || height != encoded.height) unreadable(path);
        for (std::size_t k = 0; k < out.pixels.size(); ++k)
            out.pixels[k] = static_cast<float>(pixels.get()[k]) / 65535.0f;
    } else {
        const std::unique_ptr<stbi_uc, StbFree> pixels(
            stbi_load_from_memory(encoded.bytes.data(), encoded.size(), &width, &height, &channels, 1));
        if (!pixels || width != encoded.width || height != encoded.height) unreadable(path);
        for (std::size_t k = 0; k < out.pixels.size(); ++k)
            out.pixels[k] = static_cast<float>(pixels.get()[k]) / 255.0f;
    }
    out.width = static_cast<std::uint32_t>(width);
    out.height = static_cast<std::uint32_t>(height);
    return out;
}

}  // namespace dgm::formats
