// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/scene_test.cpp
// Many assets at once cost only their touched parts.
#include <gtest/gtest.h>

#include <dgm/deform.h>
#include <dgm/reconstruct.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "opened.h"
#include "platform.h"
#if DGM_TEST_PAGES
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#endif

namespace dgm::test {
namespace {

/// 257 x 257 samples with a texture.
ChartSpec big_chart(std::uint32_t texels = 64, std::uint8_t grey = 99) {
    ChartSpec chart = grid_chart(257, 257, sheet, tube_seams(257, 257));
    chart.add("texture", ElementType::kU8, {texels, texels, 4},
              std::vector<std::uint8_t>(std::size_t{texels} * texels * 4, grey));
    chart.add("cover", ElementType::kF32, {257, 257}, std::vector<float>(257 * 257, 1));
    return chart;
}

#if DGM_TEST_PAGES
/// A file with a hole wherever the bytes are 0 for whole pages: its unread pages are nowhere in memory.
struct SparseFile {
    static constexpr std::size_t kPage = 4096;
    std::string path;
    explicit SparseFile(const Bytes& bytes) {
        path = testing::TempDir() + "dgm_scene_" + std::to_string(::getpid()) + ".dgm";
        std::ofstream file(path, std::ios::binary);
        for (std::size_t at = 0; at < bytes.size(); at += kPage) {
            const auto* page = reinterpret_cast<const char*>(bytes.data() + at);
            const std::size_t size = std::min(kPage, bytes.size() - at);
            const bool last = at + size == bytes.size();
            if (!last && std::all_of(page, page + size, [](char c) { return c == 0; })) continue;
            file.seekp(static_cast<std::streamoff>(at));
            file.write(page, static_cast<std::streamsize>(size));
        }
    }
    ~SparseFile() { std::remove(path.c_str()); }
    /// Bytes of the file that are in memory.
    [[nodiscard]] std::size_t resident() const {
        const int file = ::open(path.c_str(), O_RDONLY);
        struct stat status = {};
        ::fstat(file, &status);
        const auto size = static_cast<std::size_t>(status.st_size);
        void* memory = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file, 0);
        std::vector<unsigned char> pages((size + kPage - 1) / kPage);
        EXPECT_EQ(::mincore(memory, size, pages.data()), 0);
        ::munmap(memory, size);
        ::close(file);
        return kPage * static_cast<std::size_t>(
                           std::count_if(pages.begin(), pages.end(), [](unsigned char c) { return (c & 1) != 0; }));
    }
};

TEST(Scene, ThousandAssetsCostWhatIsTouched) {
    const Bytes bytes = build({big_chart(2048, 0)}).bytes;
    const SparseFile file(bytes);
    std::vector<Asset> assets;
    assets.reserve(1000);
    std::uint64_t mapped = 0, heap = 0;
    for (int k = 0; k < 1000; ++k) {
        auto asset = Asset::open(file.path.c_str());
        ASSERT_TRUE(asset.ok()) << k << ": " << asset.error().message;
        mapped += asset.value().usage().mapped_bytes;
        heap += asset.value().usage().heap_bytes;
        assets.push_back(std::move(asset).value());
    }
    EXPECT_EQ(mapped, 1000 * bytes.size());
    EXPECT_LT(heap, 1000 * 2048u);
    // One of them is drawn and touched.
    State state = State::create(assets[500].chart(0).value()).value();
    // The texture, nine tenths of the file, was not looked at by any of this.
    EXPECT_LT(file.resident(), bytes.size() / 2) << "of " << bytes.size();
    EXPECT_GT(file.resident(), 257u * 257 * 12);
    const StateUsage still = state.usage();
    EXPECT_EQ(still.samples, 257u * 257u);
    EXPECT_EQ(still.active_samples, 0u);
    EXPECT_GT(still.bytes, 12 * 4 * 257 * 257u);
    EXPECT_LT(still.bytes, 135 * 257 * 257u);
    KernelOptions kernel;
    kernel.reach = 11;
    Touch touch;
    touch.sample = 128 * 257 + 128;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.footprint = Footprint::Grid;
    ASSERT_TRUE(deform(state, DeformTable::create(kernel).value(), touch).ok());
    EXPECT_EQ(state.usage().active_samples, 21u * 21u);
    EXPECT_EQ(state.usage().dirty_samples, 21u * 21u);
    state.update_normals();
    EXPECT_EQ(state.usage().dirty_samples, 0u);
    state.release();
    EXPECT_EQ(state.usage().active_samples, 0u);
}
#endif

TEST(Scene, StateTellsItsBytes) {
    struct Count {
        std::uint64_t bytes = 0;
    } count;
    StateOptions options;
    options.allocator = {&count,
                         [](void* user, std::size_t bytes, std::size_t alignment) -> void* {
                             static_cast<Count*>(user)->bytes += bytes;
                             return take_aligned(bytes, alignment);
                         },
                         [](void* user, void* memory, std::size_t bytes) {
                             static_cast<Count*>(user)->bytes -= bytes;
                             give_aligned(memory);
                         }};
    for (const ChartSpec& chart : {big_chart(), free_chart(65, 33, sheet)}) {
        const State state = State::create(Opened(build({chart})).chart(), options).value();
        EXPECT_EQ(state.usage().bytes, count.bytes);
    }
    EXPECT_EQ(count.bytes, 0u);
}

TEST(Scene, FabricsSwapWhileTheShapeStays) {
    // A cover pinched by a circular and an elliptic kernel, drawn with one fabric, then with another asset's of another
    // size: vertices are in uv, so nothing of the shape is asked or changed.
    ChartSpec jeans = grid_chart(33, 33, sheet), satin = grid_chart(2, 2, sheet);
    jeans.add("texture", ElementType::kU8, {8, 8, 4}, std::vector<std::uint8_t>(256, 40));
    satin.add("texture", ElementType::kU8, {32, 16, 4}, std::vector<std::uint8_t>(2048, 200));
    const Opened cover(build({jeans})), fabric(build({satin}));
    State state = State::create(cover.chart()).value();
    KernelOptions ellipse;
    ellipse.shape = KernelShape::Elliptic;
    ellipse.radius_a = 6;
    ellipse.radius_b = 2;
    Touch pinch;
    pinch.sample = 16 * 33 + 16;
    pinch.displacement = {0, 0, 2};
    pinch.d_max = 2;
    pinch.footprint = Footprint::Grid;
    ASSERT_TRUE(deform(state, DeformTable::create(ellipse).value(), pinch).ok());
    const float along = state.positions().z[12 * 33 + 16] - state.rest_positions().z[12 * 33 + 16];
    const float across = state.positions().z[16 * 33 + 12] - state.rest_positions().z[16 * 33 + 12];
    EXPECT_NEAR(along, 2 * std::exp(-16.0 / 36), 1e-5);
    EXPECT_NEAR(across, 2 * std::exp(-16.0 / 4), 1e-5);
    const auto vertices = [&] {
        std::vector<float> v(5 * 33 * 33);
        const VertexTarget target{std::as_writable_bytes(std::span(v)), 20, 0, kNoAttribute, 12};
        EXPECT_TRUE(reconstruct(state, target, {}).ok());
        return v;
    };
    const std::vector<float> before = vertices();
    LayerView texture = cover.chart().find("texture").value();
    EXPECT_EQ(std::to_integer<int>(texture.data[100]), 40);
    texture = fabric.chart().find("texture").value();
    EXPECT_EQ(std::to_integer<int>(texture.data[100]), 200);
    EXPECT_EQ(texture.shape[0], 32u);
    EXPECT_EQ(vertices(), before);
}

TEST(Scene, OnlyLayersAskedForAreListed) {
    Image image = build({big_chart(), free_chart(9, 9, sheet)});
    const char* const names[] = {"geometry"};
    OpenOptions options;
    options.layers = names;
    // A layer that was not asked for may be broken: it is not read.
    for (layout::LayerRecord& l : image.layers)
        if (std::string(l.name) == "texture") image.bytes[l.offset] = std::byte{1};
    EXPECT_FALSE(Opened(image).asset.verify().ok());
    const Opened opened(image, options);
    EXPECT_TRUE(opened.asset.verify().ok());
    EXPECT_EQ(opened.chart(0).layer_count(), 2u);
    EXPECT_TRUE(opened.chart(0).find("geometry").ok());
    EXPECT_TRUE(opened.chart(0).find("seams").ok()) << "a table, not a choice";
    EXPECT_EQ(opened.chart(0).find("texture").error().code, ErrorCode::MissingLayer);
    EXPECT_TRUE(opened.chart(1).find("border_faces").ok());
    EXPECT_TRUE(State::create(opened.chart(0)).ok());
    EXPECT_TRUE(State::create(opened.chart(1)).ok());
    options.required_layers = std::span<const char* const>();
    const char* const required[] = {"cover"};
    options.required_layers = required;
    EXPECT_EQ(Asset::open_memory(image.bytes, options).error().code, ErrorCode::MissingLayer);
}

}  // namespace
}  // namespace dgm::test
