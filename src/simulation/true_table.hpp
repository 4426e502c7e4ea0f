#pragma once
#include <memory>
#include <optional>

#include "physics/rigid_world.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack::simulation {

/// The table as it is: the plane z = 0 of W, or a tilted, uneven square of triangles somewhat above or below
/// it.
class TrueTable {
 public:
  /// The plane z = 0.
  TrueTable() = default;
  /// Draws the errors that the options ask for about `centre` (m in W): with none, the plane z = 0.
  TrueTable(const SimulationOptions& options, const Eigen::Vector2d& centre);

  /// Height of the surface at a place, m in W; beyond the edge that of the nearest place on it.
  [[nodiscard]] double height(double x, double y) const;
  [[nodiscard]] double height(const Eigen::Vector3d& p_W) const { return height(p_W.x(), p_W.y()); }
  /// Closed mesh of the table, in W, for contact; empty: it is the plane z = 0.
  [[nodiscard]] const std::shared_ptr<const ContactShape>& shape() const { return shape_; }
  /// Shape and tangent planes for a world of rigid bodies, of a table that has a shape.
  [[nodiscard]] TableSurface contact_surface() const;
  /// Surface to be seen, in W.
  [[nodiscard]] Mesh surface() const;

 private:
  [[nodiscard]] Eigen::Vector3d node(int column, int row) const;

  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();  // of the square with the lowest x and y, m in W
  std::vector<double> z_;                             // by node, row by row [m]
  std::shared_ptr<const ContactShape> shape_;
};

}  // namespace stonestack::simulation
