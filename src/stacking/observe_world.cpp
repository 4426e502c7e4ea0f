#include <algorithm>
#include <cmath>
#include <span>

#include "stacking/arrangement.hpp"
#include "stacking/camera_kept.hpp"
#include "stacking/constants.hpp"
#include "stacking/refuted_place.hpp"
#include "stacking/unknown_objects.hpp"
#include "stacking/workcell.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kCertainEnough = 0.6;  // of a stone and its pose: likelier than all else together
constexpr double kLow = 0.90;           // cosine: more than 26 deg off the vertical, so that sides are seen
constexpr double kOtherSide = 0.5;      // cosine between two level directions that show different sides
constexpr double kBelowTop = 0.03;      // m: where the camera points at a tower
// The next view may show a stone this much beside where the last one did, and it lies as it was predicted to.
constexpr double kSameShift = 0.015;    // m
constexpr double kViewSameTurn = 0.10;  // rad
constexpr double kSameLevel = 0.002;    // m, a stone of the tower: the most that two views of it differ by
constexpr double kSameTilt = 0.035;     // rad
constexpr int kMaxSiteViews = 3;
constexpr double kTurnedImage = 1.0;  // rad: views that are so much apart show a place in different pixels

Eigen::Vector2d level_direction(const Pose& T_W_C) {
  return T_W_C.linear().col(2).head<2>().normalized();
}

Arrangement expected_arrangement(const Expectation& expected) {
  WorldEstimate world;
  world.stack = expected.stack;
  world.loose = expected.loose;
  return at_rest(world);
}

/// Nobody knows what stands at the site when a run begins: if the views do not show that nothing does, more
/// are added that show it from its sides, and turned where one does not show enough of it.
SiteStatus view_site(Workcell& w, Views& views) {
  const Eigen::Vector2d& site = w.cell.layout.site;
  if (site_in(views, site) == SiteStatus::kFree) return SiteStatus::kFree;
  std::vector<Pose> poses =
      view_poses(w.cell.layout, {site.x(), site.y(), kSiteViewHeight}, w.options.view_distance);
  std::erase_if(poses, [](const Pose& T_W_C) { return -T_W_C.linear()(2, 2) > kLow; });
  Views of_site{view_along(w, route_to(w, {{}, true}, poses))};
  SiteStatus status = site_in(of_site, site);
  while (status == SiteStatus::kUnseen && static_cast<int>(of_site.size()) < kMaxSiteViews) {
    std::erase_if(poses, [&](const Pose& T_W_C) {
      return difference(T_W_C, of_site.back().T_W_C).angle < kTurnedImage;
    });
    const auto route = find_route(w, {{}, true}, poses);
    if (!route) break;
    of_site.push_back(view_along(w, *route));
    status = site_in(of_site, site);
  }
  if (status == SiteStatus::kOccupied) {
    w.emit(SiteOccupied{});
    const Eigen::Vector2d seen_along = level_direction(of_site.back().T_W_C);
    std::erase_if(poses,
                  [&](const Pose& T_W_C) { return level_direction(T_W_C).dot(seen_along) > kOtherSide; });
    // Only a missing route is passed over: an arm or a camera that fails ends the run.
    if (const auto route = find_route(w, {{}, true}, poses))
      of_site.push_back(view_along(w, *route));
    else
      w.emit(SiteSeenFromOneSide{});
  }
  views.insert(views.end(), of_site.begin(), of_site.end());
  return status;
}

/// The stack that is at the site by what was seen, from the table up.
std::vector<StoneEstimate> stack_seen(const Workcell& w, const std::vector<Sighting>& sightings) {
  std::vector<PlacedStone> seen;
  for (const Sighting& sighting : sightings) seen.push_back({sighting.stone, sighting.T_W_O});
  return as_estimates(sort_by_site(w.models.shapes, w.cell.layout.site, seen).stack);
}

/// The world by one view of the tower, and what was known of the field before; nothing if the new stone is
/// not where it should be or another leans on the tower: something else comes first then.
std::optional<WorldEstimate> predict_by_tower(Workcell& w, const Expectation& expected,
                                              const CameraView& of_site) {
  const Stopwatch watch;
  Arrangement tower = expected_arrangement(expected);
  tower.loose.clear();
  const auto sightings = find_in_views({of_site}, w.detection, {}, {tower, {}}, w.options.detection);
  WorldEstimate predicted;
  predicted.layout = w.cell.layout;
  predicted.site = expected.site;
  predicted.loose = expected.loose;
  predicted.stack =
      estimate_stones(w.models.shapes, w.cell.layout, expected.stack, sightings, w.options).stack;
  w.seconds.detection += watch.seconds();
  if (predicted.stack.size() != expected.stack.size() || stray_at_stack(w.models.shapes, at_rest(predicted)))
    return std::nullopt;
  const PoseDifference off =
      difference(predicted.stack.back().T_W_O_at_rest, expected.stack.back().T_W_O_at_rest);
  if (off.translation > w.options.placed_shift || off.angle > w.options.placed_turn) return std::nullopt;
  add_resting_stacks(w.models, w.options, expected.friction, predicted);
  return predicted;
}

bool alike(const ShapeList& shapes, const std::vector<PlacedStone>& a, const std::vector<PlacedStone>& b,
           double shift, double turn) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](const PlacedStone& p, const PlacedStone& q) {
    return same_place(shapes, p, q, shift, turn);
  });
}

/// If the world is as predicted, its stack rests as predicted, too: two views of it differ by noise only.
bool adopt(const ShapeList& shapes, const std::optional<WorldEstimate>& predicted, WorldEstimate& world) {
  if (!predicted || predicted->site != world.site) return false;
  const Arrangement a = at_rest(*predicted), b = at_rest(world);
  if (!alike(shapes, a.stack, b.stack, kSameLevel, kSameTilt) ||
      !alike(shapes, a.loose, b.loose, kSameShift, kViewSameTurn))
    return false;
  for (std::size_t i = 0; i < world.stack.size(); ++i)
    world.stack[i].T_W_O_at_rest = predicted->stack[i].T_W_O_at_rest;
  world.resting = predicted->resting;
  return true;
}

/// Makes obstacles of what is no stone, and keeps its surface for when it is out of sight.
void set_unknown_objects(Workcell& w, const std::vector<UnknownThing>& unknown) {
  auto& obstacles = w.cell.layout.obstacles;
  const std::size_t before = obstacles.size() - w.stated_obstacles.size();
  obstacles = w.stated_obstacles;
  w.unknown_surface_W.clear();
  for (std::size_t k = 0; k < unknown.size(); ++k) {
    const Obstacle& object =
        obstacles.emplace_back(obstacle_about(unknown[k], concat("unknown object ", k + 1)));
    const auto& surface = unknown[k].surface_W;
    w.unknown_surface_W.insert(w.unknown_surface_W.end(), surface.begin(), surface.end());
    if (unknown.size() == before) continue;
    Eigen::AlignedBox3d box;
    for (const auto& v : object.pieces.front().vertices) box.extend(v);
    w.emit(UnknownObjectSeen{box.center().head<2>(), box.max().z()});
  }
}

/// Views that are to be made into an estimate.
struct Seen {
  Views views;
  SiteStatus site = SiteStatus::kFree;
  Arrangement before;  ///< where stones are looked for first
  std::optional<WorldEstimate> predicted;
};

Seen take_views(Workcell& w, const Expectation& expected, const WhileMoving& while_moving) {
  Seen seen{{}, expected.site, expected_arrangement(expected), std::nullopt};
  const auto keep_prediction = [&](const WorldEstimate& predicted) {
    seen.predicted = predicted;
    while_moving(predicted);
  };
  if (expected.views) {
    seen.views = *expected.views;
    const DepthFrame frame = w.cell.camera.capture();
    seen.views.push_back({frame.image, camera_pose(w.cell.layout, *w.models.robot, w.cell.arm.state().q)});
    if (expected.first) seen.site = site_in(seen.views, w.cell.layout.site);
    return seen;
  }
  const ViewScene scene{seen.before, expected.first};
  const auto poses = [&](const Eigen::Vector2d& p_W, double height) {
    return view_poses(w.cell.layout, {p_W.x(), p_W.y(), height}, w.options.view_distance);
  };
  const std::vector<Pose> above_field = poses(w.cell.layout.field_centre, kFieldViewHeight);
  if (expected.stack.empty()) {
    seen.views.push_back(view_along(w, route_to(w, scene, above_field)));
    if (expected.first && w.options.refine_camera)
      seen.before = refine_camera(w, expected.friction, seen.views, keep_prediction);
    if (expected.first) seen.site = view_site(w, seen.views);
    if (expected.was_built)  // what fell may lie at the site and not be recognised
      seen.views.push_back(view_along(w, route_to(w, scene, poses(w.cell.layout.site, kSiteViewHeight))));
    return seen;
  }
  // The tower first: what comes next depends on it, and the field rarely shows anything new.
  const double top = top_height(w.models.shapes, seen.before.stack);
  seen.views.push_back(view_along(w, route_to(w, scene, poses(w.cell.layout.site, top - kBelowTop))));
  const JointTrajectory route = route_to(w, scene, above_field);
  seen.views.push_back(view_along(w, route, [&] {
    if (!expected.as_planned) return;
    if (const auto predicted = predict_by_tower(w, expected, seen.views.front())) keep_prediction(*predicted);
  }));
  return seen;
}

}  // namespace

void report_uncertain(const Workcell& w, const std::vector<Sighting>& sightings) {
  for (const Sighting& seen : sightings)
    if (seen.certainty < kCertainEnough) w.emit(StoneUncertain{seen.stone, seen.certainty});
}

Observation observe(Workcell& w, const Expectation& expected, const WhileMoving& while_moving) {
  Seen seen = take_views(w, expected, while_moving);
  // What no first view showed may come to light when others are taken away, but is not worth a search in all
  // views together after each of them.
  const Stopwatch watch;
  std::vector<StoneIndex> sought = first_stones(w.models.shapes.size());
  std::erase_if(sought, [&](StoneIndex stone) { return expected.disproved.contains(stone); });
  auto sightings = find_in_views(seen.views, w.detection, sought,
                                 {seen.before, expected.known, expected.first}, w.options.detection);
  if (!expected.first)
    drop_known_objects(w.models.shapes, expected.known,
                       std::span(w.cell.layout.obstacles).subspan(w.stated_obstacles.size()), sightings);
  const bool found_stack = expected.first && seen.site == SiteStatus::kOccupied;
  const auto refuted = [&](const PlacedStone& stone) {
    const bool is_new = expected.new_top && stone.stone == expected.stack.back().stone;
    return is_new || is_refuted(seen.views, w.models.stone(stone.stone).mesh, stone.T_W_O);
  };
  StoneEstimates stones =
      estimate_stones(w.models.shapes, w.cell.layout, found_stack ? stack_seen(w, sightings) : expected.stack,
                      sightings, w.options, refuted);
  Observation observation;
  WorldEstimate& world = observation.world;
  world.stack = std::move(stones.stack);
  world.loose = std::move(stones.loose);
  world.site = seen.site;
  for (auto* list : {&world.stack, &world.loose})
    for (StoneEstimate& stone : *list)
      for (const Sighting& sighting : sightings)
        if (sighting.stone == stone.stone && sighting.T_W_O.isApprox(stone.T_W_O_seen, 1e-9))
          stone.sigma = sighting.sigma;
  set_unknown_objects(w, unknown_objects(w, seen.views, world));
  world.layout = w.cell.layout;
  check_camera_kept(w, expected, world, seen.views.front());
  world.views = std::make_shared<const Views>(std::move(seen.views));
  observation.as_predicted = adopt(w.models.shapes, seen.predicted, world);
  if (!observation.as_predicted) add_resting_stacks(w.models, w.options, expected.friction, world);
  w.seconds.detection += watch.seconds();
  report_uncertain(w, sightings);
  return observation;
}

}  // namespace stonestack::stacking
