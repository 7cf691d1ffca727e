// SPDX-License-Identifier: GPL-3.0-or-later
// formats/path/tool_path.h
// A recorded tool path: where the tool was, what it did, and when a picture was taken.
#pragma once
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include <dgm/tick.h>
#include <dgm/vec.h>

namespace dgm::formats {

/// One line of a path file: `SECONDS X Y Z KIND [CAPTION]`, in the units and the frame of the mesh. KIND is touch,
/// poke, grasp or away; a caption asks for a picture at this moment. Lines that begin with # are remarks.
struct Knot {
    double seconds = 0;
    Vec3 position;
    ToolKind kind = ToolKind::Touch;
    bool engaged = true;
    std::string caption;
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
    /// @throws model::Error kReadFailed, kUsage for a line that is not as above or goes back in time
    explicit ToolPath(const std::filesystem::path& file);
    /// From a stream at its start; `file` is the place that errors name. @throws model::Error kUsage as above
    ToolPath(std::istream& in, const std::filesystem::path& file);

    /// The first remark that has one.
    [[nodiscard]] const std::optional<TouchSize>& touch_size() const { return touch_size_; }

    /// The tool between knots moves straight and at an even speed; it does what the knot behind it says.
    [[nodiscard]] Knot at(double seconds) const;

    /// Calls `tick(knot, dt)` for every step of `dt` seconds, and `picture(caption)` after the tick that reaches a knot
    /// with a caption.
    template <class Tick, class Picture>
    void replay(double dt, Tick tick, Picture picture) const {
        std::size_t next = 0;
        for (std::size_t step = 0; next < knots_.size(); ++step) {
            const double now = knots_.front().seconds + static_cast<double>(step) * dt;
            tick(at(now), static_cast<float>(dt));
            for (; next < knots_.size() && knots_[next].seconds <= now + dt / 2; ++next)
                if (!knots_[next].caption.empty()) picture(knots_[next].caption);
        }
    }
    [[nodiscard]] const std::vector<Knot>& knots() const { return knots_; }

 private:
    std::vector<Knot> knots_;
    std::optional<TouchSize> touch_size_;
};

}  // namespace dgm::formats
