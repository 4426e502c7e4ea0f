#pragma once
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/plane.hpp"
#include "stonestack/stone/stone.hpp"

namespace stonestack {

/// Where a stone was found.
struct Detection {
  int stone = -1;  ///< index into the models
  Pose T_C_O = Pose::Identity();
  double score = 0.0;  ///< visibility-aware, at most 1; accepted from `DetectionOptions::accept_score` on
  double inlier_ratio = 0.0;  ///< the paper's, over visible model points
  double visible = 0.0;       ///< share of the model's surface that this view saw
  Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Matrix<double, 6, 6>::Zero();  ///< (translation m, rotation rad) in C
};

/// What one frame showed.
struct DetectionResult {
  std::vector<Detection> detections;  ///< at most one a model, best score first
  std::optional<Plane> table_C;       ///< normal towards the camera
  std::string note;                   ///< why nothing was found, for a person; empty otherwise
};

/// Stages and limits of detection. `method`: "default" or "paper".
struct DetectionOptions {
  std::string method = "default";
  std::string keypoints = "voxel";   ///< voxel, iss
  std::string descriptor = "shot";   ///< shot, fpfh, rops
  double keypoint_spacing = 0.010;   ///< m, measured: facts/detection.md §2
  double descriptor_radius = 0.040;  ///< m
  double consistency_size = 0.008;   ///< m, geometric consistency (Chen and Bhanu 2004)
  int best = 30;                     ///< b best hypotheses a model
  double accept_score = 0.70;        ///< from measured separation
  int seed = 1;
};
[[nodiscard]] FieldList fields(DetectionOptions& options);

/// Stones prepared for detection: resampled surfaces, descriptors. Made once, shared between frames and
/// threads.
class DetectionModels {
 public:
  DetectionModels(std::span<const Stone> stones, const DetectionOptions& options = {});
  ~DetectionModels();
  DetectionModels(DetectionModels&&) noexcept;
  DetectionModels& operator=(DetectionModels&&) noexcept;
  struct Data;
  [[nodiscard]] const Data& data() const { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

/// Finds the stones `wanted` (indices; all if empty) in one depth image (paper §2). Never throws for what a
/// camera may show: an empty or senseless image gives no detections and a note.
[[nodiscard]] DetectionResult detect_stones(const DepthImage& image, const DetectionModels& models,
                                            std::span<const int> wanted = {},
                                            const DetectionOptions& options = {});

/// Refines known poses: a stone is expected at T_C_O_guess (within about 15 mm, 15 deg); empty if it is not
/// there.
[[nodiscard]] std::optional<Detection> track_stone(const DepthImage& image, const DetectionModels& models,
                                                   int stone, const Pose& T_C_O_guess,
                                                   const DetectionOptions& options = {});

}  // namespace stonestack
