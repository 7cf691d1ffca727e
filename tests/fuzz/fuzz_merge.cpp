// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_merge.cpp
// Reports that are put together. Promises: the order makes no difference; a merged report merges again, into itself;
// nothing but model::Error is thrown.
#include <string>

#include "batch/merge_reports.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm;
    static std::string other;  // the last report that was one
    const bake::NamedReport first{"first.json", std::string(reinterpret_cast<const char*>(data), size)};
    try {
        const bake::MergedReport alone = bake::merge_reports({first});
        const bake::NamedReport again{"again.json", alone.text};
        test::require(bake::merge_reports({again}).text == alone.text);
        if (other.empty()) other = first.text;
        const bake::NamedReport second{"second.json", other};
        test::require(bake::merge_reports({first, second}).text == bake::merge_reports({second, first}).text);
        other = first.text;
    } catch (const model::Error& error) { test::require(error.what()[0] != 0); }
    return 0;
}
