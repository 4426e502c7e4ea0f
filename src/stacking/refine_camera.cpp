#include <algorithm>
#include <cmath>

#include "kinematics/camera_mount.hpp"
#include "physics/shape.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/mount_correction.hpp"
#include "stacking/workcell.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kCameraSameShift =
    0.015;  // m: a stone seen further off in the other view is not the same pose
constexpr double kCameraSameTurn = 0.10;  // rad
constexpr double kTowardsSite = 0.10;     // m

/// Poses above the same place, a little towards the site so that it shows, too, with the camera turned about
/// its axis: by half a turn, else by a quarter.
std::vector<Pose> turned_poses(const Pose& T_W_C, const CellLayout& layout) {
  const Eigen::Vector2d towards = kTowardsSite * (layout.site - layout.field_centre).normalized();
  const Pose moved = Eigen::Translation3d(towards.x(), towards.y(), 0.0) * T_W_C;
  std::vector<Pose> poses;
  for (const double turn : {M_PI, 0.5 * M_PI, -0.5 * M_PI})
    poses.push_back(moved * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  return poses;
}

bool is_same(const Pose& T_W_a, const Pose& T_W_b) {
  const auto apart = difference(T_W_a, T_W_b);
  return apart.translation <= kCameraSameShift && apart.angle <= kCameraSameTurn;
}

/// Stones that both results show at the same pose, as marks of each: their centres of mass.
void add_marks(const ShapeList& shapes, const CameraView& a, const DetectionResult& in_a, const CameraView& b,
               const DetectionResult& in_b, MountView& view_a, MountView& view_b) {
  for (const Detection& seen_a : in_a.detections)
    for (const Detection& seen_b : in_b.detections) {
      if (seen_a.stone != seen_b.stone) continue;
      if (!is_same(a.T_W_C * seen_a.T_C_O, b.T_W_C * seen_b.T_C_O)) continue;
      const Eigen::Vector3d& p_O_M = at(shapes, seen_a.stone)->mass.p_O_M;
      view_a.marks.push_back({seen_a.stone.value(), seen_a.T_C_O * p_O_M});
      view_b.marks.push_back({seen_b.stone.value(), seen_b.T_C_O * p_O_M});
    }
}

std::vector<Sighting> sightings_in(const CameraView& view, const DetectionResult& seen) {
  std::vector<Sighting> list;
  for (const Detection& found : seen.detections)
    list.push_back({found.stone, view.T_W_C * found.T_C_O, found.score, found.visible, found.certainty});
  return list;
}

/// Every stone that two views showed at the same pose, where the first did.
Arrangement seen_in_both(const Views& views, const std::vector<DetectionResult>& seen) {
  Arrangement arrangement;
  for (const Detection& a : seen[0].detections)
    for (const Detection& b : seen[1].detections) {
      const Pose T_W_O = views[0].T_W_C * a.T_C_O;
      if (a.stone == b.stone && is_same(T_W_O, views[1].T_W_C * b.T_C_O))
        arrangement.loose.push_back({a.stone, T_W_O});
    }
  return arrangement;
}

}  // namespace

Arrangement refine_camera(Workcell& w, const FrictionEstimate& friction, Views& views,
                          const WhileMoving& while_moving) {
  const Pose T_T_C = w.cell.layout.T_T_C;
  std::vector<MountView> mounts;
  std::vector<DetectionResult> seen;
  const auto detect = [&](const CameraView& view) {
    const Stopwatch watch;
    seen.push_back(detect_stones(view.image, w.detection, {}, w.options.detection));
    report_uncertain(w, sightings_in(view, seen.back()));
    mounts.push_back({view.T_W_C * T_T_C.inverse(), seen.back().table_C, {}});
    w.seconds.detection += watch.seconds();
  };
  const auto route = find_route(w, {{}, true}, turned_poses(views.front().T_W_C, w.cell.layout));
  if (!route) {
    w.emit(CameraNotTurned{});
    return {};
  }
  views.push_back(view_along(w, *route, [&] {
    detect(views.front());
    WorldEstimate predicted;
    predicted.layout = w.cell.layout;
    predicted.loose = estimate_stones(w.models.shapes, w.cell.layout, {},
                                      sightings_in(views.front(), seen.front()), w.options)
                          .loose;
    add_resting_stacks(w.models, w.options, friction, predicted);
    while_moving(predicted);
  }));
  detect(views.back());
  const Stopwatch watch;
  add_marks(w.models.shapes, views[0], seen[0], views[1], seen[1], mounts[0], mounts[1]);
  const MountRefinement found = refine_camera_mount(mounts, T_T_C);
  w.seconds.detection += watch.seconds();
  const MountCorrection correction = correction_of(found, w.cell.layout);
  w.emit(CameraRefined{found.shift, found.turn, found.shared_marks, found.before, found.after,
                       correction.height, correction.tilt, correction.accepted});
  if (correction.accepted) {
    apply(correction, w.cell.layout);
    for (std::size_t k = 0; k < views.size(); ++k)
      views[k].T_W_C = correction.T_level * mounts[k].T_W_T * found.T_T_C;
  }
  return seen_in_both(views, seen);
}

}  // namespace stonestack::stacking
