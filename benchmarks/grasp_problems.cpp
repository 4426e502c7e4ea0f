#include "grasp_problems.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/convex_pieces.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/stone/model_stone.hpp"

namespace stonestack::bench {
namespace {

/// Height of the centre of mass over the lowest point, m.
double standing_height(const Stone& stone, const Eigen::Quaterniond& R_W_O) {
  double lowest = 0.0;
  for (const Eigen::Vector3d& p : stone.mesh.vertices)
    lowest = std::min(lowest, (R_W_O * (p - stone.mass.p_O_M)).z());
  return -lowest;
}

/// True if some vertical plane has the two on its two sides, `gap` (m) apart.
bool lie_apart(const SceneObject& a, const SceneObject& b, double gap) {
  constexpr int kDirections = 48;
  const auto along = [](const SceneObject& object, const Eigen::Vector3d& n_W) {
    Eigen::AlignedBox1d range;
    for (const Mesh& piece : object.pieces)
      for (const Eigen::Vector3d& p : piece.vertices)
        range.extend(Eigen::Matrix<double, 1, 1>(n_W.dot(object.T_W_object * p)));
    return range;
  };
  for (int i = 0; i < kDirections; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / kDirections;
    const Eigen::Vector3d n_W(std::cos(turn), std::sin(turn), 0.0);
    if (along(a, n_W).max()(0) + gap < along(b, n_W).min()(0)) return true;
  }
  return false;
}

}  // namespace

Stone random_stone(std::uint64_t seed, const std::string& name, double min_extent, double max_extent) {
  LimestoneOptions shape;
  shape.min_extent = min_extent;
  shape.max_extent = max_extent;
  shape.faces = 1000;
  Stone stone;
  stone.name = name;
  const Mesh scan = make_limestone(seed, shape);
  stone.scan = transformed(scan, make_pose(Eigen::Vector3d(-mass_properties(scan, stone.density).p_O_M)));
  stone.mesh = stone.scan;
  stone.mass = mass_properties(stone.scan, stone.density);
  stone.pieces = convex_pieces(stone.scan);
  return stone;
}

std::vector<Stone> random_stones(std::uint64_t seed, int count) {
  constexpr double kMin = 0.07, kMax = 0.14;  // m
  std::vector<Stone> stones;
  for (int k = 0; k < count; ++k)
    stones.push_back(
        random_stone(100 * seed + static_cast<std::uint64_t>(k), concat("limestone ", k), kMin, kMax));
  return stones;
}

Eigen::Quaterniond rest(const Stone& stone, Random& random) {
  Eigen::Quaterniond R = random.rotation();
  double height = standing_height(stone, R);
  for (double step = 0.3; step > 0.003; step *= 0.93) {
    for (int i = 0; i < 8; ++i) {
      Eigen::Vector3d axis = random.unit_vector();
      axis.z() = 0.0;
      const Eigen::Quaterniond turned(Eigen::AngleAxisd(step, axis.normalized()) * R);
      if (const double h = standing_height(stone, turned); h < height) {
        height = h;
        R = turned;
      }
    }
  }
  return R;
}

Pose standing_at(const Stone& stone, const Eigen::Quaterniond& R_W_O, const Eigen::Vector2d& at, double z) {
  Pose T = make_pose({at.x(), at.y(), z + standing_height(stone, R_W_O)}, R_W_O);
  T.translation() -= R_W_O * stone.mass.p_O_M;
  return T;
}

double top(const SceneObject& object) {
  double z = 0.0;
  for (const Mesh& piece : object.pieces)
    for (const Eigen::Vector3d& p : piece.vertices) z = std::max(z, (object.T_W_object * p).z());
  return z;
}

GraspProblem make_grasp_problem(const std::vector<Stone>& stones, Random& random) {
  const CellLayout layout;
  GraspProblem problem;
  problem.scene.robot = read_robot("ur10");
  problem.scene.T_F_T = layout.T_F_T;
  std::vector<StoneIndex> order = first_stones(stones.size());
  random.shuffle(order.begin(), order.end());
  constexpr double kGap = 0.005;  // m: they lie as they fell, without clearance for fingers
  for (std::size_t n = 1; n < order.size() && n <= 6; ++n) {
    const Stone& s = at(stones, order[n]);
    for (int attempt = 0; attempt < 60; ++attempt) {
      const Eigen::Vector2d at(layout.field_centre.x() + layout.field_size.x() * random.uniform(-0.5, 0.5),
                               layout.field_centre.y() + layout.field_size.y() * random.uniform(-0.5, 0.5));
      const SceneObject object{s.name, s.pieces, standing_at(s, rest(s, random), at, 0.0)};
      const auto& others = problem.scene.objects;
      if (!std::all_of(others.begin(), others.end(),
                       [&](const SceneObject& other) { return lie_apart(object, other, kGap); }))
        continue;
      problem.scene.objects.push_back(object);
      problem.loose.push_back(order[n]);
      break;
    }
  }
  const Stone& base = at(stones, order[0]);
  problem.scene.objects.push_back(
      {base.name, base.pieces, standing_at(base, rest(base, random), layout.site, 0.0)});
  return problem;
}

}  // namespace stonestack::bench
