#pragma once
#include <optional>
#include <span>
#include <vector>

#include "detection/features/models.hpp"

namespace stonestack::detection {

/// A drawn pixel of one view; it stands for `step` x `step` pixels of the image.
struct SeenPixel {
  int view = 0;
  int index = 0;  ///< v * width + u
  int step = 1;   ///< of the raster
};

/// Verdict of the scene on one pose of one model.
struct Verdict {
  double score = -1.0;        ///< at most 1: what fits, minus what contradicts
  double inlier_ratio = 0.0;  ///< the paper's: share that fits, of the drawn pixels that have a depth
  double visible = 0.0;  ///< share of the model's whole surface that was seen and fits, in the view of most
  ScoreLosses lost;      ///< what the score lacks to 1, by what contradicts
  std::vector<SeenPixel> pixels;  ///< that fit, on the drawn raster
};

inline constexpr double kBesideModel =
    0.012;  ///< distance from the surface beyond which there is another thing [m]

/// Tolerances and weights of a check.
struct VerifyOptions {
  double tolerance = 0.005;    ///< along the surface normal [m]
  double hidden_weight = 0.3;  ///< what a pixel costs that something unknown hides
  double below_table = 0.012;  ///< how deep a vertex may lie below the table or another support [m]
  int drawn_pixels = 1500;     ///< about, for a pose in full view, in each view
  bool keep_pixels = false;    ///< fill Verdict::pixels
  bool contour = false;        ///< check the outline as well
};

/// Draws the model at the pose into each view and compares it with what was seen, pixel by pixel. A pixel
/// fits the better, the nearer it lies and the better the normals agree; it contradicts if the surface behind
/// is seen (one would look through stone) or one just in front; far in front something may hide the model.
/// Seen points just off the model's surface contradict too (the surface goes on where the model ends), and so
/// does a pose below the table. Where the model's surface is known with an error only (SurfaceSigma), more is
/// tolerated and the place counts less. With `contour`, what is seen must end or bend where the model ends
/// (compare_contour). Pixels that are explained by known stones carry no evidence.
[[nodiscard]] Verdict verify_pose(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene,
                                  const VerifyOptions& options);

/// Compares likewise, with the indices `around` of all points of the scene's surface that lie within
/// kBesideModel of the model's bounding sphere at the pose, and perhaps of others.
[[nodiscard]] Verdict verify_pose(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene,
                                  const VerifyOptions& options, std::span<const int> around);

/// Evidence of each pixel of the scene's first view, row by row.
[[nodiscard]] std::vector<PixelEvidence> pixel_evidence(const DetectionModel& model, const Pose& T_C_O,
                                                        const DetectionScene& scene, double tolerance);

}  // namespace stonestack::detection
