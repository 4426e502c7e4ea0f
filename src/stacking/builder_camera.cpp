#include <algorithm>

#include "stacking/builder.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/camera_mount.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kSameShift = 0.015;   // m: a stone seen further off in the other view is not the same pose
constexpr double kSameTurn = 0.10;     // rad
constexpr double kTowardsSite = 0.10;  // m
// A mount further off than this was calibrated wrongly or has been hit; a person should know.
constexpr double kLargestShift = 0.008;  // m
constexpr double kLargestTurn = 0.026;   // rad
constexpr double kLargestLeft = 0.002;   // m between the views afterwards

/// The same place, a little towards the site so that it shows, too, seen with the camera turned about its
/// axis: by half a turn, else by a quarter.
std::vector<Pose> turned_poses(const Pose& T_W_C, const CellLayout& layout) {
  const Eigen::Vector2d towards = kTowardsSite * (layout.site - layout.field_centre).normalized();
  const Pose moved = Eigen::Translation3d(towards.x(), towards.y(), 0.0) * T_W_C;
  std::vector<Pose> poses;
  for (const double turn : {M_PI, 0.5 * M_PI, -0.5 * M_PI})
    poses.push_back(moved * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  return poses;
}

/// Stones that both results show at the same pose, as marks of each: their centres of mass.
void add_marks(const ShapeList& shapes, const Look& a, const DetectionResult& in_a, const Look& b,
               const DetectionResult& in_b, MountView& view_a, MountView& view_b) {
  for (const Detection& seen_a : in_a.detections)
    for (const Detection& seen_b : in_b.detections) {
      if (seen_a.stone != seen_b.stone) continue;
      const auto apart = difference(a.T_W_C * seen_a.T_C_O, b.T_W_C * seen_b.T_C_O);
      if (apart.translation > kSameShift || apart.angle > kSameTurn) continue;
      const Eigen::Vector3d& p_O_M = shapes[static_cast<std::size_t>(seen_a.stone)]->mass.p_O_M;
      view_a.marks.push_back({seen_a.stone, seen_a.T_C_O * p_O_M});
      view_b.marks.push_back({seen_b.stone, seen_b.T_C_O * p_O_M});
    }
}

std::vector<Sighting> sightings_in(const Look& look, const DetectionResult& seen) {
  std::vector<Sighting> list;
  for (const Detection& found : seen.detections)
    list.push_back({found.stone, look.T_W_C * found.T_C_O, found.score, found.visible, found.certainty});
  return list;
}

/// Every stone that some look showed, where the first of them did.
Belief seen_in(const std::vector<Look>& looks, const std::vector<DetectionResult>& seen) {
  Belief belief;
  for (std::size_t k = 0; k < looks.size(); ++k)
    for (const Detection& found : seen[k].detections)
      if (std::none_of(belief.loose.begin(), belief.loose.end(),
                       [&](const PlacedStone& s) { return s.stone == found.stone; }))
        belief.loose.push_back({found.stone, looks[k].T_W_C * found.T_C_O});
  return belief;
}

}  // namespace

Belief Builder::refine_camera(std::vector<Look>& looks) {
  const Pose T_T_C = cell_.layout.T_T_C;
  std::vector<MountView> views;
  std::vector<DetectionResult> seen;
  const auto detect = [&](const Look& look) {
    const Stopwatch watch;
    seen.push_back(detect_stones(look.image, models_, {}, options_.detection));
    report_doubtful(sightings_in(look, seen.back()));
    views.push_back({look.T_W_C * T_T_C.inverse(), seen.back().table_C, {}});
    result_.seconds.detection += watch.seconds();
  };
  const auto way = find_way_to_look(turned_poses(looks.front().T_W_C, cell_.layout), true);
  if (!way) {
    report("the camera cannot be turned above the field; its mount is taken as calibrated");
    return {};
  }
  looks.push_back(look_along(*way, [&] {
    detect(looks.front());
    search_ahead(believe(shapes_, cell_.layout, {}, sightings_in(looks.front(), seen.front())));
  }));
  detect(looks.back());
  const Stopwatch watch;
  add_marks(shapes_, looks[0], seen[0], looks[1], seen[1], views[0], views[1]);
  const MountRefinement found = refine_camera_mount(views, T_T_C);
  result_.seconds.detection += watch.seconds();
  const std::string text =
      concat("camera mount: ", std::round(1e4 * found.shift) / 10, " mm and ",
             std::round(found.turn * 572.9578) / 10, " deg beside its calibration by ", found.shared_marks,
             " stones seen twice, ", std::round(1e4 * found.before) / 10, " mm apart, then ",
             std::round(1e4 * found.after) / 10, " mm");
  record("camera_mount", concat("{\"shift_m\": ", found.shift, ", \"turn_rad\": ", found.turn,
                                ", \"marks\": ", found.shared_marks, ", \"before_m\": ", found.before,
                                ", \"after_m\": ", found.after, "}"));
  if (found.shift > kLargestShift || found.turn > kLargestTurn || found.after > kLargestLeft) {
    report(text + "; not believed: run `stonestack calibrate`");
  } else {
    report(text);
    cell_.layout.T_T_C = found.T_T_C;
    for (std::size_t k = 0; k < looks.size(); ++k) looks[k].T_W_C = views[k].T_W_T * found.T_T_C;
  }
  return seen_in(looks, seen);
}

}  // namespace stonestack::stacking
