// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_merge.cpp
// Reports that are put together. Promises: the order makes no difference; a merged report merges again, into itself;
// what one process sends of it is what another reads; nothing but model::Error is thrown.
#include <string>

#include "batch/merge_reports.h"
#include "process/json_apart.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm;
    static std::string other;  // the last report that was one
    const std::string text(reinterpret_cast<const char*>(data), size);
    try {
        const bake::NamedReport first{"first.json", bake::parse_json(text, "first.json")};
        test::require(bake::decode_json(bake::encode_json(first.report)) == first.report);
        const bake::MergedReport alone = bake::merge_reports({first});
        const bake::NamedReport again{"again.json", bake::parse_json(alone.text, "again.json")};
        test::require(bake::merge_reports({again}).text == alone.text);
        if (other.empty()) other = text;
        const bake::NamedReport second{"second.json", bake::parse_json(other, "second.json")};
        test::require(bake::merge_reports({first, second}).text == bake::merge_reports({second, first}).text);
        other = text;
    } catch (const model::Error& error) { test::require(error.what()[0] != 0); }
    return 0;
}
