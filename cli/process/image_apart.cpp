// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/image_apart.cpp
#include "process/image_apart.h"

#include <memory>
#include <new>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "model/codes.h"
#include "process/apart_answer.h"
#include "process/byte_stream.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;
using formats::FloatImage;
using formats::Image;
using model::PictureFile;

constexpr unsigned kMostSeconds = 120;
/// The file, its 16-bit pixels (2 GiB), and what is made of them.
constexpr std::uint64_t kMostMemory = std::uint64_t{8} << 30;
constexpr std::uint64_t kMostHeadBytes = 1 << 20;  ///< of an error's message

enum class Task : std::uint8_t { kColours, kHeight, kBits };

std::string encode(Task task, const PictureFile& picture) {
    ByteWriter out;
    out.put(task);
    out.put(picture.path.native());
    out.put(static_cast<char>(picture.bytes != nullptr));
    if (picture.bytes) out.put(*picture.bytes);
    return out.take();
}

std::string size_of(std::uint32_t width, std::uint32_t height) {
    ByteWriter out;
    out.put(width);
    out.put(height);
    return out.take();
}

bool answer(const formats::ImageReader& decoder, Task task, const PictureFile& picture) {
    if (task == Task::kBits) return send_head(size_of(decoder.bits(picture), 1));
    if (task == Task::kHeight) {
        const FloatImage image = decoder.height(picture);
        return send_head(size_of(image.width, image.height)) && send_array(image.pixels);
    }
    const Image image = decoder.image(picture);
    return send_head(size_of(image.width, image.height)) && send_array(image.pixels);
}

/// In the disposable process.
void work(const formats::ImageReader& decoder, std::string_view bytes) {
    ByteReader in(bytes);
    const Task task = in.get<Task>();
    PictureFile picture{.path = in.text()};
    if (in.get<char>() != 0) picture.bytes = std::make_shared<const std::string>(in.text());
    Sandbox sandbox{.readable = {}, .writable = {}, .cpu_seconds = kMostSeconds};
    if (!picture.bytes) sandbox.readable.push_back(picture.path);
    answer_in_sandbox(sandbox, kMostMemory, [&] { return answer(decoder, task, picture); });
}

/// The two numbers of the head. nullopt if they do not come, or are no sides of a picture.
std::optional<std::pair<std::uint32_t, std::uint32_t>> receive_size(ApartAnswer& from) {
    const std::optional<std::string> head = from.head(kMostHeadBytes);
    if (!head) return std::nullopt;
    ByteReader in(*head);
    const auto width = in.get<std::uint32_t>(), height = in.get<std::uint32_t>();
    const auto is_side = [](std::uint32_t side) { return side > 0 && side <= formats::kMaxImageSide; };
    if (!in.at_end() || !is_side(width) || !is_side(height)) return std::nullopt;
    return std::pair(width, height);
}

/// @throws model::Error kImageUnreadable; std::bad_alloc if memory is short, which says nothing about the picture
[[noreturn]] void fail(ApartAnswer& from, const PictureFile& picture) {
    const std::string why = from.failure("the decoder", kMostSeconds);
    if (from.lacked_memory()) throw std::bad_alloc();
    throw model::Error(codes::kImageUnreadable, why, picture.path.string());
}

template <class Picture>
Picture read(ForkServer& server, Task task, const PictureFile& picture) {
    ApartAnswer from(server, encode(task, picture));
    Picture out;
    if (const auto size = receive_size(from)) {
        std::tie(out.width, out.height) = *size;
        if (from.array(out.pixels, std::uint64_t{out.width} * out.height)) return out;
    }
    fail(from, picture);
}

}  // namespace

ImageApart::ImageApart(const formats::ImageReader& decoder)
    : server_(
          {.work = [&](std::string_view request) { work(decoder, request); }, .prepare = {}, .seconds = kMostSeconds}) {
    formats::set_image_reader(
        {.image = [this](const PictureFile& picture) { return read<Image>(server_, Task::kColours, picture); },
         .height = [this](const PictureFile& picture) { return read<FloatImage>(server_, Task::kHeight, picture); },
         .bits =
             [this](const PictureFile& picture) {
                 ApartAnswer from(server_, encode(Task::kBits, picture));
                 if (const auto bits = receive_size(from)) return static_cast<unsigned>(bits->first);
                 fail(from, picture);
             }});
}

ImageApart::~ImageApart() {
    formats::set_image_reader({});
}

}  // namespace dgm::bake
