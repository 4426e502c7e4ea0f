#pragma once
#include <span>
#include <string>
#include <vector>

#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::detection {

/// A keypoint of the scene and the keypoint of a model that is described most alike.
struct TracedMatch {
  StoneIndex stone = kNoStone;
  Eigen::Vector3f p_C, p_O;
  float distance = 0.0F;  ///< squared, in descriptor space
};

/// A pose that a source proposed.
struct TracedHypothesis {
  StoneIndex stone = kNoStone;
  std::string source;    ///< consistency, sweep
  double support = 0.0;  ///< correspondences in the group, or 1 / cost of the sweep
  Pose T_C_O = Pose::Identity();
};

/// A refined and verified pose.
struct TracedCandidate {
  Detection detection;
  bool accepted = false;
  double wanted = 0.0;  ///< score that it needs
  ScoreLosses lost{};
};

/// One search of the points that were still unexplained.
struct TracedTurn {
  std::vector<Eigen::Vector3f> surface_C;  ///< voxels above the table
  std::vector<int> cluster;                ///< of each; -1 for specks
  std::vector<Eigen::Vector3f> keypoints_C;
  std::vector<TracedMatch> matches;
  std::vector<TracedHypothesis> hypotheses;
  std::vector<TracedCandidate> candidates;
};

/// Data of each stage of detection, in the order of the turns.
struct DetectionTrace {
  std::vector<StoneIndex> searched;  ///< stones that were searched for, sorted
  std::vector<TracedTurn> turns;
};

}  // namespace stonestack::detection
