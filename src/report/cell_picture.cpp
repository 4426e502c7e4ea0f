#include <algorithm>
#include <cmath>

#include "report/cell_page.hpp"
#include "report/drawn_arm.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::report {
namespace {

constexpr double kThin = 0.006, kThick = 0.010;  // m: lines on the table and edges of limits
constexpr double kAboveTable = 0.003;            // m: where lines on the table are drawn
constexpr int kRing = 32;                        // sides of a circle
const Eigen::Vector3d kObstacleColour(0.62, 0.30, 0.25), kWorkspaceColour(0.16, 0.48, 0.30),
    kFenceColour(0.70, 0.12, 0.10), kReachColour(0.12, 0.38, 0.75), kSeenColour(0.85, 0.50, 0.08),
    kFieldColour(0.95, 0.95, 0.95), kSiteColour(0.75, 0.35, 0.10);

/// Adds lines from each point to the next, and back to the first.
void add_loop(std::vector<DrawnMesh>& meshes, const std::vector<Eigen::Vector3d>& points, double width,
              const Eigen::Vector3d& colour) {
  for (std::size_t i = 0; i < points.size(); ++i)
    meshes.push_back(drawn_bar(points[i], points[(i + 1) % points.size()], width, colour));
}

std::vector<Eigen::Vector3d> on_table(const std::vector<Eigen::Vector2d>& points) {
  std::vector<Eigen::Vector3d> lifted;
  for (const Eigen::Vector2d& p : points) lifted.emplace_back(p.x(), p.y(), kAboveTable);
  return lifted;
}

void add_edges(std::vector<DrawnMesh>& meshes, const Eigen::AlignedBox3d& box,
               const Eigen::Vector3d& colour) {
  using Box = Eigen::AlignedBox3d;
  for (int from = 0; from < 8; ++from)
    for (const int axis : {1, 2, 4})
      if ((from & axis) == 0)
        meshes.push_back(drawn_bar(box.corner(static_cast<Box::CornerType>(from)),
                                   box.corner(static_cast<Box::CornerType>(from | axis)), kThin, colour));
}

void add_site_and_field(std::vector<DrawnMesh>& meshes, const CellLayout& layout) {
  const Eigen::Vector2d half = 0.5 * layout.field_size, &c = layout.field_centre;
  add_loop(meshes,
           on_table({c - half, c + Eigen::Vector2d(half.x(), -half.y()), c + half,
                     c + Eigen::Vector2d(-half.x(), half.y())}),
           kThin, kFieldColour);
  std::vector<Eigen::Vector2d> ring;
  for (int k = 0; k < kRing; ++k)
    ring.emplace_back(layout.site +
                      0.03 * Eigen::Vector2d(std::cos(2 * M_PI * k / kRing), std::sin(2 * M_PI * k / kRing)));
  add_loop(meshes, on_table(ring), kThick, kSiteColour);
}

/// Axes of W at its origin: x red, y green, z blue.
void add_axes(std::vector<DrawnMesh>& meshes) {
  for (Eigen::Index i = 0; i < 3; ++i)
    meshes.push_back(
        drawn_bar(Eigen::Vector3d(0, 0, kAboveTable),
                  Eigen::Vector3d(0.35 * Eigen::Vector3d::Unit(i) + Eigen::Vector3d(0, 0, kAboveTable)),
                  kThick, Eigen::Vector3d(0.8 * Eigen::Vector3d::Unit(i))));
}

}  // namespace

std::vector<DrawnMesh> drawn_cell(const CellPreview& cell) {
  const CellLayout& layout = cell.layout;
  const GripperModel gripper = gripper_of(layout);
  const CellPose& start = cell.poses.front();
  std::vector<DrawnMesh> meshes =
      drawn_arm(cell.robot, gripper, layout.T_W_R, layout.T_F_T, {start.q, gripper.max_opening});
  for (const Obstacle& obstacle : layout.obstacles)
    for (const Mesh& piece : obstacle.pieces) meshes.push_back({piece, obstacle.T_W_O, kObstacleColour});
  const auto solid = static_cast<std::ptrdiff_t>(meshes.size());
  add_site_and_field(meshes, layout);
  add_axes(meshes);
  add_loop(meshes, on_table(cell.p_W_reach), kThin, kReachColour);
  add_loop(meshes, on_table(cell.p_W_too_near), kThin, kReachColour);
  for (const Eigen::Vector3d& corner : start.p_W_seen)
    meshes.push_back(drawn_bar(start.T_W_C.translation(), corner, kThin, kSeenColour));
  add_loop(meshes, start.p_W_seen, kThin, kSeenColour);
  if (cell.robot.workspace)
    add_edges(meshes, within_sight(cell.robot.workspace->box, cell), kWorkspaceColour);
  if (cell.robot.fence) add_edges(meshes, within_sight(cell.robot.fence->box, cell), kFenceColour);
  std::for_each(meshes.begin() + solid, meshes.end(), [](DrawnMesh& line) { line.solid = false; });
  return meshes;
}

Eigen::AlignedBox3d within_sight(const Eigen::AlignedBox3d& limits, const CellPreview& cell) {
  constexpr double kBeyond = 0.3, kHigh = 1.6, kEndless = 9.99;  // m
  Eigen::AlignedBox3d sight;
  for (const Eigen::Vector2d& p : cell.p_W_reach) {
    sight.extend(Eigen::Vector3d(p.x() - kBeyond, p.y() - kBeyond, -kBeyond));
    sight.extend(Eigen::Vector3d(p.x() + kBeyond, p.y() + kBeyond, kHigh));
  }
  Eigen::AlignedBox3d drawn = limits;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (limits.min()[i] < -kEndless) drawn.min()[i] = std::min(sight.min()[i], limits.max()[i] - kBeyond);
    if (limits.max()[i] > kEndless) drawn.max()[i] = std::max(sight.max()[i], limits.min()[i] + kBeyond);
  }
  return drawn;
}

View view_of_cell(const std::vector<DrawnMesh>& meshes) {
  constexpr double kFilled = 0.94, kFarther = 1.02;  // share of the picture; step
  constexpr int kRounds = 6;                         // of moving the target to the middle of what is seen
  std::vector<Eigen::Vector3d> points;
  Eigen::AlignedBox3d box;
  for (const DrawnMesh& drawn : meshes)
    for (const Eigen::Vector3d& v : drawn.mesh.vertices) {
      points.emplace_back(drawn.T_W_A * v);
      box.extend(points.back());
    }
  View view;
  view.width = 1200;
  view.height = 800;
  view.angle = 38.0 * M_PI / 180.0;  // as the page's camera
  view.table = 8.0;
  view.p_W_target = box.center();
  const Eigen::Vector3d n_W = Eigen::Vector3d(0.72, -0.66, 0.52).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitZ().cross(n_W).normalized(), up = n_W.cross(right);
  const double height = kFilled * std::tan(view.angle / 2), width = height * view.width / view.height;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::AlignedBox2d seen;  // in halves of the picture
    for (double distance = 0.5; distance < 20.0; distance *= kFarther) {
      view.p_W_eye = view.p_W_target + distance * n_W;
      seen.setEmpty();
      bool in_front = true;
      for (const Eigen::Vector3d& p_W : points) {
        const Eigen::Vector3d p = p_W - view.p_W_eye;
        const double depth = -n_W.dot(p);
        in_front = in_front && depth > 0.0;
        seen.extend(Eigen::Vector2d(right.dot(p) / (width * depth), up.dot(p) / (height * depth)));
      }
      if (in_front && seen.sizes().maxCoeff() < 2.0) break;
    }
    const double distance = (view.p_W_target - view.p_W_eye).norm();
    const Eigen::Vector3d aside =
        distance * (width * seen.center().x() * right + height * seen.center().y() * up);
    view.p_W_target += aside;
    view.p_W_eye += aside;
  }
  return view;
}

}  // namespace stonestack::report
