#pragma once
#include <string>
#include <vector>

#include "geometry/depth_render.hpp"
#include "geometry/signed_distance.hpp"
#include "rooms.hpp"
#include "simulation/sensor_noise.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/stone/stone.hpp"

/// Seeded scenes with known truth, for `stonestack-bench detection`.
namespace stonestack::bench {

/// isolated: four stones apart. touching: four in one heap on the table. stacked: three on each other, one
/// beside, seen from the side. few: one stone; the others are absent. d435: isolated, with another sensor.
/// copies: isolated, two of the four are the same stone. hidden: a heap of six seen from low down, so that
/// stones hide each other; two_views: the same heaps, from a second camera pose as well. mirrored: isolated,
/// seen in a mirror: no stone is there.
struct SceneKind {
  std::string name;
  int present = 4;
  std::string arrangement = "apart";  ///< apart, touching, stacked, heap
  std::string sensor = "sr300";
  int copies = 1;              ///< of the first stone
  int views = 1;               ///< camera poses
  double min_tilt = 0.0;       ///< tilt of the camera off the vertical, rad, at least
  double max_tilt = 0.78;      ///< tilt at most, rad
  double min_unhidden = 0.25;  ///< stones of which the first view shows less do not count
  bool mirrored = false;       ///< the images, left for right
};
[[nodiscard]] std::vector<SceneKind> scene_kinds();

/// A stone of the scene and how much of what faces the first camera is not hidden by other stones.
struct TrueStone {
  StoneIndex stone = kNoStone;
  Pose T_C_O = Pose::Identity();  ///< C: the camera of the first view
  double unhidden = 0.0;
};

/// The images of one scene and its truth. The camera poses are as an arm would report them: with an error.
struct BenchScene {
  std::vector<DepthView> views;
  std::vector<TrueStone> truth;
  std::vector<std::vector<int>> shown;  ///< a view: index into `truth` of each pixel's stone; -1 elsewhere
};

/// How far the reported pose of each further view is off, standard deviations an axis.
struct CameraError {
  double shift = 0.0006;  ///< along each axis, m
  double turn = 0.002;    ///< about each axis, rad
};

/// Places and renders full-resolution scans. Stones rest in an orientation in which they would stay on a
/// table, are pushed together until 1 mm apart, or set down on each other; nothing is settled, so stacks need
/// not hold; a heap is settled: stones in any orientation, one after the other, let go where they meet it or
/// the table.
class SceneMaker {
 public:
  explicit SceneMaker(const std::vector<Stone>& stones);
  [[nodiscard]] BenchScene make(const SceneKind& kind, std::uint64_t seed,
                                const CameraError& error = {}) const;
  /// Views of one stone at rest in a drawn attitude, evenly around it, up to `camera_tilt` (rad) off the
  /// vertical; the pose of the first is exact.
  [[nodiscard]] BenchScene views_around(StoneIndex stone, int views, std::uint64_t seed,
                                        const CameraError& error = {}, double camera_tilt = 0.8) const;
  /// Stones that the scenes are made of.
  [[nodiscard]] const std::vector<Stone>& stones() const { return stones_; }

 private:
  [[nodiscard]] double gap(StoneIndex a, const Pose& T_W_A, StoneIndex b, const Pose& T_W_B) const;
  [[nodiscard]] double gap(const std::vector<PlacedStone>& placed, StoneIndex stone, const Pose& T_W_O) const;
  [[nodiscard]] Eigen::Quaterniond rest(StoneIndex stone, Random& random) const;
  [[nodiscard]] Pose push(const std::vector<PlacedStone>& placed, StoneIndex stone, Pose T_W_O,
                          const Eigen::Vector3d& towards) const;
  [[nodiscard]] std::vector<TrueStone> truth_of(const std::vector<PlacedStone>& placed,
                                                const RenderedView& view, const Pose& T_W_C,
                                                const CameraIntrinsics& camera) const;
  [[nodiscard]] std::vector<PlacedStone> arrange(const SceneKind& kind, Random& random) const;
  [[nodiscard]] std::vector<PlacedStone> pile_up(const std::vector<StoneIndex>& order, Random& random) const;

  const std::vector<Stone>& stones_;
  std::vector<SignedDistance> distance_;
};

}  // namespace stonestack::bench
