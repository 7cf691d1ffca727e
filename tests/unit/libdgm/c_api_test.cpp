// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/c_api_test.cpp
#include <gtest/gtest.h>

#include <dgm/deform.h>
#include <dgm/dgm.h>
#include <dgm/tick.h>

#include <cmath>

#include "opened.h"
#include "platform.h"

namespace dgm::test {
namespace {

template <class T>
T sized() {
    T t{};
    t.struct_size = sizeof t;
    return t;
}

struct Handles {
    Bytes bytes = build({grid_chart(17, 33, sheet, tube_seams(17, 33))}).bytes;
    dgm_asset* asset = nullptr;
    dgm_state* state = nullptr;
    dgm_table* table = nullptr;
    Handles() {
        auto kernel = sized<dgm_kernel_options>();
        kernel.reach = 5;
        kernel.sigma = 8;
        EXPECT_EQ(dgm_asset_open_memory(bytes.data(), bytes.size(), nullptr, nullptr, &asset, nullptr), DGM_OK);
        EXPECT_EQ(dgm_state_create(asset, 0, nullptr, nullptr, &state, nullptr), DGM_OK);
        EXPECT_EQ(dgm_table_create(&kernel, nullptr, &table, nullptr), DGM_OK);
    }
    ~Handles() {
        dgm_table_destroy(table);
        dgm_state_destroy(state);
        dgm_asset_close(asset);
    }
};

TEST(CApi, TickIsTheCppTick) {
    Handles h;
    State state = make_state(grid_chart(17, 33, sheet, tube_seams(17, 33)));
    KernelOptions kernel;
    kernel.reach = 5;
    kernel.sigma = 8;
    const DeformTable table = DeformTable::create(kernel).value();
    auto options = sized<dgm_tick_options>();
    options.d_max = 2;
    options.f_max = 3;
    TickOptions same;
    same.d_max = 2;
    same.f_max = 3;
    for (int k = 0; k < 50; ++k) {
        dgm_tool_input in[2] = {sized<dgm_tool_input>(), sized<dgm_tool_input>()};
        ToolInput want_in[2];
        for (std::uint32_t t = 0; t < 2; ++t) {
            want_in[t].tool = in[t].tool = t;
            in[t].kind = t;
            want_in[t].kind = static_cast<ToolKind>(t);
            want_in[t].engaged = k % 9 != 0;
            in[t].lifted = k % 9 == 0 ? 1 : 0;
            const Vec3 p{8 + 0.1f * float(k % 7), float((3 * k + 11 * int(t)) % 32), 0.5f - 0.2f * float(k % 5)};
            want_in[t].position = p;
            in[t].position[0] = p.x;
            in[t].position[1] = p.y;
            in[t].position[2] = p.z;
        }
        dgm_tool_output out[2] = {sized<dgm_tool_output>(), sized<dgm_tool_output>()};
        ToolOutput want[2];
        auto report = sized<dgm_tick_report>();
        ASSERT_EQ(dgm_tick(h.state, h.table, &options, in, 2, out, &report, nullptr), DGM_OK);
        const auto done = tick(state, table, same, want_in, want);
        ASSERT_TRUE(done.ok());
        EXPECT_EQ(report.contacts, done.value().contacts);
        EXPECT_EQ(report.samples, done.value().samples);
        EXPECT_EQ(report.crossed_seam, done.value().crossed_seam ? 1u : 0u);
        for (std::size_t t = 0; t < 2; ++t) {
            EXPECT_EQ(out[t].sample, want[t].sample);
            EXPECT_EQ(out[t].distance, want[t].distance);
            EXPECT_EQ(out[t].hit, want[t].hit ? 1u : 0u);
            EXPECT_EQ(out[t].holding, want[t].holding ? 1u : 0u);
            EXPECT_EQ(out[t].contact, want[t].contact);
            EXPECT_EQ((Vec3{out[t].force[0], out[t].force[1], out[t].force[2]}), want[t].force);
            EXPECT_EQ((Vec3{out[t].displacement[0], out[t].displacement[1], out[t].displacement[2]}),
                      want[t].displacement);
        }
        const float *p[3], *n[3];
        ASSERT_EQ(dgm_state_positions(h.state, p), 17u * 33);
        ASSERT_EQ(dgm_state_normals(h.state, n), 17u * 33);
        for (std::size_t s = 0; s < 17 * 33; ++s) {
            ASSERT_TRUE(same_bits({p[0][s], p[1][s], p[2][s]}, state.positions()[s]));
            ASSERT_TRUE(same_bits({n[0][s], n[1][s], n[2][s]}, state.normals()[s]));
        }
    }
    EXPECT_EQ(dgm_state_relax(h.state, 0.01f, 10, nullptr), DGM_OK);
    EXPECT_EQ(dgm_state_relax(h.state, 0.01f, -1, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_state_mean_step(h.state), state.mean_step());
}

TEST(CApi, TickRefusesWithoutHarm) {
    Handles h;
    auto options = sized<dgm_tick_options>();
    options.d_max = 1;
    auto in = sized<dgm_tool_input>();
    in.position[1] = NAN;
    auto error = sized<dgm_error>();
    EXPECT_EQ(dgm_tick(h.state, h.table, &options, &in, 1, nullptr, nullptr, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(error.code, static_cast<std::uint32_t>(DGM_BAD_ARGUMENT));
    in.position[1] = 3;
    EXPECT_EQ(dgm_tick(h.state, h.table, nullptr, &in, 1, nullptr, nullptr, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_tick(h.state, h.table, &options, nullptr, 1, nullptr, nullptr, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_tick(nullptr, h.table, &options, &in, 1, nullptr, nullptr, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_tick(h.state, h.table, &options, &in, 65, nullptr, nullptr, nullptr), DGM_BAD_ARGUMENT);
    in.struct_size = 0;
    EXPECT_EQ(dgm_tick(h.state, h.table, &options, &in, 1, nullptr, nullptr, nullptr), DGM_BAD_ARGUMENT);
    in.struct_size = sizeof in;
    EXPECT_EQ(dgm_tick(h.state, h.table, &options, &in, 1, nullptr, nullptr, nullptr), DGM_OK);
    EXPECT_EQ(dgm_tick(h.state, h.table, &options, nullptr, 0, nullptr, nullptr, nullptr), DGM_OK);
}

TEST(CApi, KernelsAndCertifiedTracking) {
    Handles h;
    auto kernel = sized<dgm_kernel_options>();
    kernel.shape = DGM_KERNEL_SHAPE_ELLIPTIC;
    kernel.reach = 8;
    kernel.radius_a = 6;
    kernel.radius_b = 3;
    dgm_table* table = nullptr;
    ASSERT_EQ(dgm_table_create(&kernel, nullptr, &table, nullptr), DGM_OK);
    EXPECT_NEAR(dgm_table_weight(table, 0, 3), std::exp(-1.0), 1e-6);
    EXPECT_NEAR(dgm_table_weight(table, 6, 0), std::exp(-1.0), 1e-6);
    EXPECT_NEAR(dgm_table_profile(table, 6), std::exp(-1.0), 1e-5);
    dgm_table_destroy(table);
    const float cone[2] = {1, 0};
    kernel.shape = DGM_KERNEL_SHAPE_USER;
    kernel.values = cone;
    kernel.value_count = 2;
    ASSERT_EQ(dgm_table_create(&kernel, nullptr, &table, nullptr), DGM_OK);
    EXPECT_NEAR(dgm_table_weight(table, 2, 0), 0.75, 1e-6);
    dgm_table_destroy(table);
    kernel.values = nullptr;
    EXPECT_EQ(dgm_table_create(&kernel, nullptr, &table, nullptr), DGM_BAD_ARGUMENT);
    const float tool[3] = {8, 20, 1};
    std::uint32_t sample = 0, certain = 0, lost = 9;
    ASSERT_EQ(dgm_nearest_sample(h.state, tool, &sample, nullptr, nullptr), DGM_OK);
    ASSERT_EQ(dgm_track_nearest(h.state, tool, 5 * 33 + 3, 2, &certain, nullptr, &lost, nullptr), DGM_OK);
    EXPECT_EQ(certain, sample);
    EXPECT_EQ(lost, 1u);
}

TEST(CApi, SameAnswersAsTheCppInterface) {
    Handles h;
    State state = make_state(grid_chart(17, 33, sheet, tube_seams(17, 33)));
    KernelOptions kernel;
    kernel.reach = 5;
    kernel.sigma = 8;
    const DeformTable table = DeformTable::create(kernel).value();
    EXPECT_EQ(dgm_table_weight(h.table, 2, 1), table.weight(2, 1));
    auto touch = sized<dgm_touch>();
    touch.sample = 8 * 33 + 1;
    touch.displacement[2] = 1.5f;
    touch.d_max = 1;
    auto report = sized<dgm_deform_report>();
    ASSERT_EQ(dgm_deform(h.state, h.table, &touch, &report, nullptr), DGM_OK);
    Touch same;
    same.sample = touch.sample;
    same.displacement = {0, 0, 1.5f};
    same.d_max = 1;
    const DeformReport want = deform(state, table, same).value();
    EXPECT_EQ(report.samples, want.samples);
    EXPECT_EQ(report.displacement[2], 1.0f);
    EXPECT_EQ(report.crossed_seam, 1u);
    std::vector<float> v(17 * 33 * 6);
    auto target = sized<dgm_vertex_target>();
    target.data = v.data();
    target.bytes = v.size() * 4;
    target.stride = 24;
    target.normal_offset = 12;
    target.uv_offset = DGM_NO_ATTRIBUTE;
    auto counts = sized<dgm_mesh_counts>();
    ASSERT_EQ(dgm_state_reconstruct(h.state, &target, nullptr, 0, &counts, nullptr), DGM_OK);
    EXPECT_EQ(counts.indices, 16u * 32 * 6);
    for (std::uint32_t k = 0; k < counts.vertices; ++k) {
        ASSERT_EQ((Vec3{v[6 * k], v[6 * k + 1], v[6 * k + 2]}), state.positions()[k]);
        ASSERT_EQ((Vec3{v[6 * k + 3], v[6 * k + 4], v[6 * k + 5]}), state.normal(k));
    }
    const float tool[3] = {8, 3, 5};
    std::uint32_t sample = 0, tracked = 0;
    float distance = 0, position[3];
    ASSERT_EQ(dgm_nearest_sample(h.state, tool, &sample, &distance, nullptr), DGM_OK);
    ASSERT_EQ(dgm_track_sample(h.state, tool, sample, 2, &tracked, nullptr, nullptr), DGM_OK);
    EXPECT_EQ(tracked, sample);
    ASSERT_EQ(dgm_state_position(h.state, sample, position, nullptr), DGM_OK);
    EXPECT_NEAR(distance, std::hypot(position[0] - 8, position[1] - 3, position[2] - 5), 1e-5);
    const std::uint32_t* members = nullptr;
    ASSERT_EQ(dgm_state_class_members(h.state, dgm_state_class_of(h.state, 33 * 3 + 32), &members), 2u);
    EXPECT_EQ(members[0], 33u * 3);
    float force[3];
    ASSERT_EQ(dgm_contact_force(report.displacement, 1, 4, force, nullptr), DGM_OK);
    EXPECT_EQ(force[2], -4.0f);
}

TEST(CApi, ErrorsCarryCodeMessageAndOffset) {
    Bytes bytes = build({grid_chart(3, 3, sheet)}).bytes;
    dgm_asset* asset = reinterpret_cast<dgm_asset*>(8);
    auto error = sized<dgm_error>();
    EXPECT_EQ(dgm_asset_open_memory(bytes.data(), bytes.size() - 64, nullptr, nullptr, &asset, &error), DGM_TRUNCATED);
    EXPECT_EQ(asset, nullptr);
    EXPECT_EQ(error.code, DGM_TRUNCATED);
    EXPECT_EQ(error.byte_offset, bytes.size() - 64);
    EXPECT_STREQ(dgm_code_name(error.code), "TRUNCATED");
    EXPECT_NE(std::string(error.message), "");
    EXPECT_EQ(dgm_asset_open("/nonexistent/x.dgm", nullptr, nullptr, &asset, &error),
              DGM_TEST_FILES ? DGM_FILE_MISSING : DGM_UNSUPPORTED);
    EXPECT_EQ(error.byte_offset, DGM_NO_OFFSET);
    EXPECT_EQ(dgm_asset_open(nullptr, nullptr, nullptr, &asset, &error), DGM_BAD_ARGUMENT);
    EXPECT_STREQ(dgm_code_name(12345), "UNKNOWN");
}

TEST(CApi, SizedStructsGoBothWays) {
    Handles h;
    // An older caller: only the first fields are written.
    auto info = sized<dgm_chart_info>();
    info.struct_size = offsetof(dgm_chart_info, domain);
    info.domain = 77;
    ASSERT_EQ(dgm_asset_chart(h.asset, 0, &info, nullptr), DGM_OK);
    EXPECT_EQ(info.rows, 17u);
    EXPECT_EQ(info.cols, 33u);
    EXPECT_EQ(info.domain, 77u);
    EXPECT_EQ(info.struct_size, offsetof(dgm_chart_info, domain));
    // A newer caller: fields we do not know must be 0.
    struct Newer {
        dgm_state_options known;
        std::uint64_t extra;
    } newer{};
    newer.known.struct_size = sizeof newer;
    dgm_state* state = nullptr;
    EXPECT_EQ(dgm_state_create(h.asset, 0, &newer.known, nullptr, &state, nullptr), DGM_OK);
    dgm_state_destroy(state);
    newer.extra = 1;
    EXPECT_EQ(dgm_state_create(h.asset, 0, &newer.known, nullptr, &state, nullptr), DGM_UNSUPPORTED);
    newer.known.struct_size = 0;
    EXPECT_EQ(dgm_state_create(h.asset, 0, &newer.known, nullptr, &state, nullptr), DGM_BAD_ARGUMENT);
}

TEST(CApi, NullIsRefusedOrHarmless) {
    Handles h;
    auto touch = sized<dgm_touch>();
    EXPECT_EQ(dgm_deform(nullptr, h.table, &touch, nullptr, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_deform(h.state, nullptr, &touch, nullptr, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_deform(h.state, h.table, nullptr, nullptr, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_nearest_sample(h.state, nullptr, nullptr, nullptr, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_asset_chart(nullptr, 0, nullptr, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_state_create(nullptr, 0, nullptr, nullptr, nullptr, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_asset_verify(nullptr, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_asset_chart_count(nullptr), 0u);
    EXPECT_EQ(dgm_state_sample_count(nullptr), 0u);
    dgm_state_release(nullptr);
    dgm_state_reset(nullptr);
    dgm_state_destroy(nullptr);
    dgm_table_destroy(nullptr);
    dgm_asset_close(nullptr);
    auto view = sized<dgm_layer_view>();
    EXPECT_EQ(dgm_asset_find_layer(h.asset, 0, "seams", &view, nullptr), DGM_OK);
    EXPECT_EQ(view.shape[0], 17u);
    EXPECT_EQ(dgm_asset_find_layer(h.asset, 0, "bump", &view, nullptr), DGM_MISSING_LAYER);
    EXPECT_EQ(dgm_asset_layer(h.asset, 1, 0, &view, nullptr), DGM_BAD_ARGUMENT);
}

}  // namespace
}  // namespace dgm::test
