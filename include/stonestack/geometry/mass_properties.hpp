#pragma once
#include "stonestack/geometry/mesh.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Mass, centre of mass and inertia of a rigid body, in the frame of its mesh (O).
struct MassProperties {
  double mass = 0.0;                                ///< [kg]
  Eigen::Vector3d p_O_M = Eigen::Vector3d::Zero();  ///< centre of mass, m
  Eigen::Matrix3d I_M = Eigen::Matrix3d::Zero();    ///< about the centre of mass, axes of O, kg m^2
};

/// Of a closed mesh of uniform `density` (kg/m^3), exact for polyhedra (Mirtich 1996). Throws InvalidArgument
/// when the volume is not positive.
[[nodiscard]] MassProperties mass_properties(const Mesh& mesh, double density);
/// Empty if physically possible; else what is wrong: mass not positive, inertia not positive definite or
/// against the triangle inequality, not finite.
[[nodiscard]] std::string check(const MassProperties& properties);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
