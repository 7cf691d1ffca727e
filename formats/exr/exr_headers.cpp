// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_headers.cpp
// Layout after "The OpenEXR File Layout" (openexr.com): magic, version and flags, then headers of attributes (name,
// type, size, value; an empty name ends the header), then, if there are several parts, an empty header.
#include "exr/exr_headers.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include "exr/exr_layout.h"
#include "model/codes.h"
#include "model/file_errors.h"

namespace dgm::formats {
namespace {

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kTiledFlag = 0x200, kDeepFlag = 0x800, kMultipartFlag = 0x1000;
constexpr std::size_t kMaxNameBytes = 255;
/// Room for one block of rows that OpenEXR may take whatever the file's size: small files have blocks of more rows than
/// the image has.
constexpr std::uint64_t kSmallBlock = std::uint64_t{1} << 26;

struct FixedSize {
    std::string_view type;
    std::uint32_t bytes;
};
constexpr std::array kFixedSizes = {FixedSize{"box2f", 16},
                                    FixedSize{"box2i", 16},
                                    FixedSize{"chromaticities", 32},
                                    FixedSize{"compression", 1},
                                    FixedSize{"double", 8},
                                    FixedSize{"envmap", 1},
                                    FixedSize{"float", 4},
                                    FixedSize{"int", 4},
                                    FixedSize{"keycode", 28},
                                    FixedSize{"lineOrder", 1},
                                    FixedSize{"m33f", 36},
                                    FixedSize{"m33d", 72},
                                    FixedSize{"m44f", 64},
                                    FixedSize{"m44d", 128},
                                    FixedSize{"rational", 8},
                                    FixedSize{"tiledesc", 9},
                                    FixedSize{"timecode", 8},
                                    FixedSize{"v2d", 16},
                                    FixedSize{"v2f", 8},
                                    FixedSize{"v2i", 8},
                                    FixedSize{"v3d", 24},
                                    FixedSize{"deepImageState", 1},
                                    FixedSize{"v3f", 12},
                                    FixedSize{"v3i", 12}};

/// Rows that are packed together, by the number of the compression. 0: none that OpenEXR 3.1 knows.
std::uint32_t rows_of_block(std::uint8_t compression) {
    constexpr std::array<std::uint32_t, 10> kRows = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
    return compression < kRows.size() ? kRows[compression] : 0;
}

class Headers {
 public:
    Headers(const std::filesystem::path& path, std::uint64_t file_bytes, std::uint64_t max_pixels, std::uint64_t budget)
        : path_(path), left_(file_bytes), max_pixels_(max_pixels), budget_(budget), in_(path, std::ios::binary) {
        if (!in_) throw model::Error(model::codes::kReadFailed, "the file cannot be read", path.string());
    }

    void check(int max_parts) {
        if (u32() != kMagic) refuse("no EXR: the first bytes are others");
        const std::uint32_t version = u32();
        const bool several = (version & kMultipartFlag) != 0;
        if ((version & 255) > 2) refuse("a later version of EXR");
        if ((version & (kTiledFlag | kDeepFlag)) != 0) refuse("tiles or deep pixels, and geometry maps have neither");
        for (int part = 0; part == 0 || several; ++part) {
            if (part > max_parts) refuse("impossible number of parts");
            if (!check_header(several)) {
                if (part == 0) refuse("an empty header");
                return;
            }
        }
    }

 private:
    struct Part {
        bool has_window = false, has_channels = false, has_compression = false, is_rows = false;
        std::array<std::int32_t, 4> window{};
        std::uint64_t pixel_bytes = 0;
        std::uint32_t block_rows = 0;
    };

    [[noreturn]] void refuse(const std::string& message) const {
        throw model::Error(model::codes::kExrUnreadable, message, path_.string());
    }

    void take(char* out, std::uint64_t bytes) {
        if (bytes > left_ || !in_.read(out, static_cast<std::streamsize>(bytes))) refuse("the header is cut off");
        left_ -= bytes;
    }
    void skip(std::uint64_t bytes) {
        if (bytes > left_ || !in_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur))
            refuse("the header is cut off");
        left_ -= bytes;
    }
    std::uint32_t u32() {
        std::array<char, 4> bytes{};
        take(bytes.data(), bytes.size());
        std::uint32_t value = 0;
        for (std::size_t k = bytes.size(); k-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[k]);
        return value;
    }
    std::string name() {
        std::string out;
        for (char letter = 0;; out.push_back(letter)) {
            take(&letter, 1);
            if (letter == 0) return out;
            if (out.size() == kMaxNameBytes) refuse("a name without end in the header");
        }
    }

    /// False: the header is empty.
    bool check_header(bool several) {
        Part part;
        bool any = false;
        for (std::string attribute = name(); !attribute.empty(); attribute = name()) {
            any = true;
            const std::string type = name();
            check_attribute(part, attribute, type);
        }
        if (!any) return false;
        if (!part.has_window || !part.has_channels || !part.has_compression || (several && !part.is_rows))
            refuse("a header lacks its data window, channels, compression, or is not of rows");
        check_pixels(part);
        return true;
    }

    void check_attribute(Part& part, const std::string& attribute, const std::string& type) {
        const std::uint32_t bytes = u32();
        const auto impossible = [&] { refuse("the header's attribute " + attribute + " has an impossible size"); };
        if (bytes > left_ || bytes > 0x7FFFFFFF) impossible();
        const std::uint64_t end = left_ - bytes;
        const auto* fixed = std::find_if(kFixedSizes.begin(), kFixedSizes.end(),
                                         [&](const FixedSize& known) { return known.type == type; });
        if (fixed != kFixedSizes.end() && fixed->bytes != bytes) impossible();
        if (type == "box2i" && attribute == "dataWindow") {
            part.has_window = true;
            for (std::int32_t& side : part.window) side = static_cast<std::int32_t>(u32());
        } else if (type == "compression" && attribute == "compression") {
            char number = 0;
            take(&number, 1);
            part.has_compression = true;
            part.block_rows = rows_of_block(static_cast<std::uint8_t>(number));
            if (part.block_rows == 0) refuse("an unknown compression");
        } else if (type == "chlist") {
            const std::uint64_t pixel = channels(end);
            if (attribute == "channels") {
                part.has_channels = true;
                part.pixel_bytes = pixel;
            }
        } else if (type == "string" && attribute == "type") {
            std::string kind(std::min<std::uint64_t>(bytes, kMaxNameBytes), '\0');
            take(kind.data(), kind.size());
            if (kind != "scanlineimage") refuse("tiles or deep pixels, and geometry maps have neither");
            part.is_rows = true;
        } else if (type == "stringvector") {
            while (left_ > end) skip(u32());
        } else if (type == "preview") {
            const std::uint64_t width = u32(), height = u32();
            if (bytes < 8 || width > bytes || height > bytes || 4 * width * height != bytes - 8) impossible();
            skip(bytes - 8);
        } else if (type == "idmanifest" || (type == "floatvector" && bytes % 4 != 0)) {
            impossible();  // the former unpacks to any size, and belongs to deep pixels
        } else {
            skip(bytes);
        }
        if (left_ != end) impossible();
    }

    /// Bytes of a pixel.
    std::uint64_t channels(std::uint64_t end) {
        std::uint64_t bytes = 0;
        while (!name().empty()) {
            bytes += u32() == 1 ? 2 : 4;  // half; float and uint
            skip(12);                     // linear, reserved, samplings
            if (left_ < end) break;
        }
        return bytes;
    }

    void check_pixels(const Part& part) const {
        const std::int64_t width = std::int64_t{part.window[2]} - part.window[0] + 1;
        const std::int64_t height = std::int64_t{part.window[3]} - part.window[1] + 1;
        if (part.window[0] != 0 || part.window[1] != 0 || width < 1 || height < 1 ||
            width > static_cast<std::int64_t>(kMaxExrWidth) + 1 ||
            height > static_cast<std::int64_t>(kMaxExrHeight) + 1 ||
            static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) > max_pixels_)
            refuse("a part has an impossible or too large data window");
        const std::uint64_t row = part.pixel_bytes * static_cast<std::uint64_t>(width);
        if (row > budget_ / static_cast<std::uint64_t>(height)) refuse("a part is larger than the file can back");
        if (row * part.block_rows > std::max(budget_, kSmallBlock))
            refuse("a part's rows are larger than the file can back");
    }

    const std::filesystem::path& path_;
    std::uint64_t left_;
    std::uint64_t max_pixels_;
    std::uint64_t budget_;
    std::ifstream in_;
};

}  // namespace

void check_exr_headers(const std::filesystem::path& path, std::uint64_t file_bytes, std::uint64_t max_pixels,
                       int max_parts, std::uint64_t budget) {
    Headers(path, file_bytes, max_pixels, budget).check(max_parts);
}

std::uint64_t exr_budget(const std::filesystem::path& path, const ExrReadLimits& limits) {
    namespace fs = std::filesystem;
    constexpr std::uint64_t kMaxZipRatio = 1032;
    std::error_code error;
    const auto status = fs::status(path, error);
    if (!fs::exists(status)) throw model::missing_file(path);
    const std::uint64_t bytes = fs::is_regular_file(status) ? fs::file_size(path, error) : 0;
    if (!fs::is_regular_file(status) || error) throw model::unreadable_file(path);
    const std::uint64_t budget = std::min(limits.max_total_bytes, bytes * kMaxZipRatio);
    check_exr_headers(path, bytes, limits.max_pixels_per_part, limits.max_parts, budget);
    return budget;
}

}  // namespace dgm::formats
