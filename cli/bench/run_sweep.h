// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/run_sweep.h
// dgm-bench run: cost of each choice of the runtime in a tick, and its distance from the exact answer.
#pragma once
#include <dgm/asset.h>
#include <dgm/state.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/columns.h"
#include "bench/progress_bar.h"
#include "bench/repeat.h"
#include "bench/table.h"
#include "bench/tick_times.h"
#include "bench/tool_path.h"

namespace dgm::bench {

struct RunSweepOptions {
    std::vector<std::filesystem::path> assets;  ///< meshes, which are baked first, or .dgm files
    std::vector<std::uint32_t> sizes{81, 257};  ///< of the meshes; the paper's 81 is added if it is not there
    std::size_t ticks = 100'000;
    std::filesystem::path path;  ///< recorded positions (tool_path.h); empty: the program's own recording
    double time_limit_seconds = 600;
};

/// One chart that is touched, the largest of its file.
struct Subject {
    std::string asset, grid;
    Chart chart;
    bool paper_grid = false;

    /// A fresh state, max_reach 65. @throws model::Error kReadFailed with what the runtime says
    [[nodiscard]] State state() const;
};

/// @throws model::Error kInterrupted; exceptions of bakes and reads
[[nodiscard]] Run sweep_runtime(const RunSweepOptions& options, bool quiet);

/// The largest chart of each map, and of each mesh baked into `folder` at each size. @throws what bakes and reads throw
void each_subject(const std::vector<std::filesystem::path>& assets, const std::vector<std::uint32_t>& sizes,
                  const std::filesystem::path& folder, double time_limit_seconds, ProgressBar& bar,
                  const std::function<void(const Subject&)>& visit);

/// Where the tool goes.
enum class Path { kStroke, kRandom, kRecorded };
inline constexpr Path kPaths[] = {Path::kStroke, Path::kRandom, Path::kRecorded};
/// "stroke", "random", "recorded".
[[nodiscard]] const char* name_of(Path path);
/// So many ticks, local coordinates, a millisecond apart. The recorded one is the user's, else the program's own.
[[nodiscard]] ToolWay path_for(const Subject& subject, Path kind, const RunSweepOptions& options, std::size_t ticks);

/// The columns that name the touched asset, then the rest.
[[nodiscard]] std::vector<Column> subject_columns(const std::vector<Column>& rest);
/// Those of SubjectRow::set_percentiles().
[[nodiscard]] std::vector<Column> percentile_columns();

/// A row about a subject.
class SubjectRow : public RowBuilder {
 public:
    SubjectRow(const Table& table, const Subject& subject);
    void set_percentiles(const TickTimes& times);
};

/// The parts of the sweep. Each makes its table once and adds rows for each subject.
[[nodiscard]] Table tick_table();
void add_tick_rows(Table& table, const Subject& subject, const RunSweepOptions& options, ProgressBar& bar);
[[nodiscard]] Table tracking_table();
void add_tracking_rows(Table& table, const Subject& subject, const RunSweepOptions& options);
[[nodiscard]] Table contact_table();
void add_contact_rows(Table& table, const Subject& subject);
[[nodiscard]] Table level_table();
void add_level_rows(Table& table, const Subject& subject);
/// Tables of exp of several sizes against exp itself: the same for every asset.
[[nodiscard]] Table kernel_table();

}  // namespace dgm::bench
