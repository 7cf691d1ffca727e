// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/process/exr_apart_test.cpp
#include "process/exr_apart.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <random>
#include <thread>

#include "exr/exr_writer.h"
#include "model/codes.h"
#include "process/worker_io.h"
#include "test_maps.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;
using formats::ExrHead;

ExrHead sample() {
    ExrHead out;
    out.maps = test::random_maps(2, 5);
    out.multipart = true;
    out.beside = {"texture", "\xff"};
    return out;
}

TEST(ExrApart, AllComesBack) {
    const ExrHead in = sample();
    std::vector<std::uint64_t> sizes;
    auto out = decode_exr(encode_exr(in), {}, sizes);
    ASSERT_TRUE(out);
    EXPECT_TRUE(out->multipart);
    EXPECT_EQ(out->beside, in.beside);
    auto size = sizes.begin();
    for (std::size_t c = 0; c < in.maps.charts.size(); ++c)
        for (std::size_t l = 0; l < in.maps.charts[c].layers.size(); ++l) {
            EXPECT_EQ(*size++, in.maps.charts[c].layers[l].bytes.size());
            out->maps.charts[c].layers[l].bytes = in.maps.charts[c].layers[l].bytes;
        }
    EXPECT_EQ(size, sizes.end());
    EXPECT_EQ(out->maps, in.maps);
}

TEST(ExrApart, OtherBytesAreRefused) {
    const std::string bytes = encode_exr(sample());
    std::vector<std::uint64_t> sizes;
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(decode_exr(bytes.substr(0, size), {}, sizes)) << size;
    EXPECT_FALSE(decode_exr(bytes + "x", {}, sizes));
    for (std::size_t k = 0; k < bytes.size(); ++k) {  // whatever is sent: no crash, no memory beyond what came
        std::string other = bytes;
        other[k] = static_cast<char>(other[k] ^ 0x80);
        if (k > 0) static_cast<void>(decode_exr(other, {}, sizes));
    }
    ExrHead wrong = sample();
    wrong.maps.charts[0].layers[0].bytes.pop_back();
    EXPECT_FALSE(decode_exr(encode_exr(wrong), {}, sizes)) << "a size that does not follow from the shape";
    EXPECT_FALSE(decode_exr(bytes, {.max_total_bytes = 8}, sizes)) << "more than was allowed";
    EXPECT_EQ(test::code_of([&] { (void)decode_exr(encode_exr(model::Error(codes::kBadVersion, "x")), {}, sizes); }),
              codes::kBadVersion.number);
}

TEST(ExrApart, ReadsWhatIsReadHere) {
    const test::TempFolder folder;
    const model::MapSet maps = test::random_maps(3, 11);
    formats::write_exr(maps, folder / "a.exr");
    const ExrHead head = formats::read_exr_head(folder / "a.exr");
    const ExrApart exr;
    EXPECT_EQ(formats::read_exr(folder / "a.exr"), maps);
    EXPECT_EQ(formats::read_exr_head(folder / "a.exr").maps, head.maps);
    EXPECT_EQ(formats::read_exr_head(folder / "a.exr").beside, head.beside);
    test::write_bytes(folder / "bad.exr", "no picture");
    EXPECT_EQ(test::code_of([&] { (void)formats::read_exr(folder / "bad.exr"); }), codes::kExrUnreadable.number);
    EXPECT_EQ(test::code_of([&] { (void)formats::read_exr(folder / "none.exr"); }), codes::kFileMissing.number);
    std::vector<std::thread> readers;  // several at a time
    for (int k = 0; k < 4; ++k)
        readers.emplace_back([&] {
            for (int n = 0; n < 5; ++n) EXPECT_EQ(formats::read_exr(folder / "a.exr"), maps);
        });
    for (std::thread& reader : readers) reader.join();
}

TEST(ExrApart, SurvivesMutants) {
    const test::TempFolder folder;
    formats::write_exr(test::random_maps(1, 7), folder / "a.exr");
    const std::string original = test::read_bytes(folder / "a.exr");
    const ExrApart exr;
    std::mt19937 random(20);
    int refused = 0;
    for (int mutant = 0; mutant < 100; ++mutant) {
        std::string file = original;
        for (unsigned changes = 1 + random() % 8; changes > 0; --changes)
            file[random() % std::min<std::size_t>(file.size(), 2000)] = static_cast<char>(random());
        test::write_bytes(folder / "m.exr", file);
        refused += test::code_of([&] { (void)formats::read_exr(folder / "m.exr"); }) != 0 ? 1 : 0;
    }
    EXPECT_GT(refused, 50);
}

TEST(ForkServer, TellsHowAProcessEnded) {
    ForkServer server({.work =
                           [](std::string_view request) {
                               if (request == "crash") raise(SIGSEGV);
                               if (request == "hang")
                                   for (;;) pause();
                               if (request == "throw") throw std::bad_alloc();
                               if (request == "flood")
                                   while (send_message(std::string(4096, 'x'))) {}
                               if (send_message(std::string(request) + "!")) _exit(0);
                           },
                       .prepare = {},
                       .seconds = 1});
    const auto answer = [&](const std::string& request) {
        ForkServer::Reply reply = server.ask(request);
        std::array<char, 64> bytes{};
        std::string text;
        if (request != "flood")
            while (const std::size_t n = reply.read(bytes.data(), bytes.size())) text.append(bytes.data(), n);
        const ChildEnd end = reply.end();
        return text + " " + std::to_string(end.exit_code) + " " + std::to_string(end.signal);
    };
    EXPECT_EQ(answer("hello"), "hello! 0 0");
    EXPECT_EQ(answer("crash"), " 0 " + std::to_string(SIGSEGV));
    EXPECT_EQ(answer("hang"), " 0 " + std::to_string(SIGALRM));
    EXPECT_EQ(answer("throw"), " 4 0");
    EXPECT_EQ(answer("flood"), " 0 " + std::to_string(SIGPIPE));
    EXPECT_EQ(answer("again"), "again! 0 0");
    EXPECT_EQ(test::code_of([&] { (void)server.ask(std::string(ForkServer::kMostBytes + 1, 'x')); }),
              codes::kReadFailed.number);
}

}  // namespace
}  // namespace dgm::bake
