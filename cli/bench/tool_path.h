// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/tool_path.h
// The path of the tools in a runtime sweep: local coordinates, a point a tick of a millisecond.
#pragma once
#include <dgm/state.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace dgm::bench {

/// A closed walk over the chart, 0.15 grid steps a tick, that presses up to 2.5 mean steps deep and lifts off again.
[[nodiscard]] std::vector<Vec3> stroke_path(const State& state, std::size_t ticks);

/// Steps to neighbouring samples at random depths, and every fiftieth tick or so a leap to any sample of the surface.
[[nodiscard]] std::vector<Vec3> random_path(const State& state, std::size_t ticks);

/// The recording that the program carries with it, of a user who presses, pokes and pulls a stomach for 3.3 s
/// (samples/paths/recorded_touch.csv), put on this chart: at the same place of the map, as high over the surface in
/// shares of the diagonal, straight between its lines, and again from the start until there are enough.
[[nodiscard]] std::vector<Vec3> replayed_path(const State& state, std::size_t ticks);

/// Where one or several tools are in each tick.
struct ToolWay {
    std::uint32_t tools = 1;
    std::vector<Vec3> places;           ///< tick by tick, tool by tool
    std::vector<std::uint8_t> engaged;  ///< the same: 0 where a tool is away; empty: none ever is

    [[nodiscard]] std::size_t ticks() const { return places.size() / tools; }
    [[nodiscard]] Vec3 place(std::size_t tick, std::uint32_t tool) const { return places[tick * tools + tool]; }
    [[nodiscard]] bool is_engaged(std::size_t tick, std::uint32_t tool) const {
        return engaged.empty() || engaged[tick * tools + tool] != 0;
    }
};

/// A recording: "x y z" a line in source units, lines that begin with # left out; or a path as samples/paths has them
/// and pages record them (formats/path), with all of its tools, which touch whatever they did. Repeated from the start
/// until there are enough ticks. `offset` is Chart::offset().
/// @throws model::Error kFileMissing, kReadFailed with the line that is none, as formats::ToolPath
[[nodiscard]] ToolWay recorded_path(const std::filesystem::path& file, const double (&offset)[3], std::size_t ticks);

}  // namespace dgm::bench
