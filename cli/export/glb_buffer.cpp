// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/glb_buffer.cpp
#include "export/glb_buffer.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <utility>

namespace dgm::exporter {
namespace {
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr const char* kCompression = "EXT_meshopt_compression";

std::size_t multiple_of_4(std::size_t bytes) {
    return (bytes + 3) / 4 * 4;
}

std::vector<std::byte> packed_vertices(const std::vector<std::byte>& data, std::size_t count, std::size_t stride) {
    std::vector<std::byte> out(meshopt_encodeVertexBufferBound(count, stride));
    meshopt_encodeVertexVersion(0);  // what the extension prescribes, whatever a later library prefers
    out.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(out.data()), out.size(), data.data(), count,
                                          stride));
    return out;
}

std::vector<std::byte> packed_faces(const std::vector<model::Face>& faces, std::size_t vertices) {
    const std::size_t corners = 3 * faces.size();
    std::vector<std::byte> out(meshopt_encodeIndexBufferBound(corners, vertices));
    meshopt_encodeIndexVersion(1);
    out.resize(
        meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(out.data()), out.size(), faces[0].data(), corners));
    return out;
}
}  // namespace

void GlbBuffer::copy_vertex(std::span<const std::byte> from, std::byte* to) {
    std::copy(from.begin(), from.end(), to);
}

std::size_t GlbBuffer::append(std::span<const std::byte> data) {
    bytes_.resize(multiple_of_4(bytes_.size()));
    const std::size_t place = bytes_.size();
    bytes_.insert(bytes_.end(), data.begin(), data.end());
    return place;
}

std::size_t GlbBuffer::add_view(std::span<const std::byte> data) {
    const std::size_t place = append(data);
    views_.push_back(Json{{"buffer", 0}, {"byteOffset", place}, {"byteLength", data.size()}});
    return views_.size() - 1;
}

GlbBuffer::Json GlbBuffer::compressed_view(std::span<const std::byte> packed, std::size_t count, std::size_t stride,
                                           const char* mode) {
    fallback_bytes_ = multiple_of_4(fallback_bytes_);
    const std::size_t place = append(packed);
    Json view{{"buffer", 1}, {"byteOffset", fallback_bytes_}, {"byteLength", count * stride}};
    view["extensions"] = Json{{kCompression, Json{{"buffer", 0},
                                                  {"byteOffset", place},
                                                  {"byteLength", packed.size()},
                                                  {"byteStride", stride},
                                                  {"mode", mode},
                                                  {"count", count}}}};
    fallback_bytes_ += count * stride;
    return view;
}

std::size_t GlbBuffer::add_attribute(const std::vector<std::byte>& data, std::size_t count, std::size_t stride,
                                     bool padded, int component, std::size_t numbers) {
    Json view = Json::object();
    if (compress_) {
        view = compressed_view(packed_vertices(data, count, stride), count, stride, "ATTRIBUTES");
    } else {
        const std::size_t place = append(data);
        view = Json{{"buffer", 0}, {"byteOffset", place}, {"byteLength", data.size()}};
    }
    if (padded) view["byteStride"] = stride;
    view["target"] = kArrayBuffer;
    views_.push_back(std::move(view));
    const std::size_t accessor = add_accessor(views_.size() - 1, component, count, "VEC" + std::to_string(numbers));
    if (component != kFloat) accessors_[accessor]["normalized"] = true;
    return accessor;
}

std::size_t GlbBuffer::add_indices(const std::vector<model::Face>& faces, std::size_t vertices) {
    const bool wide = vertices > 65535;  // 65535 means "restart" and is no vertex
    const std::size_t corners = 3 * faces.size(), stride = wide ? sizeof(std::uint32_t) : sizeof(std::uint16_t);
    Json view = Json::object();
    if (compress_) {
        view = compressed_view(packed_faces(faces, vertices), corners, stride, "TRIANGLES");
    } else {
        std::vector<std::uint16_t> narrow;
        for (std::size_t f = 0; !wide && f < faces.size(); ++f)
            for (const std::uint32_t v : faces[f]) narrow.push_back(static_cast<std::uint16_t>(v));
        const std::size_t place = append(wide ? std::as_bytes(std::span(faces)) : std::as_bytes(std::span(narrow)));
        view = Json{{"buffer", 0}, {"byteOffset", place}, {"byteLength", corners * stride}};
    }
    view["target"] = kElementArrayBuffer;
    views_.push_back(std::move(view));
    return add_accessor(views_.size() - 1, wide ? kUnsignedInt : kUnsignedShort, corners, "SCALAR");
}

std::size_t GlbBuffer::add_accessor(std::size_t view, int component, std::size_t count, const std::string& type) {
    accessors_.push_back(Json{{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
    return accessors_.size() - 1;
}

void GlbBuffer::describe(Json& root) const {
    root["accessors"] = accessors_;
    root["bufferViews"] = views_;
    root["buffers"] = Json::array({Json{{"byteLength", bytes_.size()}}});
    if (fallback_bytes_ == 0) return;
    Json fallback{{"byteLength", fallback_bytes_}};
    fallback["extensions"] = Json{{kCompression, Json{{"fallback", true}}}};
    root["buffers"].push_back(std::move(fallback));
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) root[list].push_back(kCompression);
}

}  // namespace dgm::exporter
