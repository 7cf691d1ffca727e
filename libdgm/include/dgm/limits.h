// SPDX-License-Identifier: MIT
// libdgm/include/dgm/limits.h
// States the range of each number from maps and callers: inside it, squares of distances stay finite.
#pragma once
#include <cstddef>

namespace dgm {

/// Largest |coordinate| of a map's sample, a tool, a displacement or an obstacle, local units; also the largest radius
/// or half side. Squares of differences stay below 1.3e37, in the range of float.
inline constexpr float kMaxCoordinate = 1e18f;
/// Length of a kernel step (Touch::step, TickOptions::step), local units; 0 means State::mean_step().
inline constexpr float kMinStep = 1e-15f, kMaxStep = 1e15f;
/// E, G (from 0) and |F| of the first fundamental form: squares of lengths of a grid step.
inline constexpr float kMaxForm = 1e30f;
/// KernelOptions::sigma, squared grid steps.
inline constexpr float kMinSigma = 1e-6f, kMaxSigma = 1e12f;
/// Radii of an elliptic kernel, grid steps, and the longer one over the shorter one.
inline constexpr float kMinKernelRadius = 1e-3f, kMaxKernelRadius = 1e6f, kMaxKernelRatio = 1e4f;
/// Entries of layer `material`, SI units: metres per unit, membrane, poisson, bending, foundation, density, viscosity
/// (dgm::Material). A file has all of them, or the first alone.
inline constexpr std::size_t kMaterialValues = 7;
inline constexpr float kMaterialLow[kMaterialValues] = {1e-9f, 1e-6f, 0, 0, 0, 1e-6f, 0};
inline constexpr float kMaterialHigh[kMaterialValues] = {1e9f, 1e12f, 0.49f, 1e12f, 1e12f, 1e12f, 1e6f};

}  // namespace dgm
