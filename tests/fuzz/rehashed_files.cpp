// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/rehashed_files.cpp
// rehashed_files dgm|exr FIRST COUNT FOLDER: writes mutants by number (rehashed_maps.h) as FOLDER/NUMBER.dgm or .exr,
// for the programs themselves.
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>

#include "rehashed_maps.h"

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
}  // namespace

int main(int argc, char** argv) {
    if (argc != 5) return 1;
    try {
        write_files(std::strcmp(argv[1], "exr") == 0, std::strtoull(argv[2], nullptr, 10),
                    std::strtoull(argv[3], nullptr, 10), argv[4]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "rehashed_files: %s\n", error.what());
        return 1;
    }
    return 0;
}
