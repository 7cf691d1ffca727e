// SPDX-License-Identifier: GPL-3.0-or-later
// formats/path/tool_path.h
// A recorded tool path: where each tool was, what it did, and when a picture was taken.
#pragma once
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <dgm/tick.h>
#include <dgm/vec.h>

namespace dgm::formats {

/// Tools that a path may have.
inline constexpr std::uint32_t kMostTools = 4;

/// One line of a path file: `SECONDS X Y Z KIND [CAPTION]`, in the units and the frame of the mesh. KIND is touch,
/// poke, grasp or away; a caption asks for a picture at this moment. A line of another tool than the first has its
/// number behind KIND: `grasp:2`, up to 4. Times never go back, and increase from line to line of a tool. Lines that
/// begin with # are remarks.
struct Knot {
    double seconds = 0;
    Vec3 position;
    ToolKind kind = ToolKind::Touch;
    bool engaged = true;
    std::string caption;
    std::uint32_t tool = 0;  ///< from 0, as ToolInput::tool
};

/// How large and how deep a touch of the path is, by a remark `# ... Size 4.5, d_max 5 ...`; pages that record one
/// write it.
struct TouchSize {
    double size = 0;   ///< units of the mesh around the contact that follow the tool
    double d_max = 0;  ///< largest displacement, units of the mesh
    bool stays = false;
};

class ToolPath {
 public:
    /// @throws model::Error kReadFailed; kUsage, with the line, for one that is not as above or goes back in time
    explicit ToolPath(const std::filesystem::path& file);
    /// From a stream at its start; `file` is the place that errors name. @throws model::Error kUsage as above
    ToolPath(std::istream& in, const std::filesystem::path& file);

    /// The first remark that has one.
    [[nodiscard]] const std::optional<TouchSize>& touch_size() const { return touch_size_; }

    /// One more than the largest number of a tool.
    [[nodiscard]] std::uint32_t tool_count() const { return static_cast<std::uint32_t>(tracks_.size()); }

    /// A tool between its knots moves straight and at an even speed; it does what the knot behind it says. Before its
    /// first knot it is away; a tool without a knot is away at the origin.
    /// @param tool  below tool_count()
    [[nodiscard]] Knot at(double seconds, std::uint32_t tool = 0) const;

    /// Calls `tick(knots, dt)` for every step of `dt` seconds, with a std::span of one knot a tool, and
    /// `picture(caption)` after the tick that reaches a knot with a caption.
    template <class Tick, class Picture>
    void replay(double dt, Tick tick, Picture picture) const {
        std::vector<Knot> tools(tool_count());
        std::size_t next = 0;
        for (std::size_t step = 0; next < knots_.size(); ++step) {
            const double now = knots_.front().seconds + static_cast<double>(step) * dt;
            for (std::uint32_t tool = 0; tool < tools.size(); ++tool) tools[tool] = at(now, tool);
            tick(std::span<const Knot>(tools), static_cast<float>(dt));
            for (; next < knots_.size() && knots_[next].seconds <= now + dt / 2; ++next)
                if (!knots_[next].caption.empty()) picture(knots_[next].caption);
        }
    }
    /// As the file has them.
    [[nodiscard]] const std::vector<Knot>& knots() const { return knots_; }

 private:
    void add(Knot knot, const std::string& place);

    std::vector<Knot> knots_;
    std::vector<std::vector<std::size_t>> tracks_;  ///< of each tool: its knots
    std::optional<TouchSize> touch_size_;
};

}  // namespace dgm::formats
