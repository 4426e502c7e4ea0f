#include "stonestack/core/error.hpp"
#include "stonestack/detection/method.hpp"

namespace stonestack::detection {

FieldList fields(DetectionOptions& o) {
  return {
      field("method", o.method, "default, or paper: section 2 as a set of options, which others override"),
      field("keypoints", o.keypoints, "voxel or iss; paper section 2"),
      field("descriptor", o.descriptor,
            "shot, fpfh, iss or rops; with method paper rops (section 2: or iss)"),
      field("matching", o.matching, "exact, or kdtree (the same matches); with method paper kdtree"),
      field("nearest", o.nearest, {0.02, 10}, "m", "SR300: 0.2 m"),
      field("farthest", o.farthest, {0.1, 20}, "m", "SR300: 1.5 m"),
      field("smoothing_step", o.smoothing_step, {1e-4, 0.1}, "m", "ours"),
      field("table_tolerance", o.table_tolerance, {5e-4, 0.05}, "m", "ours"),
      field("height_low", o.height_low, {0, 0.1}, "m", "ours"),
      field("height_high", o.height_high, {0.02, 3}, "m", "ours"),
      field("voxel", o.voxel, {0.001, 0.02}, "m", "ours"),
      field("normal_radius", o.normal_radius, {0.002, 0.05}, "m", "ours"),
      field("cluster_gap", o.cluster_gap, {0.002, 0.05}, "m", "ours"),
      field("cluster_points", o.cluster_points, {10, 100000}, "", "ours"),
      field("keypoint_spacing", o.keypoint_spacing, {0.003, 0.1}, "m",
            "ours: closer than 14 mm, which found fewer stones in an early experiment"),
      field("descriptor_radius", o.descriptor_radius, {0.01, 0.2}, "m",
            "ours: 40 mm found more stones than 50 mm in an early experiment"),
      field("neighbours", o.neighbours, {1, 20}, "", "ours"),
      field("consistency_size", o.consistency_size, {0.001, 0.1}, "m",
            "Chen and Bhanu 2004; about a keypoint's spacing"),
      field("consistency_fewest", o.consistency_fewest, {3, 100}, "", "ours"),
      field("best", o.best, {1, 1000}, "", "paper section 2: b, no value given; ours"),
      field("copies", o.copies, {1, 100}, "", "ours"),
      field("sweep", o.sweep, "ours; with method paper false"),
      field("icp_gate", o.icp_gate, {0.002, 0.1}, "m", "ours"),
      field("verify_tolerance", o.verify_tolerance, {0.001, 0.05}, "m", "ours"),
      field("accept_score", o.accept_score, {-1, 1}, "",
            "bench detection: below score p5, above every wrong pose"),
      field("accept_inlier_ratio", o.accept_inlier_ratio, {0, 1}, "", "with method paper; ours"),
      field("explained_margin", o.explained_margin, {0, 0.05}, "m", "ours"),
      field("bias_sigma", o.bias_sigma, {0, 0.02}, "m", "ours: a table in view replaces it"),
      field("bias_length", o.bias_length, {1, 1000}, "px", "ours: a table in view replaces it"),
      field("covariance_scale", o.covariance_scale, {0.01, 100}, "", "bench detection: column in 95 percent"),
      field("view_shift", o.view_shift, {0, 0.02}, "m", "ours: hand-eye and arm err by 1 to 2 mm"),
      field("view_turn", o.view_turn, {0, 0.1}, "rad", "ours"),
      field("trace", o.trace, "ours"),
      field("seed", o.seed, {0, 2147483647}, "", "ours"),
  };
}

DetectionOptions options_of(const std::string& method) {
  require(method == "default" || method == "paper", "method must be default or paper, got '", method, "'");
  DetectionOptions options;
  options.method = method;
  if (method == "paper") {
    options.descriptor = "rops";
    options.matching = "kdtree";
    options.sweep = false;
  }
  return options;
}

}  // namespace stonestack::detection
