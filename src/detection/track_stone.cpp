#include <algorithm>

#include "detection/features/models.hpp"
#include "detection/hypotheses/candidates.hpp"
#include "detection/hypotheses/joint_refine.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::detection {
namespace {

constexpr double kTrackMinVisible = 0.01;  // of the whole surface; the guess is evidence too
constexpr double kTrackFurthest = 0.030;   // m, rad: a pose further off than this is another stone
constexpr double kFurthestAngle = 0.45;
constexpr double kNudge = 0.008;  // m: perturbed starts
constexpr double kTurn = 0.14;    // rad

/// The part of the image that may show the stone; the rest is set to "no depth".
DepthImage cropped(const DepthImage& image, const DetectionModel& model, const Pose& T_C_O) {
  DepthImage part = image;
  const Eigen::Vector3d centre = T_C_O * model.centre;
  if (centre.z() < 0.05) return part;
  const Eigen::Vector2d middle = project(image.camera, centre);
  const double reach = (model.radius + 0.05) / centre.z() * std::max(image.camera.fx, image.camera.fy) * 1.2;
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u)
      if (std::abs(u - middle.x()) > reach || std::abs(v - middle.y()) > reach)
        part.z[static_cast<std::size_t>(v * image.camera.width + u)] = 0.0F;
  return part;
}

/// The guess and its neighbours along and about each axis of C, about the stone's centre.
std::vector<Hypothesis> perturbed(const Pose& T_C_O, const Eigen::Vector3d& centre_O) {
  std::vector<Hypothesis> starts{{T_C_O, 1.0}};
  const Eigen::Vector3d c = T_C_O * centre_O;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector3d unit = sign * Eigen::Vector3d::Unit(axis);
      starts.push_back({make_pose(kNudge * unit) * T_C_O, 1.0});
      starts.push_back({make_pose(c) * Pose(Eigen::AngleAxisd(kTurn, unit)) * make_pose(-c) * T_C_O, 1.0});
    }
  return starts;
}

}  // namespace

std::optional<Detection> track_stone(const DepthImage& image, const DetectionModels& models, StoneIndex stone,
                                     const Pose& T_C_O_guess, const DetectionOptions& options,
                                     const SceneKnowledge& known) {
  const auto& data = models.data();
  require(stone.is_within(data.models.size()), "there are ", data.models.size(), " models, none with index ",
          stone);
  require(is_valid(T_C_O_guess), "the guess is not a pose: ", geometry::to_text(T_C_O_guess));
  const DetectionModel& model = at(data.models, stone);
  SceneKnowledge others = known;
  std::erase_if(others.stones, [&](const KnownStone& k) { return k.stone == stone; });
  const DetectionScene scene = without_stones(
      preprocess(cropped(image, model, T_C_O_guess), known.table_C, false, options), data, others.stones);
  if (scene.surface.points.empty()) return {};
  const auto candidates =
      judge_hypotheses(model, stone, perturbed(T_C_O_guess, model.centre), scene, options);
  for (const auto& c : candidates) {
    const PoseDifference moved = difference(T_C_O_guess, c.detection.T_C_O);
    if (c.detection.score >= options.accept_score && c.detection.visible >= kTrackMinVisible &&
        moved.translation < kTrackFurthest && moved.angle < kFurthestAngle)
      return refined_together({c.detection}, data, scene).front();
  }
  return {};
}

}  // namespace stonestack::detection
