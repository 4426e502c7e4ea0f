#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/physics/stack.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stacking {

/// Stones of a scene by where they are: the stack from the table up, and the loose ones.
struct Arrangement {
  std::vector<PlacedStone> stack;  ///< stones of the tower, from the table up
  std::vector<PlacedStone> loose;  ///< other stones
};

/// One depth image and where it was taken from.
struct CameraView {
  DepthImage image;               ///< depth image
  Pose T_W_C = Pose::Identity();  ///< pose of the camera, from the arm
};
/// Views of one observation, in order.
using Views = std::vector<CameraView>;

/// Standard deviations of a pose that was measured; 0: unknown.
struct PoseSigma {
  Eigen::Vector3d translation_W = Eigen::Vector3d::Zero();  ///< along the axes of W [m]
  double turn = 0.0;                                        ///< root mean square about the three axes [rad]
};

/// Where one stone is.
struct StoneEstimate {
  StoneIndex stone = kNoStone;            ///< index into the catalogue
  Pose T_W_O_seen = Pose::Identity();     ///< as the camera showed it last while it had not come to rest; as
                                          ///< aimed before it was seen
  Pose T_W_O_at_rest = Pose::Identity();  ///< where it rests according to physics; of a loose stone as seen
  PoseSigma sigma = {};                   ///< of `T_W_O_seen`; no decision depends on it
};

/// The site when a run begins: not seen, nothing on it, or something.
enum class SiteStatus { kUnseen, kFree, kOccupied };

/// The stack at one assumed friction: as it comes to rest, or why it would not stand.
struct RestingStack {
  double friction = 0.0;       ///< friction coefficient at which it was settled
  std::optional<Stack> stack;  ///< stack at rest; empty if it does not stand
  std::string reason;          ///< reason why it does not stand
};

/// How likely each of some frictions is that the stones may have.
struct FrictionEstimate {
  std::vector<double> frictions;  ///< rising
  std::vector<double> weights;    ///< sum to 1
};

/// State of the cell as the program knows it: only from what camera and sensors reported.
struct WorldEstimate {
  std::vector<StoneEstimate> stack;     ///< from the table up
  std::vector<StoneEstimate> loose;     ///< on the table
  SiteStatus site = SiteStatus::kFree;  ///< state of the site
  CellLayout layout;                    ///< as calibrated, the camera's mount as the first views corrected it
  std::vector<RestingStack> resting;    ///< the stack (`T_W_O_at_rest`) at each friction that is assumed
  std::shared_ptr<const Views> views;   ///< that it was made from; null when it was read from a file
};

/// The stones where they rest.
[[nodiscard]] Arrangement at_rest(const WorldEstimate& world);
/// The stones where they were seen, as if they rested there.
[[nodiscard]] std::vector<StoneEstimate> as_estimates(const std::vector<PlacedStone>& stones);
/// True if `stone` is among `stones`.
[[nodiscard]] bool holds(const std::vector<StoneEstimate>& stones, StoneIndex stone);

}  // namespace stonestack::stacking

#pragma GCC visibility pop
