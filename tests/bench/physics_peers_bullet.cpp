// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/physics_peers_bullet.cpp
// Bullet's soft bodies: position-based links, and implicit springs.
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include "physics_peers.h"

namespace dgm::bench {
namespace {

/// Bullet's tolerances are made for bodies of metres. Springs and masses do not care about the length of a metre.
constexpr double kScale = 50;

btVector3 bullet(const Point& p) {
    return {static_cast<btScalar>(kScale * p[0]), static_cast<btScalar>(kScale * p[1]),
            static_cast<btScalar>(kScale * p[2])};
}

/// The body in a world without collisions and gravity.
class Bullet : public Solver {
 public:
    Bullet(const Springs& s, double dt) : springs_(s), dt_(dt), offset_{} {}
    [[nodiscard]] Points points() const override {
        Points out;
        for (int k = 0; k < body_->m_nodes.size(); ++k) {
            const btVector3& x = body_->m_nodes[k].m_x;
            out.push_back({double{x.x()} / kScale, double{x.y()} / kScale, double{x.z()} / kScale});
        }
        return out;
    }

 protected:
    /// @param held  mass of held nodes, kg
    void make_body(double held) {
        info_.air_density = info_.water_density = 0;
        info_.m_gravity = {0, 0, 0};
        info_.m_broadphase = &broadphase_;
        info_.m_dispatcher = &dispatcher_;
        std::vector<btVector3> x;
        std::vector<btScalar> m;
        for (const Point& p : springs_.rest) x.push_back(bullet(p));
        for (const double mass : springs_.mass) m.push_back(static_cast<btScalar>(mass > 0 ? mass : held));
        body_ = std::make_unique<btSoftBody>(&info_, static_cast<int>(x.size()), x.data(), m.data());
        for (const auto& [a, b] : springs_.edges) body_->appendLink(static_cast<int>(a), static_cast<int>(b));
        for (const auto& f : springs_.faces)
            body_->appendFace(static_cast<int>(f[0]), static_cast<int>(f[1]), static_cast<int>(f[2]));
        body_->m_cfg.collisions = 0;
        body_->m_cfg.kDP = body_->m_cfg.kDG = body_->m_cfg.kLF = 0;
        body_->setActivationState(DISABLE_DEACTIVATION);
    }
    /// Held nodes are moved by their velocity.
    void move_hand(const Point& offset) {
        Point speed;
        for (std::size_t c = 0; c < 3; ++c) speed[c] = (offset[c] - offset_[c]) / dt_;
        offset_ = offset;
        for (int k = 0; k < body_->m_nodes.size(); ++k)
            if (springs_.mass[static_cast<std::size_t>(k)] == 0)
                body_->m_nodes[k].m_v = body_->m_nodes[k].m_vn = bullet(speed);
    }

    const Springs& springs_;
    double dt_;
    Point offset_;
    btSoftBodyRigidBodyCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_{&configuration_};
    btDbvtBroadphase broadphase_;
    btSoftBodyWorldInfo info_;
    std::unique_ptr<btSoftBody> body_;
};

class Links final : public Bullet {
 public:
    Links(const Springs& s, double dt) : Bullet(s, dt), world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
        make_body(0);
        body_->m_materials[0]->m_kLST = 1;
        body_->m_cfg.viterations = body_->m_cfg.diterations = body_->m_cfg.citerations = 0;
        world_.setGravity({0, 0, 0});
        world_.addSoftBody(body_.get());
    }
    ~Links() override { world_.removeSoftBody(body_.get()); }
    void step(const Point& offset, std::uint32_t effort) override {
        body_->m_cfg.piterations = static_cast<int>(effort);
        move_hand(offset);
        world_.stepSimulation(static_cast<btScalar>(dt_), 0);
    }

 private:
    btSequentialImpulseConstraintSolver solver_;
    btSoftRigidDynamicsWorld world_;
};

/// Lets the number of iterations be chosen.
class Implicit final : public Bullet {
    class Newton : public btDeformableBodySolver {
     public:
        /// The world chooses a preconditioner that is not made for implicit steps: with it nothing moves.
        void solveDeformableConstraints(btScalar dt) override {
            setPreconditioner(btDeformableBackwardEulerObjective::Mass_preconditioner);
            m_objective->m_preconditioner->reinitialize(true);
            btDeformableBodySolver::solveDeformableConstraints(dt);
        }
        void set(int newton, int iterations) {
            m_maxNewtonIterations = newton;
            m_newtonTolerance = 0;
            m_cr.m_maxIterations = m_cg.m_maxIterations = iterations;
            m_cr.m_tolerance = m_cg.m_tolerance = 0;
        }
    };

 public:
    Implicit(const Springs& s, double dt, int newton)
        : Bullet(s, dt), steps_(newton), world_(&dispatcher_, &broadphase_, &solver_, &configuration_, &newton_) {
        // Nodes without inverse mass make its arrays be written out of bounds: held ones are very heavy instead.
        make_body(1e4 * *std::max_element(s.mass.begin(), s.mass.end()));
        solver_.setDeformableSolver(&newton_);
        world_.setImplicit(true);
        world_.setLineSearch(false);
        world_.setGravity({0, 0, 0});
        force_ = std::make_unique<btDeformableMassSpringForce>(static_cast<btScalar>(s.stiffness), btScalar{0}, true);
        world_.addSoftBody(body_.get());
        world_.addForce(body_.get(), force_.get());
    }
    ~Implicit() override {
        world_.removeSoftBodyForce(body_.get());
        world_.removeSoftBody(body_.get());
    }
    void step(const Point& offset, std::uint32_t effort) override {
        newton_.set(steps_, static_cast<int>(effort));
        move_hand(offset);
        world_.stepSimulation(static_cast<btScalar>(dt_), 0);
    }

 private:
    int steps_;
    Newton newton_;
    btDeformableMultiBodyConstraintSolver solver_;
    btDeformableMultiBodyDynamicsWorld world_;
    std::unique_ptr<btDeformableMassSpringForce> force_;
};
}  // namespace

std::unique_ptr<Solver> make_bullet_links(const PhysicsMap&, const Springs& s, double dt) {
    return std::make_unique<Links>(s, dt);
}
std::unique_ptr<Solver> make_bullet_implicit(const PhysicsMap&, const Springs& s, double dt) {
    return std::make_unique<Implicit>(s, dt, 3);
}
std::unique_ptr<Solver> make_bullet_once(const PhysicsMap&, const Springs& s, double dt) {
    return std::make_unique<Implicit>(s, dt, 1);
}

}  // namespace dgm::bench
