#include "stacking/turn_stone.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/constants.hpp"
#include "geometry/convex_pieces.hpp"
#include "motion/turn_over.hpp"
#include "stacking/back_away.hpp"
#include "stacking/execute.hpp"
#include "stacking/record.hpp"
#include "stacking/survey.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kMinGain = 0.3;     // of the unseen area, that a stone is turned for
constexpr double kMinShared = 0.35;  // of what a camera sees: below it two sides are seldom joined
constexpr double kPixel = 0.0005;    // m: half of what a point of a cloud covers, or one alone has no hull
constexpr double kSameWay = 0.3;     // rad between attitudes in which a stone is let go of
constexpr double kVisible = -0.25;   // z of a normal: flatter undersides are seen by no camera
constexpr double kRollsAway = 0.30;  // m from where a stone was let go of to where it may have rolled

double unseen_area(const StoneCandidate& candidate) {
  return (1.0 - candidate.model.seen_share) * surface_area(candidate.model.mesh);
}

/// Upwards where a stone is let go of, in the frame of the model.
Eigen::Vector3d up_in_model(const StoneCandidate& candidate, const TurnTo& way) {
  return candidate.stone.T_O_file.linear().transpose() * (way.R_W_O.conjugate() * Eigen::Vector3d::UnitZ());
}

class Turner {
 public:
  Turner(Cell& cell, const PlanningScene& scene, std::vector<StoneCandidate>& candidates,
         const std::vector<Obstacle>& others, const ModelFieldOptions& options, Journal* journal)
      : cell_(cell),
        scene_(scene),
        candidates_(candidates),
        others_(others),
        options_(options),
        journal_(journal) {}

  void turn(StoneCandidate& candidate, int object) {
    PickAndPlaceTask task;
    task.stone = &candidate.stone;
    task.object = object;
    task.T_W_O_pick = task.T_W_O_place = candidate.T_W_O;
    task.q_start = cell_.arm.state().q;
    for (const Pose& T_model_T : candidate.T_model_T_failed)
      task.avoid.push_back(candidate.stone.T_O_file * T_model_T);
    const auto plan = plan_turn(scene_, task, ways_to_show(candidate), options_.motion);
    if (plan) {
      log_info(concat("turning ", candidate.stone.name, " over",
                      plan->height > 0 ? concat(", let go of ", 1e3 * plan->height, " mm above the table")
                                       : std::string()));
      candidate.let_go = true;
      carry_out(plan->plan, candidate, plan->T_W_O);
      if (candidate.let_go) candidate.up_tried.push_back(up_in_model(candidate, plan->way));
    } else {
      if (!candidate.made.turned) candidate.made.note = "no grasp sets it down on another side";
      log_info(candidate.stone.name + ": no grasp sets it down on another side");
      if (candidate.made.mass) return;
      const PickAndPlacePlan lift = plan_pick_and_place(scene_, task, options_.motion);
      if (lift.status != PickAndPlacePlan::Status::kPlanned) return;
      log_info("weighing " + candidate.stone.name);
      carry_out(lift, candidate, candidate.T_W_O);
    }
    look_where_it_lies(candidate, object);
  }

 private:
  /// Moves a stone, which then should lie there.
  void carry_out(const PickAndPlacePlan& plan, StoneCandidate& candidate, const Pose& T_W_O) {
    candidate.moved = true;  // also where the arm stops on the way
    const ExecutionResult done =
        execute(plan, candidate.stone, scene_, cell_, options_.motion, journal_, LetGo::kTippedOver);
    if (done.status == ExecutionResult::Status::kStopped)
      throw DeviceError("arm", "stopped while it turned " + candidate.stone.name + ": " + done.reason,
                        "clear the cell and start again");
    if (done.weight) candidate.made.mass = *done.weight / kGravity;
    if (done.status == ExecutionResult::Status::kReleased) {
      candidate.T_W_O = T_W_O;
      return;
    }
    candidate.let_go = false;
    candidate.T_model_T_failed.push_back(candidate.stone.T_O_file.inverse() * plan.T_O_T);
    if (!candidate.made.turned) candidate.made.note = done.reason;
  }

  /// One view from above of a stone that may lie otherwise than planned: from then on it is what is seen of
  /// it.
  void look_where_it_lies(StoneCandidate& candidate, int object) {
    PlanningScene scene = scene_;
    auto& lies = scene.objects[static_cast<std::size_t>(object)];
    lies.T_W_object = candidate.T_W_O;
    scene.opening = present_opening(cell_, scene.gripper);
    (void)back_away(cell_, scene, options_.motion, [&] { record(journal_, StepBegun{"back away"}); });
    const Eigen::Vector3d p_W = candidate.T_W_O.translation();
    const std::vector<SurfaceElement> top{{p_W, Eigen::Vector3d::UnitZ(), 1.0}};
    const SurveyView taken =
        survey(cell_, scene, top, p_W, 1, options_.view_distance, options_.motion, journal_).front();
    const Segmentation seen = detection::segment(taken.view.image, options_.modelling.segment);
    int largest = 0;
    candidate.p_W_seen.reset();
    for (const SegmentedObject& one : seen.objects) {
      const Eigen::Vector2d p_W_one = (taken.view.T_W_C * one.p_C_middle).head<2>();
      const bool is_anothers =
          std::any_of(candidates_.begin(), candidates_.end(),
                      [&](const StoneCandidate& other) {
                        return &other != &candidate && shows(one.cloud_C, taken.view.T_W_C, meshes_of(other));
                      }) ||
          std::any_of(others_.begin(), others_.end(), [&](const Obstacle& other) {
            return shows(one.cloud_C, taken.view.T_W_C, other.pieces);
          });
      if (is_anothers || (p_W_one - candidate.T_W_O.translation().head<2>()).norm() > kRollsAway) continue;
      candidate.seen_W.push_back(hull_to_table(one.cloud_C, taken.view.T_W_C));
      if (one.pixels > largest) largest = one.pixels, candidate.p_W_seen = p_W_one;
    }
  }

  /// A stone where it was seen last, in W.
  static std::vector<Mesh> meshes_of(const StoneCandidate& stone) {
    return stone.seen_W.empty() ? std::vector<Mesh>{transformed(stone.stone.mesh, stone.T_W_O)}
                                : stone.seen_W;
  }
  /// True for a cloud that mostly shows one of these.
  static bool shows(const Cloud& cloud_C, const Pose& T_W_C, const std::vector<Mesh>& meshes_W) {
    return std::any_of(meshes_W.begin(), meshes_W.end(),
                       [&](const Mesh& part) { return share_on(cloud_C, T_W_C, part) > 0.5; });
  }

  Cell& cell_;
  const PlanningScene& scene_;
  std::vector<StoneCandidate>& candidates_;
  const std::vector<Obstacle>& others_;  ///< objects that no stone was made of
  const ModelFieldOptions& options_;
  Journal* journal_;
};

}  // namespace

Shown shown_by(const modelling::ObjectModel& model, const Eigen::Matrix3d& R_W_O) {
  Shown shown;
  double seen_before = 0.0;
  for (const auto& face : model.mesh.faces) {
    bool seen = false;
    for (int k = 0; k < 3; ++k) seen |= model.seen[static_cast<std::size_t>(face[k])] != 0;
    const auto& a = model.mesh.vertices[static_cast<std::size_t>(face[0])];
    const Eigen::Vector3d n = 0.5 * (model.mesh.vertices[static_cast<std::size_t>(face[1])] - a)
                                        .cross(model.mesh.vertices[static_cast<std::size_t>(face[2])] - a);
    if ((R_W_O * n).z() > kVisible * n.norm()) (seen ? seen_before : shown.unseen) += n.norm();
  }
  const double all = seen_before + shown.unseen;
  shown.shared = all > 0.0 ? seen_before / all : 0.0;
  return shown;
}

std::vector<TurnTo> ways_to_show(const StoneCandidate& candidate) {
  struct Ranked {
    bool certain, joins;
    int gain;
    TurnTo way;
  };
  const double unseen = unseen_area(candidate);
  std::vector<Ranked> ranked;
  for (const TurnTo& way : ways_to_turn(candidate.stone, Eigen::Quaterniond(candidate.T_W_O.linear()))) {
    const Eigen::Vector3d up = up_in_model(candidate, way);
    if (std::any_of(candidate.up_tried.begin(), candidate.up_tried.end(),
                    [&](const Eigen::Vector3d& tried) { return tried.dot(up) > std::cos(kSameWay); }))
      continue;
    const Shown shown =
        shown_by(candidate.model, way.R_W_O_rest.toRotationMatrix() * candidate.stone.T_O_file.linear());
    const double gain = shown.unseen / unseen;
    if (gain > kMinGain)
      ranked.push_back(
          {way.certain, shown.shared > kMinShared, static_cast<int>(std::floor(5.0 * gain)), way});
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const Ranked& a, const Ranked& b) {
    return std::tie(a.certain, a.joins, a.gain) > std::tie(b.certain, b.joins, b.gain);
  });
  std::vector<TurnTo> ways;
  for (Ranked& one : ranked) ways.push_back(one.way);
  return ways;
}

Mesh hull_to_table(const Cloud& cloud_C, const Pose& T_W_C) {
  Mesh points;
  for (const auto& p : cloud_C.points) {
    const Eigen::Vector3d p_W = T_W_C * p.cast<double>();
    for (const double x : {-kPixel, kPixel})
      for (const double y : {-kPixel, kPixel}) {
        points.vertices.emplace_back(p_W.x() + x, p_W.y() + y, std::max(p_W.z(), kPixel));
        points.vertices.emplace_back(p_W.x() + x, p_W.y() + y, 0.0);
      }
  }
  return convex_hull(points);
}

void turn_stone(Cell& cell, const PlanningScene& scene, std::vector<StoneCandidate>& candidates,
                std::size_t stone, const std::vector<Obstacle>& others, const ModelFieldOptions& options,
                Journal* journal) {
  Turner(cell, scene, candidates, others, options, journal)
      .turn(candidates[stone], static_cast<int>(cell.layout.obstacles.size() + stone));
}

}  // namespace stonestack::stacking
