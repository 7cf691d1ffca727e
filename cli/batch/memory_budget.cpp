// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/memory_budget.cpp
#include "batch/memory_budget.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <system_error>

#include "model/codes.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;

/// The least that a face takes in a file, without normals and texture coordinates.
constexpr double kTextBytesPerFace = 30, kBinaryBytesPerFace = 14;
/// Above what was measured on organs, garments and scans of 560 to 70 000 faces at 33x33 to 257x257, textures included.
constexpr double kPeakBase = 80e6, kPeakPerFace = 2000, kPeakPerSample = 2000;
/// Below what was measured at 1025x1025 and 2049x2049: 1216 bytes a sample without a fit, 1914 to 1988 with one.
constexpr double kLeastPerSample = 1200;
/// A search that may go to any size ends far below the largest one.
constexpr double kUsualSearchedSamples = 513.0 * 513.0;

std::optional<std::uint64_t> number_in(const fs::path& file) {
    std::uint64_t value = 0;
    if (std::ifstream in(file); in >> value) return value;
    return std::nullopt;  // "max", or no such file
}

/// The number after `key` in a file of "key: number" lines.
std::optional<std::uint64_t> field_in(const fs::path& file, const std::string& key) {
    std::ifstream in(file);
    for (std::string word; in >> word;) {
        std::uint64_t value = 0;
        if (word == key && in >> value) return value;
        in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    return std::nullopt;
}

/// Files of a control group, by version of the interface.
struct GroupFiles {
    const char *root, *limit, *taken, *droppable;
};
constexpr GroupFiles kVersion2{"/sys/fs/cgroup", "memory.max", "memory.current", "inactive_file"};
constexpr GroupFiles kVersion1{"/sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes",
                               "total_inactive_file"};

/// Memory that the limits of a group and of each above it leave. File pages that the kernel may drop at any time do not
/// count as taken.
std::uint64_t left_in(const GroupFiles& files, const std::string& own) {
    std::uint64_t left = std::numeric_limits<std::uint64_t>::max();
    const fs::path root = files.root;
    for (fs::path group = (root / own).lexically_normal(); group.native().size() >= root.native().size();
         group = group.parent_path()) {
        const auto limit = number_in(group / files.limit), taken = number_in(group / files.taken);
        if (!limit || !taken) continue;
        const std::uint64_t free = std::min(*taken, field_in(group / "memory.stat", files.droppable).value_or(0));
        left = std::min(left, *limit - std::min(*limit, *taken - free));
    }
    return left;
}

std::uint64_t left_in_groups() {
    std::uint64_t left = std::numeric_limits<std::uint64_t>::max();
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {  // "0::/job", or "5:memory:/job"
        const std::size_t path = line.rfind(":/");
        if (path == std::string::npos) continue;
        const std::string own = line.substr(path + 2);
        if (line.starts_with("0::")) left = std::min(left, left_in(kVersion2, own));
        if (line.find(":memory:") != std::string::npos) left = std::min(left, left_in(kVersion1, own));
    }
    return left;
}

}  // namespace

std::uint64_t estimate_peak(const fs::path& mesh_file, const BakeOptions& options) {
    std::error_code error;
    const std::uint64_t bytes = fs::file_size(mesh_file, error);
    if (error) return 0;
    std::string extension = mesh_file.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const bool is_text = extension == ".obj" || extension == ".off" || extension == ".dae" || extension == ".x3d";
    const double faces = static_cast<double>(bytes) / (is_text ? kTextBytesPerFace : kBinaryBytesPerFace);
    double samples = options.auto_samples
                         ? static_cast<double>(*options.auto_samples)
                         : static_cast<double>(options.size.rows) * static_cast<double>(options.size.cols);
    if (options.max_error || options.budget_bytes) samples = std::min(samples, kUsualSearchedSamples);
    return static_cast<std::uint64_t>(kPeakBase + kPeakPerFace * faces + kPeakPerSample * samples);
}

std::optional<model::Error> refuse_size(const BakeOptions& options, std::uint64_t memory_bytes) {
    if (memory_bytes == 0 || options.auto_samples || options.max_error || options.budget_bytes) return std::nullopt;
    const auto limit = static_cast<double>(memory_bytes);
    const double samples = static_cast<double>(options.size.rows) * static_cast<double>(options.size.cols);
    if (kLeastPerSample * samples <= limit) return std::nullopt;
    const double side = std::floor(std::sqrt(std::max(0.0, limit - kPeakBase) / kPeakPerSample));
    const double largest = std::clamp(side - std::fmod(side + 1, 2), double{kMinSide}, double{kMaxSide});  // odd
    return model::Error(
               model::codes::kWorkerMemory,
               fmt::format("a grid of {}x{} takes about {:.0f} GB of memory; {} MiB are enough for about {}x{}",
                           options.size.rows, options.size.cols, kPeakPerSample * samples / 1e9, memory_bytes >> 20,
                           largest, largest))
        .with_hint("ask for a smaller --size, or raise --memory-limit if the machine has as much");
}

std::uint64_t available_memory() {
    const std::uint64_t system = field_in("/proc/meminfo", "MemAvailable:").value_or(0) << 10;
    return std::min(system, left_in_groups());
}

std::uint64_t resident_memory(pid_t process) {
    std::uint64_t all = 0, resident = 0;
    std::ifstream in(fmt::format("/proc/{}/statm", process));
    return in >> all >> resident ? resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace dgm::bake
