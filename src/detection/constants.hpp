#pragma once

/// Constants of this room with unit and source: numbers that nothing needs to set.
namespace stonestack::detection {

// Stages of detection
inline constexpr double kSmoothingStep =
    0.006;  // m, largest depth step within a surface, at up to 1 m; grows with z^2; design choice
inline constexpr double kTableTolerance = 0.004;   // m, from the table plane; design choice
inline constexpr double kMinHeight = 0.006;        // m above the table, where stones begin; design choice
inline constexpr double kMaxHeight = 0.7;          // m above the table, where they end; design choice
inline constexpr double kVoxel = 0.003;            // m, spacing of scene and model points; design choice
inline constexpr double kNormalRadius = 0.009;     // m; design choice
inline constexpr int kClusterPoints = 60;          // voxels of a cluster at least; design choice
inline constexpr double kKeypointSpacing = 0.010;  // m: 14 mm found fewer stones in an early experiment
inline constexpr double kDescriptorRadius =
    0.040;                             // m: 40 mm found more stones than 50 mm in an early experiment
inline constexpr int kNeighbours = 1;  // nearest model descriptors of a scene descriptor; design choice
inline constexpr double kConsistencySize =
    0.008;  // m, geometric consistency (Chen and Bhanu 2004); about a keypoint's spacing
inline constexpr int kMinConsistent = 5;           // correspondences in a group; design choice
inline constexpr double kIcpGate = 0.015;          // m, furthest correspondence at first; design choice
inline constexpr double kVerifyTolerance = 0.005;  // m, from seen to expected surface; design choice
inline constexpr double kExplainedMargin =
    0.008;  // m, points so near to a stone whose pose is known are its own; design choice
inline constexpr double kBiasLength =
    32.0;  // px, reach of the smooth error of a depth image where no table shows it; design choice
inline constexpr double kViewShift = 0.001;  // m, standard deviation an axis of a further view's reported
                                             // pose: hand-eye and arm err by 1 to 2 mm
inline constexpr double kViewTurn = 0.003;   // rad, the same of its rotation; design choice
inline constexpr double kClusterGap = 0.008;  // m between the points of a cluster; design choice
inline constexpr int kBestHypotheses =
    30;  // for each model; paper section 2: b, which gives no value; design choice

// Tracking
inline constexpr double kMovedTurn = 0.035;  // rad, a stone that turned further has moved; design choice

}  // namespace stonestack::detection
