// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/worker_protocol.h"

#include <gtest/gtest.h>

#include "model/codes.h"
#include "process/worker_io.h"

namespace dgm::bake {
namespace {

TEST(WorkerProtocol, PathsKeepEveryByte) {
    std::string all;
    for (int c = 1; c < 256; ++c) all += static_cast<char>(c);
    const std::string text = encode_path(all);
    for (const char c : text) EXPECT_TRUE(c > ' ' && c < '\x7f');
    EXPECT_EQ(decode_path(text).native(), all);
    EXPECT_EQ(encode_path("a b%.obj"), "a%20b%25.obj");
    for (const char* bad : {"%", "%2", "a%zz", "%2G"}) EXPECT_THROW((void)decode_path(bad), model::Error) << bad;
}

TEST(WorkerProtocol, JobComesBack) {
    WorkerJob job;
    job.source = "in/caf\xe9 \n.obj";
    job.dgm = "out/.x.dgm.7.tmp";
    job.exports = {"out/.x.glb.7.tmp/x.glb", "out/.x.obj.7.tmp/x \xe9.obj"};
    job.memory_bytes = std::uint64_t{8} << 30;
    job.threads = 3;
    job.cpu_seconds = 77;
    job.options.asset_roots = {"/lib rary/\xff", "b"};
    job.options.size = {33, 65};
    job.options.method = Method::kArap;
    job.options.domain = DomainChoice::kFree;
    job.options.fit = Fit::kL2;
    job.options.precision = Precision::kU16;
    job.options.layers = {"geometry", "bump"};
    job.options.texture = "denim.png";
    job.options.texture_size = GridSize{7, 9};
    job.options.bump_size = GridSize{5, 6};
    job.options.ablate = {"diagonals"};
    job.options.exr_layout = ExrLayout::kMultipart;
    job.options.auto_samples = 66049;
    job.options.any_aspect = true;
    job.options.max_error = ErrorGoal{0.1 + 0.2, false, ErrorKind::kHausdorff};
    job.options.budget_bytes = 262144;
    job.options.metres_per_unit = 0.0254;
    job.options.material_file = "folder/m.toml";
    job.options.material = Material{200, 0.25f, 0.1f, 3e4f, 5, 1e-3f};
    const WorkerJob back = decode_job(encode(job));
    EXPECT_EQ(back.source, job.source);
    EXPECT_EQ(back.dgm, job.dgm);
    EXPECT_TRUE(back.exr.empty());
    EXPECT_EQ(back.exports, job.exports);
    EXPECT_TRUE(back.options.write_dgm);
    EXPECT_FALSE(back.options.write_exr);  // no name for it, so it is not asked for
    EXPECT_EQ(back.memory_bytes, job.memory_bytes);
    EXPECT_EQ(back.cpu_seconds, 77u);
    EXPECT_EQ(back.options.asset_roots, job.options.asset_roots);
    EXPECT_EQ(back.threads, 3U);
    EXPECT_EQ(back.options.size, job.options.size);
    EXPECT_EQ(back.options.method, Method::kArap);
    EXPECT_EQ(back.options.domain, DomainChoice::kFree);
    EXPECT_EQ(back.options.fit, Fit::kL2);
    EXPECT_EQ(back.options.precision, Precision::kU16);
    EXPECT_EQ(back.options.layers, job.options.layers);
    EXPECT_EQ(back.options.texture, job.options.texture);
    EXPECT_EQ(back.options.texture_size, job.options.texture_size);
    EXPECT_EQ(back.options.bump_size, job.options.bump_size);
    EXPECT_EQ(back.options.ablate, job.options.ablate);
    EXPECT_EQ(back.options.exr_layout, ExrLayout::kMultipart);
    EXPECT_EQ(back.options.auto_samples, job.options.auto_samples);
    EXPECT_TRUE(back.options.any_aspect);
    EXPECT_EQ(back.options.max_error, job.options.max_error);
    EXPECT_EQ(back.options.budget_bytes, job.options.budget_bytes);
    EXPECT_EQ(back.options.scratch, job.dgm);  // searched sizes are written where the file will be
    EXPECT_EQ(back.options.metres_per_unit, 0.0254);
    EXPECT_EQ(back.options.material, job.options.material);
    EXPECT_EQ(back.options.material_file, job.options.material_file);
    EXPECT_FALSE(decode_job(encode(WorkerJob{})).options.max_error);
    EXPECT_FALSE(decode_job(encode(WorkerJob{})).options.material);
}

TEST(WorkerProtocol, MessagesComeBack) {
    const auto progress = decode_message(encode(WorkerMessage{ProgressMessage{"cut", 0.25}}));
    ASSERT_TRUE(progress && std::holds_alternative<ProgressMessage>(*progress));
    EXPECT_EQ(std::get<ProgressMessage>(*progress).stage, "cut");
    EXPECT_EQ(std::get<ProgressMessage>(*progress).share, 0.25);

    model::Error error(model::codes::kNonOrientable, "component 2\nhas one side", "x.obj:7");
    error.with_stage("repair");
    const std::string line = encode(WorkerMessage{ErrorMessage{error}});
    EXPECT_EQ(line.find('\n'), line.size() - 1);  // one message, one line
    const auto failure = decode_message(line);
    ASSERT_TRUE(failure && std::holds_alternative<ErrorMessage>(*failure));
    const model::Error& back = std::get<ErrorMessage>(*failure).error;
    EXPECT_EQ(&back.code(), &model::codes::kNonOrientable);
    EXPECT_STREQ(back.what(), "component 2\nhas one side");
    EXPECT_EQ(back.place(), "x.obj:7");
    EXPECT_EQ(back.stage(), "repair");

    BakeReport report;
    report.error.rms = 0.1;
    const auto result = decode_message(encode(WorkerMessage{ResultMessage{report, {}}}));
    ASSERT_TRUE(result && std::holds_alternative<ResultMessage>(*result));
    EXPECT_EQ(std::get<ResultMessage>(*result).report.error.rms, 0.1);

    const auto notice = decode_message(encode(WorkerMessage{NoticeMessage{{"textures", "texture missing: a\nb.png"}}}));
    ASSERT_TRUE(notice && std::holds_alternative<NoticeMessage>(*notice));
    EXPECT_EQ(std::get<NoticeMessage>(*notice).notice.kind, "textures");
    EXPECT_EQ(std::get<NoticeMessage>(*notice).notice.text, "texture missing: a\nb.png");

    const auto memory = decode_message(kOutOfMemoryLine);
    EXPECT_TRUE(memory && std::holds_alternative<OutOfMemoryMessage>(*memory));
}

TEST(WorkerProtocol, NonsenseIsNotAMessage) {
    for (const char* line : {"", "x", "[]", "{}", "{\"type\":1}", "{\"type\":\"progress\",\"stage\":\"cut\"}",
                             "{\"type\":\"progress\",\"stage\":\"cut\",\"share\":\"all\"}",
                             "{\"type\":\"result\",\"report\":{}}", "{\"type\":\"result\",\"report\":\"[]\"}",
                             "{\"type\":\"error\",\"code\":-1,\"message\":\"\",\"place\":\"\",\"stage\":\"\"}"})
        EXPECT_FALSE(decode_message(line)) << line;
    const auto unknown = decode_message(
        "{\"type\":\"error\",\"code\":77,\"message\":\"m\",\"place\":\"\",\"stage\":\"\",\"hint\":\"h\"}");
    ASSERT_TRUE(unknown);
    EXPECT_EQ(&std::get<ErrorMessage>(*unknown).error.code(), &model::codes::kInternal);
    EXPECT_STREQ(std::get<ErrorMessage>(*unknown).error.hint(), "h");
}

}  // namespace
}  // namespace dgm::bake
