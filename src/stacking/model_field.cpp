#include "stacking/model_field.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <deque>
#include <utility>

#include "core/constants.hpp"
#include "modelling/no_model.hpp"
#include "motion/collision.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/back_away.hpp"
#include "stacking/constants.hpp"
#include "stacking/model_again.hpp"
#include "stacking/mount_correction.hpp"
#include "stacking/record.hpp"
#include "stacking/survey.hpp"
#include "stacking/turn_stone.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/geometry/obstacle.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::stacking {
namespace {

using modelling::AlignedScene;
using modelling::LyingObject;
using modelling::ObjectModel;

constexpr double kFieldHeight = 0.04;      // m: where the camera points at the field
constexpr double kSeenEnough = 0.62;       // of a surface: both sides were, and what both hide is left
constexpr double kLeavingDistance = 0.62;  // m from the camera to the field
constexpr double kCertainlyKnown = 0.6;    // of a known stone and its pose: likelier than all else together

/// Corrects the camera's mount and the table's height by views that agree, then moves these to where arm and
/// mount say that they are, all told.
void refine_mount(const std::vector<SurveyView>& reported, AlignedScene& scene, CellLayout& layout) {
  std::vector<Eigen::Vector3d> marks;
  for (int object = 0; object < static_cast<int>(scene.segmentation.objects.size()); ++object)
    marks.push_back(middle_of_object(scene, object));
  if (marks.empty()) return;
  const Plane table{Eigen::Vector3d::UnitZ(), 0.0};
  std::vector<MountView> mounts;
  for (std::size_t k = 0; k < reported.size(); ++k) {
    const Pose T_C_W = scene.views[k].T_W_C.inverse();
    MountView mount;
    mount.T_W_T = reported[k].T_W_T;
    const Eigen::Vector3d n_C = T_C_W.linear() * table.normal;
    mount.table_C = Plane{n_C, n_C.dot(T_C_W.translation())};
    for (std::size_t m = 0; m < marks.size(); ++m)
      mount.marks.push_back({static_cast<int>(m), T_C_W * marks[m]});
    mounts.push_back(std::move(mount));
  }
  const MountRefinement found = refine_camera_mount(mounts, layout.T_T_C);
  const MountCorrection correction = correction_of(found, layout);
  log_debug(concat("camera's mount moved by ", 1e3 * found.shift, " mm and ", found.turn,
                   " rad, marks apart ", 1e3 * found.before, " mm before, ", 1e3 * found.after,
                   " mm after; table at ", 1e3 * correction.height, " mm"));
  if (!correction.accepted) {
    log_warning(
        "the camera's mount or the table lie further off than a calibration errs, or the views of them "
        "disagree; they are taken to be as the cell states: check the calibration with doctor");
    return;
  }
  apply(correction, layout);
  const Eigen::Vector2d& at = layout.field_centre;
  // Mean of where arm and mount put each view, against where the views agree: level already, so only a turn
  // about the vertical and a shift along the table.
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double yaw = 0.0;
  const Eigen::Vector3d p_W(at.x(), at.y(), 0.0);
  for (std::size_t k = 0; k < reported.size(); ++k) {
    const Pose off =
        correction.T_level * reported[k].T_W_T * correction.T_T_C * scene.views[k].T_W_C.inverse();
    shift += (off * p_W - p_W).head<2>() / static_cast<double>(reported.size());
    yaw += std::atan2(off.linear()(1, 0), off.linear()(0, 0)) / static_cast<double>(reported.size());
  }
  const Pose move = Eigen::Translation3d(at.x() + shift.x(), at.y() + shift.y(), 0.0) *
                    Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                    Eigen::Translation3d(-at.x(), -at.y(), 0.0);
  for (DepthView& view : scene.views) view.T_W_C = move * view.T_W_C;
}

AlignedScene align(const std::vector<SurveyView>& survey, const ModelFieldOptions& options,
                   CellLayout& layout) {
  std::vector<DepthView> views;
  for (const SurveyView& taken : survey) views.push_back({taken.view.image, taken.view.T_W_C});
  AlignedScene scene = modelling::align_scene(views, options.modelling);
  refine_mount(survey, scene, layout);
  return scene;
}

/// Stones that are known, where the views show them.
std::vector<StoneCandidate> find_known(const AlignedScene& scene, const ModelFieldOptions& options) {
  std::vector<StoneCandidate> found;
  if (options.known == nullptr || options.known->stones.empty()) return found;
  std::vector<CameraView> views;
  for (const DepthView& view : scene.views) views.push_back({view.image, view.T_W_C});
  const DetectionModels models(options.known->stones, options.detection);
  for (const Sighting& seen : find_in_views(views, models, first_stones(options.known->stones.size()),
                                            {{}, {}, true}, options.detection)) {
    if (seen.certainty < kCertainlyKnown) continue;
    StoneCandidate candidate;
    candidate.stone = (*options.known)[seen.stone];
    candidate.T_W_O = seen.T_W_O;
    candidate.model.mesh = transformed(candidate.stone.mesh, seen.T_W_O);
    candidate.model.seen.assign(candidate.model.mesh.vertices.size(), 1);
    candidate.model.sigma.assign(candidate.model.mesh.vertices.size(), 0.0);
    candidate.model.seen_share = 1.0;
    candidate.model.views = static_cast<int>(views.size());
    candidate.object = -1;
    candidate.made.name = candidate.stone.name;
    candidate.made.known = true;
    candidate.made.note = "known before: recognised";
    describe_model(candidate);
    found.push_back(std::move(candidate));
  }
  return found;
}

/// Names that a modelled stone must not get.
std::vector<std::string> names_taken(const std::vector<StoneCandidate>& candidates,
                                     const ModelFieldOptions& options) {
  std::vector<std::string> names;
  for (const StoneCandidate& candidate : candidates) names.push_back(candidate.made.name);
  if (options.known != nullptr)
    for (const Stone& stone : options.known->stones) names.push_back(stone.name);
  return names;
}

/// Makes a stone of an object as one scene shows it; the reason where it is none, or none for the gripper.
std::string model_alone(const LyingObject& lying, const GripperModel& gripper,
                        const ModelFieldOptions& options, StoneCandidate& candidate) {
  std::optional<ObjectModel> model = modelling::model_object({&lying, 1}, options.modelling);
  if (!model) return modelling::kNoModel;
  candidate.object = lying.object;
  candidate.model = std::move(*model);
  candidate.made_of = {lying};
  try {
    candidate.stone = stone_of_model(candidate.model, candidate.made, options);
  } catch (const FileError& problem) {
    return problem.what();
  }
  candidate.T_W_O = candidate.stone.T_O_file.inverse();
  describe_model(candidate);
  return unfit_for_gripper(candidate.stone, gripper);
}

std::vector<StoneCandidate> model_first(const AlignedScene& scene, const CellLayout& layout,
                                        const GripperModel& gripper, const ModelFieldOptions& options,
                                        std::vector<std::string>& left_out) {
  std::vector<StoneCandidate> candidates = find_known(scene, options);
  const std::size_t known = candidates.size();
  for (int object = 0; object < static_cast<int>(scene.segmentation.objects.size()); ++object) {
    throw_if_interrupted();
    const auto& seen = scene.segmentation.objects[static_cast<std::size_t>(object)];
    log_debug(concat("object at (", middle_of_object(scene, object).transpose(), ") m, size ",
                     seen.size.transpose(), " m, ", seen.pixels, " pixels in ", seen.views,
                     " views, confidence ", seen.confidence));
    if (is_of_known(scene, object, {candidates.data(), known})) continue;
    std::string why = unfit_object(scene, object, layout);
    if (why.empty()) {
      StoneCandidate candidate;
      candidate.made.name = modelled_name(names_taken(candidates, options));
      why = model_alone({&scene, object}, gripper, options, candidate);
      if (why.empty()) {
        candidates.push_back(std::move(candidate));
        continue;
      }
    }
    const Eigen::Vector3d at = middle_of_object(scene, object);
    left_out.push_back(concat("object at (", at.x(), ", ", at.y(), ") m: ", why));
  }
  return candidates;
}

/// True for a piece of a modelled stone that some view parted from it.
bool is_part_of(const AlignedScene& scene, int object, const ObjectModel& model) {
  return share_on(scene.segmentation.objects[static_cast<std::size_t>(object)].cloud_C,
                  scene.views.front().T_W_C, model.mesh) > 0.9;
}

/// Obstacles for objects that no stone was made of: as far as they are seen, down to the table.
std::vector<Obstacle> obstacles_of(const AlignedScene& scene, const std::vector<StoneCandidate>& candidates) {
  std::vector<Obstacle> others;
  for (int object = 0; object < static_cast<int>(scene.segmentation.objects.size()); ++object) {
    if (std::any_of(candidates.begin(), candidates.end(),
                    [&](const StoneCandidate& candidate) {
                      return candidate.object == object || is_part_of(scene, object, candidate.model);
                    }) ||
        is_of_known(scene, object, candidates))
      continue;
    Obstacle other;
    other.name = concat("object ", object + 1);
    other.pieces = {hull_to_table(scene.segmentation.objects[static_cast<std::size_t>(object)].cloud_C,
                                  scene.views.front().T_W_C)};
    others.push_back(std::move(other));
  }
  return others;
}

PlanningScene scene_with(const CellLayout& layout, const RobotModel& robot,
                         const std::vector<StoneCandidate>& candidates, const std::vector<Obstacle>& others) {
  PlanningScene scene = make_planning_scene(layout, robot, {}, {});
  for (const StoneCandidate& candidate : candidates)
    scene.objects.push_back(candidate.seen_W.empty()
                                ? SceneObject{candidate.stone.name, candidate.stone.pieces, candidate.T_W_O}
                                : SceneObject{candidate.stone.name, candidate.seen_W, Pose::Identity()});
  for (const Obstacle& other : others) scene.objects.push_back({other.name, other.pieces, other.T_W_O});
  return scene;
}

/// Unseen surface of all stones that were moved, or seen in one survey only, where they lie now.
std::vector<SurfaceElement> unseen_surface(const std::vector<StoneCandidate>& candidates) {
  std::vector<SurfaceElement> elements;
  for (const StoneCandidate& candidate : candidates) {
    if (!is_looked_for(candidate)) continue;
    const Mesh& mesh = candidate.model.mesh;
    const Pose T_W_model = candidate.T_W_O * candidate.stone.T_O_file;
    for (const auto& face : mesh.faces) {
      bool seen = false;
      for (int k = 0; k < 3; ++k) seen |= candidate.model.seen[static_cast<std::size_t>(face[k])] != 0;
      const auto& a = mesh.vertices[static_cast<std::size_t>(face[0])];
      const Eigen::Vector3d n = 0.5 * (mesh.vertices[static_cast<std::size_t>(face[1])] - a)
                                          .cross(mesh.vertices[static_cast<std::size_t>(face[2])] - a);
      if (n.norm() < 1e-12) continue;
      // What was seen ties both poses together, so it counts a little.
      elements.push_back({T_W_model * a, T_W_model.linear() * n.normalized(), (seen ? 0.3 : 1.0) * n.norm()});
    }
  }
  return elements;
}

/// Why what was weighed is no stone; empty: it may be one.
std::string unlike_stone(const StoneCandidate& candidate) {
  if (!candidate.made.mass) return {};
  const double density = *candidate.made.mass / volume(candidate.stone.scan);
  log_debug(concat(candidate.made.name, " weighs ", *candidate.made.mass, " kg, ", density, " kg/m^3"));
  if (density > kLightStone && density < kHeavyStone) return {};
  return concat("weighs ", std::round(1e3 * *candidate.made.mass) / 1e3, " kg, ", std::lround(density),
                " kg/m^3: no stone");
}

/// Route to a view of the whole field from which a run can begin, which does not know the field yet: not with
/// the fingers where stones may stand.
std::optional<JointTrajectory> route_from_field(Cell& cell, const PlanningScene& scene,
                                                const Eigen::Vector3d& p_W_field,
                                                const ModelFieldOptions& options) {
  constexpr double kClear = 0.01;  // m, more than the layout is corrected by
  PlanningScene unknown = scene;
  unknown.objects.push_back(unseen_field(cell.layout));
  unknown.objects.push_back(unseen_site(cell.layout));
  const CollisionChecker at_start(unknown);
  for (const Pose& T_W_C : view_poses(cell.layout, p_W_field, kLeavingDistance)) {
    auto route = plan_route_to_view(cell, scene, {T_W_C}, options.motion);
    if (route && !at_start.collides(route->q.back(), kClear)) return route;
  }
  return std::nullopt;
}

void leave_field(Cell& cell, PlanningScene scene, const Eigen::Vector3d& p_W_field,
                 const ModelFieldOptions& options) {
  scene.opening = present_opening(cell, scene.gripper);
  const auto route = route_from_field(cell, scene, p_W_field, options);
  if (!route) {
    log_warning("no way leads from the last view to one of the whole field; the arm stays where it is");
    return;
  }
  const MotionResult moved = cell.arm.follow(*route);
  if (moved.status != MotionResult::Status::kDone)
    throw DeviceError("arm", "stopped on its way from the field: " + moved.reason,
                      "clear the cell and start again");
}

/// True if views show that nothing stands at the site.
bool site_is_free(const AlignedScene& scene, const CellLayout& layout) {
  Views views;
  for (const DepthView& view : scene.views) views.push_back({view.image, view.T_W_C});
  return site_in(views, layout.site) == SiteStatus::kFree;
}

/// Is more of it to be found out?
bool is_worth_turning(const StoneCandidate& candidate) {
  const bool wanting = candidate.made.seen_share < kSeenEnough || !candidate.made.mass;
  return wanting && !candidate.made.known && !candidate.moved && unlike_stone(candidate).empty();
}

/// Turns stones over of which much is unseen, looks again, and completes the models, until nothing is left to
/// turn; then the arm leaves the field.
void see_other_sides(Cell& here, const RobotModel& robot, std::deque<AlignedScene>& scenes,
                     const Eigen::Vector3d& p_W_field, const ModelFieldOptions& options, Journal* journal,
                     std::vector<StoneCandidate>& candidates, ModelledField& field) {
  const std::vector<Obstacle> others = obstacles_of(scenes.front(), candidates);
  const bool site_free = site_is_free(scenes.front(), here.layout);
  const auto scene_now = [&] {
    PlanningScene scene = scene_with(here.layout, robot, candidates, others);
    if (!site_free) scene.objects.push_back(unseen_site(here.layout));
    return scene;
  };
  for (int turn = 0; turn < options.turns && options.turned_views > 0; ++turn) {
    bool turned = false;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      candidates[k].let_go = false;
      if (!is_worth_turning(candidates[k])) continue;
      turn_stone(here, scene_now(), candidates, k, others, options, journal);
      turned |= candidates[k].moved;
    }
    if (!turned) break;
    PlanningScene scene = scene_now();
    scene.opening = present_opening(here, scene.gripper);
    (void)back_away(here, scene, options.motion, [&] { record(journal, StepBegun{"back away"}); });
    const auto taken = survey(here, scene, unseen_surface(candidates), p_W_field, options.turned_views,
                              options.view_distance, options.motion, journal);
    field.views += static_cast<int>(taken.size());
    scenes.push_back(align(taken, options, here.layout));
    model_again(scenes.back(), here.layout, options, candidates);
  }
  record(journal, StepBegun{"leave the field"});
  leave_field(here, scene_now(), p_W_field, options);
}

}  // namespace

std::string modelled_name(const std::vector<std::string>& taken) {
  const std::string form = "stone_";
  unsigned last = 0;
  for (const std::string& name : taken) {
    unsigned number = 0;
    if (!name.starts_with(form)) continue;
    const char *begin = name.data() + form.size(), *end = name.data() + name.size();
    if (const auto read = std::from_chars(begin, end, number); read.ec == std::errc() && read.ptr == end)
      last = std::max(last, number);
  }
  return concat(form, last + 1);
}

ModelledField model_field(Cell& cell, const RobotModel& robot, const ModelFieldOptions& options,
                          Journal* journal) {
  ModelledField field;
  const double start = cell.clock.now();
  Cell here = cell;
  const Eigen::Vector3d p_W_field(cell.layout.field_centre.x(), cell.layout.field_centre.y(), kFieldHeight);
  PlanningScene unknown = make_planning_scene(here.layout, robot, {}, {});
  unknown.objects.push_back(unseen_field(here.layout));
  unknown.objects.push_back(unseen_site(here.layout));
  const auto first_survey = survey(here, unknown, dome_over(p_W_field), p_W_field, options.first_views,
                                   options.view_distance, options.motion, journal);
  std::deque<AlignedScene> scenes;  // that candidates are made of
  scenes.push_back(align(first_survey, options, here.layout));
  const AlignedScene& first = scenes.front();
  field.views = static_cast<int>(first_survey.size());
  field.apart_before = first.apart_before;
  field.apart_after = first.apart_after;
  auto candidates = model_first(first, here.layout, unknown.gripper, options, field.left_out);
  const auto known = std::count_if(candidates.begin(), candidates.end(),
                                   [](const StoneCandidate& candidate) { return candidate.made.known; });
  log_info(concat(candidates.size() - static_cast<std::size_t>(known), " stones modelled",
                  known > 0 ? concat(" and ", known, " recognised") : std::string(), " from ", field.views,
                  " views"));
  try {
    see_other_sides(here, robot, scenes, p_W_field, options, journal, candidates, field);
  } catch (const DeviceError& problem) {
    field.stopped = problem.what();
  } catch (const Interrupted&) {
    field.interrupted = true;
  }
  for (StoneCandidate& candidate : candidates) {
    if (const std::string why = unlike_stone(candidate); !why.empty()) {
      field.left_out.push_back(candidate.made.name + " " + why);
      continue;
    }
    if (candidate.made.known) candidate.made.T_W_O_first = candidate.T_W_O;
    for (const LyingObject& lay : candidate.made_of)
      if (lay.scene == &first) candidate.made.T_W_O_first = lay.T_W_O * candidate.stone.T_O_file.inverse();
    if (!candidate.moved)
      candidate.made.T_W_O = candidate.T_W_O;
    else if (candidate.made.note.empty())
      candidate.made.note = "not looked for any more after it was moved";
    field.stones.push_back(std::move(candidate.made));
    field.catalogue.stones.push_back(std::move(candidate.stone));
  }
  field.seconds = cell.clock.now() - start;
  return field;
}

}  // namespace stonestack::stacking
