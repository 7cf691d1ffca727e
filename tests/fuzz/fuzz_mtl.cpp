// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_mtl.cpp
// Material libraries, and the names of libraries and pictures in them. Promises: pictures are found or warned of;
// nothing but model::Error is thrown.
#include <cmath>
#include <string>

#include "bytes_file.h"
#include "mesh/mtl_reader.h"
#include "model/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm;
    const test::BytesFile file(data, size);
    formats::FileFinder finder("/nonexistent/mesh.obj");
    formats::MtlLibrary library;
    std::vector<std::string> warnings;
    std::vector<std::filesystem::path> dependencies;
    try {
        formats::read_mtl(file.path(), finder, library, warnings, dependencies);
        const std::string statement(reinterpret_cast<const char*>(data), size < 4096 ? size : 4096);
        formats::read_mtl_libraries({&statement, 1}, finder, library, warnings, dependencies);
    } catch (const model::Error&) {}  // a refusal
    for (const auto& [name, material] : library)
        test::require(!std::isnan(material.uv_scale.x) && !std::isnan(material.uv_offset.y));
    for (const std::string& warning : warnings) test::require(!warning.empty());
    return 0;
}
