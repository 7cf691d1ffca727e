// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/process/exr_apart_test.cpp
#include "process/exr_apart.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstring>
#include <random>
#include <thread>
#include <tuple>

#include "exr/exr_writer.h"
#include "model/codes.h"
#include "process/error_stream.h"
#include "process/worker_io.h"
#include "support/faults.h"
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
    EXPECT_EQ(test::code_of([&] { throw_sent_error(encode_error(model::Error(codes::kBadVersion, "x"))); }),
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

/// A map whose layers an EXR file shows, and that file.
struct Painted {
    Painted() { formats::write_exr(maps, folder / "a.exr"); }
    test::TempFolder folder;
    model::MapSet maps = test::random_maps(2, 9);
};

TEST(ExrApart, PlanesAndPicturesAreReadAsHere) {
    const Painted painted;
    const std::filesystem::path file = painted.folder / "a.exr";
    const std::vector<formats::ExrPlane> planes = formats::read_exr_planes(file, painted.maps.charts);
    ASSERT_GT(planes.size(), 5u);
    const ExrApart exr;
    const std::vector<formats::ExrPlane> apart = formats::read_exr_planes(file, painted.maps.charts);
    ASSERT_EQ(apart.size(), planes.size());
    for (std::size_t k = 0; k < planes.size(); ++k) {
        EXPECT_EQ(std::tie(apart[k].chart, apart[k].layer, apart[k].component, apart[k].meaning, apart[k].is_half,
                           apart[k].file),
                  std::tie(planes[k].chart, planes[k].layer, planes[k].component, planes[k].meaning, planes[k].is_half,
                           planes[k].file));
        ASSERT_EQ(apart[k].values.size(), planes[k].values.size());
        EXPECT_EQ(0, std::memcmp(apart[k].values.data(), planes[k].values.data(), 4 * planes[k].values.size()));
    }
    EXPECT_TRUE(formats::has_exr_description(file));
    EXPECT_FALSE(formats::has_exr_description(painted.folder / "none.exr"));
    EXPECT_EQ(test::code_of([&] { (void)formats::read_exr_picture(painted.folder / "none.exr"); }),
              codes::kFileMissing.number);
    EXPECT_EQ(test::code_of([&] { (void)formats::read_exr_planes(file, {}); }), codes::kEditUnrelated.number);
}

TEST(ExrApart, PlanesThatNoLayerHasAreRefused) {
    const std::vector<model::Chart> charts = test::random_maps(1, 9).charts;
    formats::ExrPlane good;
    std::vector<std::uint64_t> counts;
    std::uint64_t elements = 1;
    for (const std::uint64_t extent : charts[0].layers[0].shape) elements *= extent;
    good.values.resize(elements);
    EXPECT_TRUE(decode_planes(encode_planes({good}), charts, {}, counts));
    EXPECT_EQ(counts, std::vector<std::uint64_t>{elements});
    const auto is_refused = [&](const auto& change, const formats::ExrReadLimits& limits = {}) {
        formats::ExrPlane bad = good;
        change(bad);
        return !decode_planes(encode_planes({bad}), charts, limits, counts);
    };
    EXPECT_TRUE(is_refused([&](auto& p) { p.chart = charts.size(); }));
    EXPECT_TRUE(is_refused([&](auto& p) { p.layer = charts[0].layers.size(); }));
    EXPECT_TRUE(is_refused([](auto& p) { p.component = 1; }));
    EXPECT_TRUE(is_refused([](auto& p) { p.values.clear(); }));
    EXPECT_TRUE(is_refused([](auto& p) { p.values.pop_back(); }));
    EXPECT_TRUE(is_refused([](auto& p) { p.meaning = static_cast<formats::ExrPlane::Meaning>(4); }));
    EXPECT_TRUE(is_refused([](auto&) {}, {.max_total_bytes = 4 * elements - 1}));
    const std::string bytes = encode_planes({good, good});
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(decode_planes(bytes.substr(0, size), charts, {}, counts)) << size;
    EXPECT_FALSE(decode_planes(bytes + "x", charts, {}, counts));
}

TEST(ExrApart, WhateverTheReaderDoesIsAnErrorOfTheFile) {
    const Painted painted;
    const std::filesystem::path file = painted.folder / "a.exr";
    for (const auto& [name, fault] : test::faults()) {
        const auto run = [&, act = fault] { act(); };
        const formats::ExrPlaneReader reader{
            .planes = [run](const auto&, const auto&, const auto&) { return run(), std::vector<formats::ExrPlane>(); },
            .picture =
                [run](const auto&, const auto&) {
                    return run(), formats::ExrPicture{1, 1, 1, false, {0}};
                },
            .has_description = [run](const auto&) { return run(), true; }};
        const ExrApart exr(reader);
        EXPECT_EQ(test::code_of([&] { (void)formats::read_exr_planes(file, painted.maps.charts); }),
                  codes::kExrUnreadable.number)
            << name;
        EXPECT_EQ(test::code_of([&] { (void)formats::read_exr_picture(file); }), codes::kExrUnreadable.number) << name;
        EXPECT_FALSE(formats::has_exr_description(file)) << name;
    }
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
    EXPECT_EQ(answer(std::string(1 << 20, 'x')), std::string(1 << 20, 'x') + "! 0 0");
}

}  // namespace
}  // namespace dgm::bake
