// SPDX-License-Identifier: GPL-3.0-or-later
// samples/support/tool_path.h
// A recorded tool path: where the tool was, what it did, and when a picture was taken.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <dgm/tick.h>
#include <dgm/vec.h>

namespace dgm::samples {

/// One line of a path file: `SECONDS X Y Z KIND [CAPTION]`, in the units and the frame of the mesh. KIND is touch,
/// poke, grasp or away; a caption asks for a picture at this moment. Lines that begin with # are remarks.
struct Knot {
    double seconds = 0;
    Vec3 position;
    ToolKind kind = ToolKind::Touch;
    bool engaged = true;
    std::string caption;
};

class ToolPath {
 public:
    /// @throws model::Error kReadFailed, kUsage for a line that is not as above or goes back in time
    explicit ToolPath(const std::filesystem::path& file);

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
};

}  // namespace dgm::samples
