#include "stonestack/detection/detect_stones.hpp"

namespace stonestack {

FieldList fields(DetectionOptions& o) {
  return {
      field("method", o.method, "default, or paper (section 2 to the letter)"),
      field("keypoints", o.keypoints, "voxel or iss; paper section 2"),
      field("descriptor", o.descriptor, "shot, fpfh or rops; paper section 2: rops"),
      field("nearest", o.nearest, {0.02, 10}, "m", "SR300: 0.2 m"),
      field("farthest", o.farthest, {0.1, 20}, "m", "SR300: 1.5 m"),
      field("smoothing_step", o.smoothing_step, {1e-4, 0.1}, "m", "measured: bench detection"),
      field("table_tolerance", o.table_tolerance, {5e-4, 0.05}, "m", "ours"),
      field("height_low", o.height_low, {0, 0.1}, "m", "ours"),
      field("height_high", o.height_high, {0.02, 3}, "m", "ours"),
      field("voxel", o.voxel, {0.001, 0.02}, "m", "measured: bench detection"),
      field("normal_radius", o.normal_radius, {0.002, 0.05}, "m", "measured: bench detection"),
      field("cluster_gap", o.cluster_gap, {0.002, 0.05}, "m", "ours"),
      field("cluster_points", o.cluster_points, {10, 100000}, "", "ours"),
      field("keypoint_spacing", o.keypoint_spacing, {0.003, 0.1}, "m", "measured: bench detection"),
      field("descriptor_radius", o.descriptor_radius, {0.01, 0.2}, "m", "measured: bench detection"),
      field("neighbours", o.neighbours, {1, 20}, "", "measured: bench detection"),
      field("consistency_size", o.consistency_size, {0.001, 0.1}, "m",
            "Chen and Bhanu 2004; about a keypoint's spacing"),
      field("consistency_fewest", o.consistency_fewest, {3, 100}, "", "measured: bench detection"),
      field("best", o.best, {1, 1000}, "", "paper section 2: b, no value given; measured"),
      field("sweep", o.sweep, "measured: bench detection"),
      field("icp_gate", o.icp_gate, {0.002, 0.1}, "m", "measured: bench detection"),
      field("verify_tolerance", o.verify_tolerance, {0.001, 0.05}, "m", "measured: bench detection"),
      field("accept_score", o.accept_score, {-1, 1}, "", "measured: bench detection"),
      field("accept_inlier_ratio", o.accept_inlier_ratio, {0, 1}, "", "with method paper; measured"),
      field("explained_margin", o.explained_margin, {0, 0.05}, "m", "ours"),
      field("noise_scale", o.noise_scale, {1e-5, 0.1}, "m", "calibrated: bench detection"),
      field("seed", o.seed, {0, 2147483647}, "", "ours"),
  };
}

}  // namespace stonestack
