// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/test_maps.h
// Map sets with every layer and every bit pattern, and what tests of files need.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "model/map_set.h"
#include "support/temp_folder.h"

namespace dgm::test {

/// splitmix64: the same numbers on every machine.
class Random {
 public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next();
    std::uint64_t below(std::uint64_t bound) { return next() % bound; }
    double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }

 private:
    std::uint64_t state_;
};

struct MapChoice {
    std::uint32_t rows = 17, cols = 13;
    bool free_domain = false;
    bool u16_geometry = false;
    bool same_size_textures = false;
    bool unknown_layers = false;  ///< layers of no known name, of every type and rank
};

/// One chart with all layers of docs/design.md section 4. Bytes are random bits, NaNs and all: a container does not
/// judge.
[[nodiscard]] model::Chart random_chart(Random& random, const MapChoice& choice);
/// `charts` charts of various kinds.
[[nodiscard]] model::MapSet random_maps(std::uint64_t seed, std::size_t charts);

/// Number of the code of the model::Error that `action` throws; 0 if it throws none.
[[nodiscard]] int code_of(const std::function<void()>& action);

[[nodiscard]] std::string read_bytes(const std::filesystem::path& path);
void write_bytes(const std::filesystem::path& path, const std::string& bytes);

}  // namespace dgm::test
