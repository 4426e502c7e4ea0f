#pragma once
#include <string>
#include <vector>

#include "stonestack/core/random.hpp"
#include "stonestack/geometry/signed_distance.hpp"
#include "stonestack/simulation/sensor_noise.hpp"
#include "stonestack/stone/stone.hpp"

/// Seeded scenes with known truth, for `bench detection`.
namespace stonestack::bench {

/// isolated: four stones apart. touching: four in one heap on the table. stacked: three on each other, one
/// beside, seen from the side. few: one stone; the others are absent. d435: isolated, with another sensor.
struct SceneKind {
  std::string name;
  int present = 4;
  std::string arrangement;  ///< apart, touching, stacked
  std::string sensor = "sr300";
};
[[nodiscard]] std::vector<SceneKind> scene_kinds();

/// A stone of the scene and how much of what faces the camera is not hidden by other stones.
struct TrueStone {
  int stone = -1;
  Pose T_C_O = Pose::Identity();
  double unhidden = 0.0;
};

/// One image and its truth.
struct BenchScene {
  DepthImage image;
  Pose T_W_C = Pose::Identity();
  std::vector<TrueStone> truth;
};

/// Places and renders full-resolution scans. Stones rest in an orientation in which they would stay on a
/// table, are pushed together until 1 mm apart, or set down on each other; nothing is settled, so stacks need
/// not hold.
class SceneMaker {
 public:
  explicit SceneMaker(const std::vector<Stone>& stones);
  [[nodiscard]] BenchScene make(const SceneKind& kind, std::uint64_t seed) const;

 private:
  [[nodiscard]] double gap(int a, const Pose& T_W_A, int b, const Pose& T_W_B) const;
  [[nodiscard]] double gap(const std::vector<PlacedStone>& placed, int stone, const Pose& T_W_O) const;
  [[nodiscard]] Eigen::Quaterniond rest(int stone, Random& random) const;
  [[nodiscard]] Pose push(const std::vector<PlacedStone>& placed, int stone, Pose T_W_O,
                          const Eigen::Vector3d& towards) const;
  [[nodiscard]] std::vector<PlacedStone> arrange(const SceneKind& kind, Random& random) const;

  const std::vector<Stone>& stones_;
  std::vector<SignedDistance> distance_;
};

}  // namespace stonestack::bench
