// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/rehashed_files.cpp
// rehashed_files dgm|exr FIRST COUNT FOLDER: writes mutants by number (rehashed_maps.h) as FOLDER/NUMBER.dgm or .exr,
// for the programs themselves.
// rehashed_files mend FILE...: makes the hashes of changed .dgm files fit again.
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "rehashed_maps.h"
#include "support/rehash.h"

namespace {
void write_files(bool is_exr, std::uint64_t first, std::uint64_t count, const std::filesystem::path& folder) {
    for (std::uint64_t number = first; number < first + count; ++number) {
        std::uint8_t bytes[8];
        std::memcpy(bytes, &number, sizeof bytes);
        dgm::test::Dice dice(bytes);
        const auto path = folder / (std::to_string(number) + (is_exr ? ".exr" : ".dgm"));
        const std::string file = is_exr ? dgm::test::rehashed_exr(dice, path) : dgm::test::rehashed_dgm(dice, path);
        std::ofstream(path, std::ios::binary).write(file.data(), static_cast<std::streamsize>(file.size()));
    }
}

void mend_file(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    std::string file{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    dgm::test::mend_hashes(file);
    std::ofstream out(path, std::ios::binary);
    out.write(file.data(), static_cast<std::streamsize>(file.size()));
    if (!in || !out.flush()) throw std::runtime_error("cannot change " + path.string());
}
}  // namespace

int main(int argc, char** argv) {
    const bool mends = argc > 2 && std::strcmp(argv[1], "mend") == 0;
    if (!mends && argc != 5) return 1;
    try {
        for (int k = 2; mends && k < argc; ++k) mend_file(argv[k]);
        if (!mends)
            write_files(std::strcmp(argv[1], "exr") == 0, std::strtoull(argv[2], nullptr, 10),
                        std::strtoull(argv[3], nullptr, 10), argv[4]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "rehashed_files: %s\n", error.what());
        return 1;
    }
    return 0;
}
