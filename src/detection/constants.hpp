#pragma once

// Constants of this room, with unit and source: numbers that nothing needs to set.
namespace stonestack::detection {

// Scene
/// Depth step within a surface, m, at up to 1 m; grows with z^2. Design choice.
inline constexpr double kSmoothingStep = 0.006;
/// Distance from the table plane that counts as the table, m. Design choice.
inline constexpr double kTableTolerance = 0.004;
/// Height above the table where stones begin, m. Design choice.
inline constexpr double kMinHeight = 0.006;
/// Height above the table where stones end, m. The largest plane may be the floor, and stones lie on a bench.
inline constexpr double kMaxHeight = 2.0;
/// Spacing of scene and model points, m. Design choice.
inline constexpr double kVoxel = 0.003;
/// Radius of the neighbourhood that gives a normal, m. Design choice.
inline constexpr double kNormalRadius = 0.009;
/// Gap between the points of a cluster, m. Design choice.
inline constexpr double kClusterGap = 0.008;
/// Voxels of a cluster at least. Design choice.
inline constexpr int kClusterPoints = 60;
/// Distance to a stone of known pose within which points are its own, m. Design choice.
inline constexpr double kExplainedMargin = 0.008;
/// Reach of the smooth error of a depth image where no table shows it, pixels. Design choice.
inline constexpr double kBiasLength = 32.0;
/// Standard deviation of a further view's reported position along each axis, m: hand-eye and arm err by 1 to
/// 2 mm.
inline constexpr double kViewShift = 0.001;
/// Standard deviation of a further view's reported rotation, rad. Design choice.
inline constexpr double kViewTurn = 0.003;

// Segmentation
/// Cost from which on neighbouring parts of a surface stay apart: mean depth of the groove between them, sine
/// of half the angle. Chosen with the recordings and drawn rubble in view (docs/measurements.md).
inline constexpr double kPartCost = 0.33;
/// Cost that a part of one pixel is allowed more; falls with the square root of its pixels. Chosen as above.
inline constexpr double kPartAllowance = 10.0;

// Hypotheses
/// Spacing of the keypoints, m. Wider, 14 mm, found fewer stones in an early experiment.
inline constexpr double kKeypointSpacing = 0.010;
/// Radius of the descriptors, m. 40 mm found more stones than 50 mm in an early experiment.
inline constexpr double kDescriptorRadius = 0.040;
/// Nearest model descriptors matched to a scene descriptor. Design choice.
inline constexpr int kNeighbours = 1;
/// Consistency of a group's distances, m: about a keypoint's spacing (Chen and Bhanu 2004).
inline constexpr double kConsistencySize = 0.008;
/// Correspondences in a group at least. Design choice.
inline constexpr int kMinConsistent = 5;
/// Hypotheses for each model, b. Paper section 2 gives no value; design choice.
inline constexpr int kBestHypotheses = 30;

// Verdict
/// Distance of the furthest correspondence at first, m. Design choice.
inline constexpr double kIcpGate = 0.015;
/// Distance from the seen to the expected surface, m. Design choice.
inline constexpr double kVerifyTolerance = 0.005;

// Tracking
/// Rotation beyond which a stone has moved, rad. Design choice.
inline constexpr double kMovedTurn = 0.035;

}  // namespace stonestack::detection
