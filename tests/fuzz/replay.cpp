// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/replay.cpp
// replay_X FOLDER [MOST]: every file of the corpus, and of each its truncations and changed bytes, without libFuzzer.
// MOST bounds the changed files made of one seed [4000]; the first bytes, where headers are, get most of them.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "target.h"

namespace {
using File = std::vector<std::uint8_t>;

void replay(const File& file, std::size_t most) {
    LLVMFuzzerTestOneInput(file.data(), file.size());
    const std::size_t cuts = most / 8, changes = most / 4 - cuts / 4;
    const std::size_t step = std::max<std::size_t>(1, file.size() / std::max<std::size_t>(1, cuts));
    for (std::size_t size = 0; size < file.size(); size += step) {
        const File cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));  // its end is the heap's
        LLVMFuzzerTestOneInput(cut.data(), cut.size());
    }
    File mutant = file;
    const std::size_t dense = std::min(file.size(), changes / 2);
    const std::size_t coarse = std::max<std::size_t>(1, (file.size() - dense) / std::max<std::size_t>(1, changes / 2));
    for (std::size_t k = 0; k < file.size(); k += k < dense ? 1 : coarse) {
        for (const std::uint8_t value :
             {std::uint8_t(file[k] ^ 1), std::uint8_t(~file[k]), std::uint8_t(0xFF), std::uint8_t(0)}) {
            mutant[k] = value;
            LLVMFuzzerTestOneInput(mutant.data(), mutant.size());
        }
        mutant[k] = file[k];
    }
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 2 && argc != 3) return 1;
    const std::size_t most = argc == 3 ? std::strtoul(argv[2], nullptr, 10) : 4000;
    std::vector<std::filesystem::path> paths;
    std::error_code missing;
    for (const auto& entry : std::filesystem::directory_iterator(argv[1], missing)) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    for (const auto& path : paths) {
        std::ifstream in(path, std::ios::binary);
        const File file{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
        std::printf("%s: %zu bytes\n", path.filename().c_str(), file.size());
        std::fflush(stdout);
        replay(file, most);
    }
    return paths.empty() ? 2 : 0;
}
