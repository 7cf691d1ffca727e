// SPDX-License-Identifier: GPL-3.0-or-later
// formats/image/png_write.cpp
#include <png.h>

#include <csetjmp>
#include <cstring>
#include <memory>
#include <new>

#include "files/whole_file.h"
#include "image/image.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

void check_size(std::uint32_t width, std::uint32_t height, std::size_t pixels) {
    if (width == 0 || height == 0 || width > kMaxImageSide || height > kMaxImageSide)
        throw model::Error(codes::kTooLarge, "a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                                                 " pixels cannot be written");
    if (pixels != std::size_t{width} * height)
        throw model::Error(codes::kInternal, "pixels do not fit the picture's size");
}

/// Target of libpng's callbacks.
struct Sink {
    std::vector<std::byte>* bytes;
    bool out_of_memory = false;
};

void append(png_structp png, png_bytep data, png_size_t size) {
    auto& sink = *static_cast<Sink*>(png_get_io_ptr(png));
    // No exception may cross libpng's C frames.
    try {
        const auto* begin = reinterpret_cast<const std::byte*>(data);
        sink.bytes->insert(sink.bytes->end(), begin, begin + size);
    } catch (...) { sink.out_of_memory = true; }
}
void flush(png_structp) {}

/// libpng and zlib have no codes for what is wrong, only words.
[[noreturn]] void on_error(png_structp png, png_const_charp what) {
    if (std::strstr(what, "memory") != nullptr) static_cast<Sink*>(png_get_error_ptr(png))->out_of_memory = true;
    png_longjmp(png, 1);
}

/// libpng leaves by longjmp: nothing with a destructor lives in this frame.
bool encode_rows(png_structp png, png_infop info, std::uint32_t width, std::uint32_t height, int depth, int colour,
                 const png_byte* rows, std::size_t row_bytes) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_IHDR(png, info, width, height, depth, colour, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_BASE,
                 PNG_FILTER_TYPE_BASE);
    png_set_compression_level(png, 6);
    png_write_info(png, info);
    if (depth == 16) png_set_swap(png);
    for (std::uint32_t y = 0; y < height; ++y) png_write_row(png, rows + y * row_bytes);
    png_write_end(png, nullptr);
    return true;
}

std::vector<std::byte> encode(std::uint32_t width, std::uint32_t height, int depth, int colour, const void* rows,
                              std::size_t row_bytes) {
    std::vector<std::byte> out;
    Sink sink{&out};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, on_error, nullptr);
    png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
    bool good = info != nullptr;
    if (!good) {
        sink.out_of_memory = true;
    } else {
        png_set_write_fn(png, &sink, append, flush);
        good = encode_rows(png, info, width, height, depth, colour, static_cast<const png_byte*>(rows), row_bytes);
    }
    if (png != nullptr) png_destroy_write_struct(&png, &info);
    if (sink.out_of_memory) throw std::bad_alloc();
    if (!good) throw model::Error(codes::kInternal, "libpng cannot encode the picture");
    return out;
}

}  // namespace

std::vector<std::byte> encode_png(const Image& image) {
    static_assert(sizeof(model::Rgba8) == 4);
    check_size(image.width, image.height, image.pixels.size());
    return encode(image.width, image.height, 8, PNG_COLOR_TYPE_RGBA, image.pixels.data(), std::size_t{image.width} * 4);
}

std::vector<std::byte> encode_png(const GrayImage16& image) {
    check_size(image.width, image.height, image.pixels.size());
    return encode(image.width, image.height, 16, PNG_COLOR_TYPE_GRAY, image.pixels.data(),
                  std::size_t{image.width} * 2);
}

void write_png(const fs::path& path, const Image& image) {
    write_whole_file(path, encode_png(image));
}
void write_png(const fs::path& path, const GrayImage16& image) {
    write_whole_file(path, encode_png(image));
}

}  // namespace dgm::formats
