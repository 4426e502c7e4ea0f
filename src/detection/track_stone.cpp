#include <algorithm>
#include <cmath>

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
constexpr int kBorder = 24;       // px without depth about the part: as far as outlines and normals look
constexpr int kPixelGrid = 24;    // px: a multiple of the strides at which stages take every n-th pixel

/// Pixels of a row or a column, from `first` to below `end`.
struct PixelRange {
  int first = 0, end = 0;

  [[nodiscard]] bool has(int pixel) const { return pixel >= first && pixel < end; }
};

/// The pixels within `reach` of `middle`, of `size`.
PixelRange pixels_near(double middle, double reach, int size) {
  const double first = std::ceil(std::clamp(middle - reach, 0.0, 1.0 * size));
  const double end = std::floor(std::clamp(middle + reach, -1.0, size - 1.0)) + 1.0;
  return {static_cast<int>(first), static_cast<int>(std::max(first, end))};
}

/// Range with a border, from a point of the grid on.
PixelRange with_border(const PixelRange& near, int size) {
  return {std::max(0, near.first - kBorder) / kPixelGrid * kPixelGrid, std::min(size, near.end + kBorder)};
}

/// The part of the image that may show the stone, as an image in the same frame: its principal point is
/// shifted. A border has no depth.
DepthImage cropped(const DepthImage& image, const DetectionModel& model, const Pose& T_C_O) {
  const CameraIntrinsics& camera = image.camera;
  const Eigen::Vector3d centre = T_C_O * model.centre;
  const bool has_pixels =
      camera.width > 0 && camera.height > 0 &&
      image.z.size() == static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  if (centre.z() < 0.05 || !has_pixels) return image;
  const Eigen::Vector2d middle = project(camera, centre);
  const double reach = (model.radius + 0.05) / centre.z() * std::max(camera.fx, camera.fy) * 1.2;
  if (!middle.allFinite() || !std::isfinite(reach)) return image;
  const PixelRange columns = pixels_near(middle.x(), reach, camera.width),
                   rows = pixels_near(middle.y(), reach, camera.height);
  const PixelRange all_columns = with_border(columns, camera.width),
                   all_rows = with_border(rows, camera.height);
  DepthImage part;
  part.camera = camera;
  part.camera.width = all_columns.end - all_columns.first, part.camera.height = all_rows.end - all_rows.first;
  part.camera.cx -= all_columns.first, part.camera.cy -= all_rows.first;
  part.z.reserve(static_cast<std::size_t>(part.camera.width) * static_cast<std::size_t>(part.camera.height));
  for (int v = all_rows.first; v < all_rows.end; ++v)
    for (int u = all_columns.first; u < all_columns.end; ++u)
      part.z.push_back(columns.has(u) && rows.has(v) ? image.at(u, v) : 0.0F);
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
