#pragma once
#include <span>

#include "geometry/polygon.hpp"
#include "physics/shape.hpp"
#include "search/gap_field.hpp"
#include "stonestack/physics/stack.hpp"

namespace stonestack::search {

/// A stone's scan relative to its centre of mass: what heightmaps are made from.
struct StoneGeometry {
  std::vector<Eigen::Vector3d> vertices_M;
  std::vector<Eigen::Vector3i> faces;
  Eigen::Vector3d p_O_M = Eigen::Vector3d::Zero();
  double mass = 0.0;
  double radius = 0.0;
};
[[nodiscard]] StoneGeometry stone_geometry(const ContactShape& shape);

/// A stone whose centre of mass lies at `p_W_M`.
struct BodyPose {
  const StoneGeometry* stone = nullptr;
  Eigen::Matrix3d R_W_O = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_W_M = Eigen::Vector3d::Zero();
};
[[nodiscard]] BodyPose body_pose(const StoneGeometry& stone, const Pose& T_W_O);
[[nodiscard]] Pose stone_pose(const BodyPose& body);

/// Where and how finely a top surface is sampled.
struct SurfaceGrid {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double cell = 0.004;
  int half = 50;
};
/// The top of bodies that may be touched, among others and a table that are raised by `clean_height`.
[[nodiscard]] TopSurface top_surface(std::span<const BodyPose> may_touch,
                                     std::span<const BodyPose> kept_clear, const SurfaceGrid& grid,
                                     double clean_height);
/// The top of a stack, bottom first: only the last stone may be touched, the rest and the table are raised by
/// `clean_height`. An empty stack is the table, which may be touched.
[[nodiscard]] TopSurface top_surface(std::span<const BodyPose> stack, const SurfaceGrid& grid,
                                     double clean_height);

/// Where a stone rests on what is below it.
struct Rest {
  Polygon2 polygon_W;  ///< hull of the contacts seen from above
  double z = 0.0;      ///< mean height of the contacts [m]
};
/// Support surface, and what it carries without the stone that is to come.
struct Interface {
  Rest rest;
  double mass_above = 0.0;      ///< [kg]
  Eigen::Vector3d moment_above  ///< mass times centre of mass [kg m]
      = Eigen::Vector3d::Zero();
};
/// Below bodies, with what it carries; where the lowest of them rests is left open.
[[nodiscard]] Interface interface_under(std::span<const BodyPose> bodies);
/// A stack, and where the lowest of its stones rest as far as that is known. Where it is not, as with stones
/// that are only proposed, it is estimated on a raster.
struct StackBodies {
  std::vector<BodyPose> bodies;
  std::vector<Rest> rests;
  int held = 0;  ///< of the lowest, of which nobody knows where they rest: `held_interfaces`
};
/// Where each stone of a stack at rest touches what is below it, by the scans themselves. A raster passes
/// over sharp corners: a stone on three of them seems to rest on one or two.
[[nodiscard]] std::vector<Rest> rests_of(const ShapeList& shapes, const Stack& stack);
/// One for each stone of the stack; estimated: what is within 0.8 mm of the nearest, seen every 3 mm.
[[nodiscard]] std::vector<Interface> interfaces(const StackBodies& stack);
/// Horizontal acceleration (g) at which the stack tips over one of its interfaces once a mass is put on top.
[[nodiscard]] double tipping_limit(std::span<const Interface> interfaces, double mass,
                                   const Eigen::Vector3d& p_W_M);

}  // namespace stonestack::search
