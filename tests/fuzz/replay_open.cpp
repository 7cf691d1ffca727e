// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/replay_open.cpp
// replay_open FOLDER: every file of the corpus, and of each its truncations and byte flips, without libFuzzer.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "fuzz_open.h"

namespace {
using File = std::vector<std::uint8_t>;

void replay(const File& file) {
    exercise_runtime(file.data(), file.size());
    for (std::size_t size = 0; size < file.size(); size += 64) exercise_runtime(file.data(), size);
    // Header, records and the first bytes of the layers; beyond, a coarser net.
    File mutant = file;
    for (std::size_t k = 0; k < file.size(); k += k < 1600 ? 1 : 13) {
        for (const std::uint8_t value :
             {std::uint8_t(file[k] ^ 1), std::uint8_t(~file[k]), std::uint8_t(0xFF), std::uint8_t(0)}) {
            mutant[k] = value;
            exercise_runtime(mutant.data(), mutant.size());
        }
        mutant[k] = file[k];
    }
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 1;
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator(argv[1])) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    for (const auto& path : paths) {
        std::ifstream in(path, std::ios::binary);
        const File file{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
        std::printf("%s: %zu bytes\n", path.filename().c_str(), file.size());
        replay(file);
    }
    return paths.empty() ? 2 : 0;
}
