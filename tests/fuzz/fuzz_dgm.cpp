// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_dgm.cpp
// The .dgm container as HDF5 reads it. Promises: the two ways of reading agree on what is a good file, and findings
// carry a code; nothing but model::Error is thrown.
#include "bytes_file.h"
#include "dgm/dgm_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm;
    const test::BytesFile file(data, size);
    formats::DgmReadLimits limits;
    limits.max_layer_bytes = 1 << 24;
    limits.max_charts = 1 << 10;
    limits.max_layers = 1 << 12;
    const formats::FileFindings findings = formats::check_container(file.path(), limits);
    bool any_error = false;
    for (const formats::Finding& finding : findings) {
        test::require(finding.code != nullptr && !finding.message.empty());
        any_error |= finding.severity == formats::Severity::kError;
    }
    try {
        const model::MapSet maps = formats::read_dgm(file.path(), limits);
        test::require(!any_error);
    } catch (const model::Error&) { test::require(any_error); }
    return 0;
}
