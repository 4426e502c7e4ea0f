#include "stonestack/core/error.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::detection {

FieldList fields(DetectionOptions& o) {
  return {
      user(field("method", o.method,
                 "default, or paper: section 2 of the paper as a set of options, which others override")),
      field("keypoints", o.keypoints, "voxel or iss"),
      field("descriptor", o.descriptor, "shot, fpfh, iss or rops; with method paper rops"),
      field("matching", o.matching,
            "exact, or kdtree, which finds the same matches; with method paper kdtree"),
      user(field("nearest", o.nearest, {0.02, 10}, "m", "depths below are ignored; SR300: 0.2 m")),
      user(field("farthest", o.farthest, {0.1, 20}, "m", "depths above are ignored; SR300: 1.5 m")),
      field("copies", o.copies, {1, 100}, "", "of each stone that may be in one scene"),
      field("sweep", o.sweep,
            "true: all orientations are tried on each cluster, too; with method paper false"),
      user(field("accept_score", o.accept_score, {-1, 1}, "",
                 "smallest score of a detection: higher finds fewer stones and fewer wrong ones")),
      field("accept_inlier_ratio", o.accept_inlier_ratio, {0, 1}, "",
            "smallest inlier ratio of a detection with method paper"),
      field("bias_sigma", o.bias_sigma, {0, 0.02}, "m",
            "smooth error of a depth image, one sigma, where no table shows what it is"),
      field("trace", o.trace, "keeps what each stage saw for --trace"),
      field("seed", o.seed, {0, 2147483647}, "", "seed of detection's random numbers"),
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
