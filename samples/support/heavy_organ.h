// SPDX-License-Identifier: GPL-3.0-or-later
// samples/support/heavy_organ.h
// An organ with mass and material that nothing holds but tools, obstacles and gravity.
#pragma once
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>

#include <dgm/physics.h>

#include "support/soft_body.h"

namespace dgm::samples {

class HeavyOrgan {
 public:
    static constexpr double kStep = 1e-3;

    /// Unit and material are those of the file; no tissue around pulls it back. Flesh is not elastic alone.
    explicit HeavyOrgan(const std::string& map) : body_(map) {
        PhysicsOptions options;
        options.material = stored_material(body_.state()).material.value_or(Material{});
        options.material->foundation = 0;
        options.material->viscosity = std::max(options.material->viscosity, 1e-2F);
        options.dt = static_cast<float>(kStep);
        physics_.emplace(take(Physics::create(body_.state(), options), "physics"));
        how_.cycles = 5;
    }
    [[nodiscard]] SoftBody& body() { return body_; }
    [[nodiscard]] StepOptions& how() { return how_; }

    StepReport step(std::span<const Knot> tools) {
        StepTool felt[formats::kMostTools];
        const StepReport report = take(dgm::step(body_.state(), *physics_, how_, body_.inputs(tools), felt), "step");
        body_.state().update_normals();
        for (std::size_t k = 0; k < tools.size(); ++k)
            strongest_ = std::max(strongest_, std::sqrt(double{dot(felt[k].force, felt[k].force)}));
        swelling_ = std::max(swelling_, std::fabs(report.volume_error));
        ++steps_;
        return report;
    }
    [[nodiscard]] double strongest() const { return strongest_; }  ///< N, on a tool so far
    [[nodiscard]] double swelling() const { return swelling_; }    ///< largest volume error so far
    [[nodiscard]] std::size_t steps() const { return steps_; }

 private:
    SoftBody body_;
    std::optional<Physics> physics_;
    StepOptions how_;
    double strongest_ = 0, swelling_ = 0;
    std::size_t steps_ = 0;
};

}  // namespace dgm::samples
