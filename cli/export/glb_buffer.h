// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/glb_buffer.h
// The binary chunk of a .glb, and the buffer views and accessors that point into it; compressed on request.
//
// [EXT_meshopt_compression] A. Kapoulkine. EXT_meshopt_compression, a vendor extension of glTF 2.0. Vertex attributes
// are stored in its mode ATTRIBUTES, bitstream version 0; triangles in its mode TRIANGLES, version 1. No filters: what
// is decoded is what went in, but that a triangle may begin with another of its corners.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/vec.h"

namespace dgm::exporter {

/// Names of glTF's numbers, section 5.
inline constexpr int kByte = 5120, kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;

class GlbBuffer {
 public:
    using Json = nlohmann::ordered_json;

    explicit GlbBuffer(bool compress) : compress_(compress) {}

    /// A view of bytes that are stored as they are: a picture. @return its number
    std::size_t add_view(std::span<const std::byte> data);

    /// An accessor of vertices of N numbers each in a view of its own. What is not float is stored in multiples of four
    /// bytes a vertex, and read as -1..1 or 0..1. @return its number
    template <class Number, std::size_t N>
    std::size_t add_vertices(const std::vector<std::array<Number, N>>& values, int component) {
        constexpr std::size_t kStride = (N * sizeof(Number) + 3) / 4 * 4;
        std::vector<std::byte> bytes(values.size() * kStride);
        for (std::size_t v = 0; v < values.size(); ++v)
            copy_vertex(std::as_bytes(std::span(values[v])), &bytes[v * kStride]);
        return add_attribute(bytes, values.size(), kStride, kStride != N * sizeof(Number), component, N);
    }

    /// An accessor of triangles' corners, u16 up to 65535 vertices, else u32. @return its number
    std::size_t add_indices(const std::vector<model::Face>& faces, std::size_t vertices);

    [[nodiscard]] Json& accessor(std::size_t number) { return accessors_[number]; }

    /// Puts accessors, bufferViews and buffers into a document. The buffer may not grow afterwards.
    void describe(Json& root) const;
    [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
    static void copy_vertex(std::span<const std::byte> from, std::byte* to);
    std::size_t add_attribute(const std::vector<std::byte>& data, std::size_t count, std::size_t stride, bool padded,
                              int component, std::size_t numbers);
    std::size_t add_accessor(std::size_t view, int component, std::size_t count, const std::string& type);
    /// The place of `data` in the chunk. Views start at multiples of 4, which suits every component type.
    std::size_t append(std::span<const std::byte> data);
    /// A view of `packed`, which stands for `bytes` bytes that no file holds.
    Json compressed_view(std::span<const std::byte> packed, std::size_t count, std::size_t stride, const char* mode);

    bool compress_;
    Json views_ = Json::array(), accessors_ = Json::array();
    std::vector<std::byte> bytes_;
    std::size_t fallback_bytes_ = 0;  ///< of the buffer that decoded views would fill
};

}  // namespace dgm::exporter
