#include "stacking/camera_kept.hpp"

#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kSlid = 0.030;             // m: further than stones slide when they are let go of
constexpr double kKeptHeight = 0.010;       // m
constexpr double kKeptTurn = 0.10;          // rad
constexpr double kTurnedAxis = -0.5;        // cosine: the camera is turned by 120 deg or more
constexpr double kTwoPlaces = 0.5 * kSlid;  // m: a camera that slid by kSlid shows twice as much

/// In the stack, else loose; null: not seen.
const StoneEstimate* seen_of(const WorldEstimate& world, StoneIndex stone) {
  for (const auto* list : {&world.stack, &world.loose})
    for (const StoneEstimate& estimate : *list)
      if (estimate.stone == stone) return &estimate;
  return nullptr;
}

/// Did it go aside, as high as before and not turned?
bool slid(const ShapeList& shapes, const PlacedStone& before, const PlacedStone& now) {
  const Eigen::Vector3d p_W = com_of(shapes, now) - com_of(shapes, before);
  return p_W.head<2>().norm() > kSlid && std::abs(p_W.z()) < kKeptHeight &&
         difference(before.T_W_O, now.T_W_O).angle < kKeptTurn;
}

/// Where one view shows a stone.
std::optional<PlacedStone> shown_in(const Workcell& w, const CameraView& view, StoneIndex stone) {
  const std::vector<StoneIndex> wanted{stone};
  for (const Detection& found :
       detect_stones(view.image, w.detection, wanted, w.options.detection).detections)
    if (found.stone == stone) return PlacedStone{stone, view.T_W_C * found.T_C_O};
  return std::nullopt;
}

}  // namespace

void check_camera_kept(Workcell& w, const Expectation& expected, const WorldEstimate& seen,
                       const CameraView& of_site) {
  if (!expected.as_planned || expected.stack.empty()) return;
  const StoneEstimate& placed = expected.stack.back();
  const StoneEstimate* const now = seen_of(seen, placed.stone);
  const PlacedStone before{placed.stone, placed.T_W_O_at_rest};
  if (now == nullptr || !slid(w.models.shapes, before, {placed.stone, now->T_W_O_seen})) return;

  Arrangement both = at_rest(seen);  // whichever is true
  both.loose.push_back(before);
  const Eigen::Vector2d& site = w.cell.layout.site;
  std::vector<Pose> poses =
      view_poses(w.cell.layout, {site.x(), site.y(), kSiteViewHeight}, w.options.view_distance);
  std::erase_if(poses, [&](const Pose& T_W_C) {
    return T_W_C.linear().col(0).dot(of_site.T_W_C.linear().col(0)) > kTurnedAxis;
  });
  const auto route = find_route(w, {both, false}, poses);
  if (!route) return;
  const auto here = shown_in(w, of_site, placed.stone);
  const auto turned = shown_in(w, view_along(w, *route), placed.stone);
  if (!here || !turned || difference(here->T_W_O, turned->T_W_O).angle > kKeptTurn) return;
  const double apart = (com_of(w.models.shapes, *here) - com_of(w.models.shapes, *turned)).norm();
  if (apart > kTwoPlaces)
    throw DeviceError("camera",
                      concat("shows ", w.models.name(placed.stone), " in places that are ",
                             std::lround(1e3 * apart), " mm apart before and after a turn"),
                      "its mount has moved: calibrate it, then start or resume the run");
}

}  // namespace stonestack::stacking
