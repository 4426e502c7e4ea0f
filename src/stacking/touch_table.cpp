#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/constants.hpp"
#include "geometry/pose_json.hpp"
#include "kinematics/inverse.hpp"
#include "kinematics/mount_reading.hpp"
#include "motion/cartesian.hpp"
#include "motion/collision.hpp"
#include "motion/grasp/finger_reach.hpp"
#include "motion/timing.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/back_away.hpp"
#include "stacking/constants.hpp"
#include "stacking/measuring_motion.hpp"
#include "stacking/mount_correction.hpp"
#include "stacking/plan_executor.hpp"
#include "stacking/unknown_objects.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/stacking/check_cell.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kHover = 0.10;         // m above where table and camera have it at the highest
constexpr double kFurtherDown = 0.025;  // m below where they have it at the lowest: kRoughTable.height
constexpr double kTouchSpeed = 0.005;   // m/s: what the guard feels comes late on a busy host
constexpr double kTouchTime = 300.0;    // s, for all of it
constexpr double kLightest = 0.1;       // kg: a stone so light is felt by the smallest threshold
constexpr double kTouchOpenSpeed = 0.03, kTouchOpenForce = 30.0;  // m/s, N: of empty fingers
constexpr double kNearlyOpen = 0.003;                             // m
constexpr double kBesideFingers = 0.02;    // m of bare table, seen, around where fingers come down
constexpr double kMinBare = 0.9;           // share of that table that must be seen
constexpr double kMinAltitude = 0.10;      // m, of the triangle of points: less is nearly a line
constexpr std::size_t kMaxPlaces = 60;     // among which the three are chosen
constexpr std::size_t kBranchesTried = 4;  // ways to stand over a place
// What a hand-eye error of 0.5 deg does half a metre away: half of kGoodTable.
constexpr TableOffset kAgreement{0.5 * kGoodTable.height, 0.5 * kGoodTable.tilt};
constexpr double kTouchYaws[] = {0.0, 90.0, 45.0, -45.0};  // degrees about the vertical

/// Fingers down, tip at `p_W`.
Pose touching_tool(const Eigen::Vector3d& p_W, double yaw) {
  return Eigen::Translation3d(p_W) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
}

double height_at(const Plane& plane_W, const Eigen::Vector2d& p_W) {
  return (plane_W.offset - plane_W.normal.head<2>().dot(p_W)) / plane_W.normal.z();
}

TableLevel level_of(const Plane& plane_W, const Eigen::Vector2d& middle) {
  return {height_at(plane_W, middle), std::acos(std::clamp(plane_W.normal.z(), -1.0, 1.0))};
}

/// Shortest altitude of a triangle [m].
double altitude(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d ab = b - a, ac = c - a;
  const double longest = std::max({ab.norm(), ac.norm(), (c - b).norm()});
  return longest > 0 ? std::abs(ab.x() * ac.y() - ab.y() * ac.x()) / longest : 0.0;
}

/// Corners of the finger tips in T, fingers open.
std::vector<Eigen::Vector3d> finger_corners(const GripperModel& gripper) {
  std::vector<Eigen::Vector3d> corners;
  for (const GripperBox& box : gripper.boxes) {
    if (box.finger_side == 0.0) continue;
    const Eigen::Vector3d middle = box_centre(gripper, box, gripper.max_opening), half = 0.5 * box.size;
    for (const double x : {-half.x(), half.x()})
      for (const double y : {-half.y(), half.y()})
        corners.push_back(middle + Eigen::Vector3d(x, y, half.z()));
  }
  if (corners.empty()) corners.emplace_back(Eigen::Vector3d::Zero());
  return corners;
}

/// One touch: route to above the place, then straight down.
struct Touch {
  JointTrajectory route;
  PlanStep descent;
};

/// Where the table is said to be and seen.
struct ExpectedTable {
  Plane seen_W;
  double highest = 0.0, lowest = 0.0;  // z in W, of either, near the places
};

/// Plans three touches on the table of one view.
class TouchPlanner {
 public:
  TouchPlanner(const CellLayout& layout, PlanningScene scene, const MotionOptions& motion,
               const ExpectedTable& table)
      : layout_(layout), scene_(std::move(scene)), motion_(motion), table_(table), over_(scene_, rules()) {
    rules_down_ = rules();
    rules_down_.gripper_may_touch.push_back(kTableObject);
    PlanningScene below = scene_;
    below.table_z = table.lowest - 1.0;  // the descent is to meet it
    down_.emplace(below, rules_down_);
  }

  /// Routes and descents from where the arm stands; places that do not serve are erased.
  [[nodiscard]] std::vector<Touch> plan(std::vector<Eigen::Vector2d> places, const Joints& q_start) const {
    for (;;) {
      throw_if_interrupted();
      const auto chosen = widest(places);
      if (chosen.empty()) return {};
      std::vector<Touch> touches;
      Joints q = q_start;
      for (const std::size_t place : chosen) {
        auto touch = plan_touch(places[place], q);
        if (!touch) {
          places.erase(places.begin() + static_cast<std::ptrdiff_t>(place));
          break;
        }
        q = touch->route.q.back();
        touches.push_back(std::move(*touch));
      }
      if (touches.size() == chosen.size()) return touches;
    }
  }

  /// Route back to where the arm stood; empty where there is none.
  [[nodiscard]] std::optional<JointTrajectory> plan_return(const Joints& q, const Joints& q_home) const {
    return plan_transit(scene_, q, q_home, motion_);
  }

 private:
  [[nodiscard]] CollisionRules rules() const {
    CollisionRules rules;
    rules.padding = motion_.transit_padding;
    rules.opening = scene_.opening;
    return rules;
  }

  /// Indices of the three with the largest shortest altitude; none where they all lie on a line.
  [[nodiscard]] static std::vector<std::size_t> widest(const std::vector<Eigen::Vector2d>& p) {
    std::vector<std::size_t> best;
    double most = kMinAltitude;
    for (std::size_t a = 0; a < p.size(); ++a)
      for (std::size_t b = a + 1; b < p.size(); ++b)
        for (std::size_t c = b + 1; c < p.size(); ++c)
          if (const double width = altitude(p[a], p[b], p[c]); width > most) {
            most = width;
            best = {a, b, c};
          }
    return best;
  }

  [[nodiscard]] std::optional<Touch> plan_touch(const Eigen::Vector2d& place, const Joints& q_start) const {
    for (const double yaw : kTouchYaws) {
      const auto solutions =
          inverse(scene_.robot, T_R_F_at({place.x(), place.y(), table_.highest + kHover}, yaw), q_start);
      std::size_t tried = 0;
      for (const IkSolution& above : solutions) {
        if (++tried > kBranchesTried) break;
        if (over_.collides(above.q)) continue;
        auto descent = plan_descent(above.q, place, yaw);
        if (!descent) continue;
        auto route = plan_transit(scene_, q_start, above.q, motion_);
        if (route) return Touch{std::move(*route), std::move(*descent)};
      }
    }
    return std::nullopt;
  }

  /// The cell's limits may end it earlier.
  [[nodiscard]] double lowest_tip() const {
    const double wanted = table_.lowest - kFurtherDown;
    return scene_.robot.workspace
               ? std::max(wanted, scene_.robot.workspace->box.min().z() + 2.0 * kWorkspaceMargin)
               : wanted;
  }

  [[nodiscard]] std::optional<PlanStep> plan_descent(const Joints& q, const Eigen::Vector2d& place,
                                                     double yaw) const {
    const Pose T_R_T =
        layout_.T_W_R.inverse() * touching_tool({place.x(), place.y(), lowest_tip()}, yaw * kDegree);
    const auto path = straight_path(scene_.robot, scene_.T_F_T, q, T_R_T);
    if (!path || !motion::is_free(*down_, *path)) return std::nullopt;
    TimingLimits limits = timing_limits(scene_.robot, motion_);
    limits.tool_speed = kTouchSpeed;
    PlanStep step;
    step.kind = PlanStep::Kind::kDescent;
    step.name = "touch the table";
    step.trajectory = time_path(*path, limits, scene_.robot, scene_.T_F_T);
    step.threshold = contact_threshold(kLightest, motion_);
    return step;
  }

  [[nodiscard]] Pose T_R_F_at(const Eigen::Vector3d& p_W, double yaw) const {
    return layout_.T_W_R.inverse() * touching_tool(p_W, yaw * kDegree) * layout_.T_F_T.inverse();
  }

  const CellLayout& layout_;
  const PlanningScene scene_;
  const MotionOptions& motion_;
  const ExpectedTable& table_;
  CollisionRules rules_down_;
  CollisionChecker over_;
  std::optional<CollisionChecker> down_;
};

/// Places in whose surroundings nothing but table is seen: where fingers have room to come down.
std::vector<Eigen::Vector2d> bare_places(const TableView& view, double radius) {
  const auto index = [&](const Eigen::Vector2d& p) {
    return std::pair<long, long>(std::lround(std::floor(p.x() / view.cell)),
                                 std::lround(std::floor(p.y() / view.cell)));
  };
  std::set<std::pair<long, long>> bare;
  for (const Eigen::Vector2d& p : view.p_W) bare.insert(index(p));
  const long reach = std::lround(std::ceil(radius / view.cell));
  const auto is_free = [&](const Eigen::Vector2d& p) {
    const auto [column, row] = index(p);
    int all = 0, seen = 0;
    for (long i = -reach; i <= reach; ++i)
      for (long j = -reach; j <= reach; ++j) {
        if (std::hypot(static_cast<double>(i), static_cast<double>(j)) * view.cell > radius) continue;
        ++all;
        seen += bare.contains({column + i, row + j}) ? 1 : 0;
      }
    return seen >= kMinBare * all &&
           std::none_of(view.above_W.begin(), view.above_W.end(),
                        [&](const auto& q) { return (q.template head<2>() - p).norm() < radius; });
  };
  std::vector<Eigen::Vector2d> places;
  for (const Eigen::Vector2d& p : view.p_W)
    if (is_free(p)) places.push_back(p);
  // Those at the rim are furthest apart: a part of all, spread evenly.
  const std::size_t stride = (places.size() + kMaxPlaces - 1) / kMaxPlaces;
  std::vector<Eigen::Vector2d> some;
  for (std::size_t k = 0; stride > 0 && k < places.size(); k += stride) some.push_back(places[k]);
  return some;
}

/// Devices and what is known of the cell, until the table is found.
class TableToucher {
 public:
  TableToucher(Cell& cell, const RobotModel& robot) : cell_(cell), robot_(robot) {}

  [[nodiscard]] TouchedTable run() {
    open_gripper();
    const CameraView view = view_unknown_field(cell_, robot_, unknown_scene(cell_, robot_), motion_);
    const auto table_C = find_table(view.image);
    if (!table_C)
      throw DeviceError("camera", "sees no table in the field",
                        "clear the field, and see `stonestack doctor` about the camera");
    const ExpectedTable expected = expected_table(transformed(*table_C, view.T_W_C));
    const std::vector<Touch> touches = plan(view, *table_C, expected);
    log_info(
        concat("the table is seen; the fingers go down at three points, at ", 1e3 * kTouchSpeed, " mm/s"));
    std::vector<Pose> T_W_T;
    TouchedTable found;
    for (std::size_t k = 0; k < touches.size(); ++k) {
      const MotionResult moved = cell_.arm.follow(touches[k].route);
      if (moved.status != MotionResult::Status::kDone) report_stop(cell_, moved.reason);
      found.force[k] = feel(touches[k].descent, k, T_W_T);
    }
    judge(T_W_T, expected.seen_W, found);
    if (!home_) return found;
    const MotionResult back = cell_.arm.follow(*home_);
    if (back.status != MotionResult::Status::kDone) report_stop(cell_, back.reason);
    return found;
  }

 private:
  [[nodiscard]] PlanningScene scene(const CellLayout& layout) const {
    PlanningScene scene = make_planning_scene(layout, robot_, {}, {});
    scene.opening = present_opening(cell_, scene.gripper);
    return scene;
  }

  void check_time() const {
    throw_if_interrupted();
    if (cell_.clock.now() - start_ > kTouchTime)
      throw DeviceError("arm", concat("has not touched the table at three points within ", kTouchTime, " s"),
                        "raise the speed slider, and start again");
  }

  void open_gripper() {
    const GripperModel gripper = gripper_of(cell_.layout);
    set_payload(cell_.arm, carried_gripper_mass(gripper, cell_.layout));
    if (cell_.gripper.state().opening < gripper.max_opening - kNearlyOpen)
      cell_.gripper.move(gripper.max_opening, kTouchOpenSpeed, kTouchOpenForce);
  }

  [[nodiscard]] static Plane transformed(const Plane& plane_C, const Pose& T_W_C) {
    const Eigen::Vector3d n_W = T_W_C.linear() * plane_C.normal;
    return {n_W, plane_C.offset + n_W.dot(T_W_C.translation())};
  }

  /// Over the field and a little beyond it.
  [[nodiscard]] ExpectedTable expected_table(const Plane& seen_W) const {
    constexpr double kBesideField = 0.1;  // m
    ExpectedTable table{seen_W};
    const Eigen::Vector2d half = 0.5 * cell_.layout.field_size + Eigen::Vector2d::Constant(kBesideField);
    for (const double x : {-half.x(), half.x()})
      for (const double y : {-half.y(), half.y()}) {
        const double z = height_at(seen_W, cell_.layout.field_centre + Eigen::Vector2d(x, y));
        table.highest = std::max(table.highest, z);
        table.lowest = std::min(table.lowest, z);
      }
    if (table.highest - table.lowest > 2.0 * kHover)
      throw DeviceError(
          "camera",
          concat("has the table up to ", std::lround(1e3 * std::max(table.highest, -table.lowest)),
                 " mm beside z = 0 of the cell"),
          "calibrate the camera, and correct layout.T_W_R, before anything touches the table");
    return table;
  }

  [[nodiscard]] std::vector<Touch> plan(const CameraView& view, const Plane& table_C,
                                        const ExpectedTable& expected) {
    CellLayout layout = cell_.layout;
    for (Obstacle& object : objects_above_table({view}, {}, "object on the table"))
      layout.obstacles.push_back(std::move(object));
    PlanningScene over = scene(layout);
    over.table_z = expected.highest;
    double radius = 0.0;
    for (const Eigen::Vector3d& p_T : finger_corners(over.gripper))
      radius = std::max(radius, p_T.head<2>().norm());
    const auto places = bare_places(view_of_table(view.image, table_C, view.T_W_C), radius + kBesideFingers);
    const TouchPlanner planner(cell_.layout, std::move(over), motion_, expected);
    auto touches = planner.plan(places, cell_.arm.state().q);
    if (touches.empty())
      throw DeviceError(
          "table",
          concat("has no three points, ", kMinAltitude,
                 " m off a line, where the camera sees bare table and the open fingers can come down; ",
                 places.size(), " places were tried"),
          "clear the field of stones, and see `stonestack view CELL` about reach and limits");
    home_ = planner.plan_return(touches.back().route.q.back(), q_start_);
    return touches;
  }

  /// Goes down until contact, notes where the tool is, and returns to above the place.
  double feel(const PlanStep& descent, std::size_t number, std::vector<Pose>& T_W_T) const {
    check_time();
    const PickAndPlacePlan no_plan;
    const Stone no_stone;
    const PlanningScene now = scene(cell_.layout);
    const PlanExecutor executor{no_plan, no_stone, now, cell_, motion_, nullptr};
    bool touched = false;
    const ExecutionResult went = executor.feel_down(descent, &touched);
    if (went.status == ExecutionResult::Status::kStopped) report_stop(cell_, went.reason);
    T_W_T.push_back(cell_.layout.T_W_R * forward(robot_, cell_.arm.state().q) * cell_.layout.T_F_T);
    const ExecutionResult back = executor.back_to_start(descent);
    if (back.status == ExecutionResult::Status::kStopped) report_stop(cell_, back.reason);
    const Eigen::Vector3d p_W = T_W_T.back().translation();
    if (!touched)
      throw DeviceError(
          "table",
          concat("the fingers met nothing down to ", std::lround(1e3 * p_W.z()), " mm at (", p_W.x(), ", ",
                 p_W.y(), ") m, point ", number + 1, " of 3"),
          "see that a table is there; if the camera sees it higher than it is, calibrate the camera "
          "and measure layout.T_F_T; limits.workspace may end the descent");
    log_info(
        concat("point ", number + 1, " of 3: contact at ", 1e3 * p_W.z(), " mm, ", went.contact_force, " N"));
    return went.contact_force;
  }

  /// The lowest corner of the fingers has touched: which it was depends on the plane itself.
  void judge(const std::vector<Pose>& T_W_T, const Plane& seen_W, TouchedTable& found) const {
    const auto corners = finger_corners(gripper_of(cell_.layout));
    Plane plane_W;
    for (int turn = 0; turn < 4; ++turn) {
      for (std::size_t k = 0; k < 3; ++k) {
        double least = 1e9;
        for (const Eigen::Vector3d& p_T : corners)
          if (const Eigen::Vector3d p_W = T_W_T[k] * p_T; plane_W.normal.dot(p_W) < least) {
            least = plane_W.normal.dot(p_W);
            found.p_W[k] = p_W;
          }
      }
      plane_W.normal = (found.p_W[1] - found.p_W[0]).cross(found.p_W[2] - found.p_W[0]).normalized();
      if (plane_W.normal.z() < 0) plane_W.normal = -plane_W.normal;
      plane_W.offset = plane_W.normal.dot(found.p_W[0]);
    }
    const Eigen::Vector2d& middle = cell_.layout.field_centre;
    found.touched = level_of(plane_W, middle);
    found.seen = level_of(seen_W, middle);
    found.apart = {found.seen.height - found.touched.height,
                   std::acos(std::clamp(seen_W.normal.dot(plane_W.normal), -1.0, 1.0))};
    found.T_W_R = levelled(plane_W, middle) * cell_.layout.T_W_R;
    if (std::abs(found.apart.height) > kAgreement.height)
      found.problems.push_back(concat("the camera sees the table ",
                                      std::lround(std::abs(1e3 * found.apart.height)), " mm ",
                                      found.apart.height > 0 ? "above" : "below",
                                      " where the fingers touch it: measure from the flange to the finger "
                                      "tips (layout.T_F_T), then calibrate the "
                                      "camera with `stonestack calibrate --capture CELL`"));
    if (found.apart.tilt > kAgreement.tilt)
      found.problems.push_back(concat(
          "the camera sees the table tilted by ", std::lround(found.apart.tilt / kDegree * 10) / 10.0,
          " deg against the touched plane: see that it sits firmly, then calibrate it with `stonestack "
          "calibrate --capture CELL`"));
  }

  Cell& cell_;
  const RobotModel& robot_;
  MotionOptions motion_ = measuring_motion();
  double start_ = cell_.clock.now();
  Joints q_start_ = cell_.arm.state().q;
  std::optional<JointTrajectory> home_;  // from above the last point
};

std::string in_words(const TableLevel& level) {
  return concat(std::round(1e4 * level.height) / 10, " mm, tilt ",
                std::round(level.tilt / kDegree * 100) / 100, " deg");
}

nlohmann::json json_of(const TableLevel& level) {
  return {{"height_mm", 1e3 * level.height}, {"tilt_deg", level.tilt / kDegree}};
}

}  // namespace

TouchedTable touch_table(Cell& cell, const RobotModel& robot) {
  TableToucher toucher(cell, robot);
  return stopping_on_failure(cell, [&] { return toucher.run(); });
}

std::string to_text(const TouchedTable& table) {
  std::string text = "touched at";
  for (const Eigen::Vector3d& p_W : table.p_W)
    text += concat(&p_W == &table.p_W.front() ? " (" : ", (", std::round(1e3 * p_W.x()) / 1e3, ", ",
                   std::round(1e3 * p_W.y()) / 1e3, ", ", std::round(1e4 * p_W.z()) / 1e4, ")");
  text += concat(" m\ntouched table:  height ", in_words(table.touched), "\nseen table:     height ",
                 in_words(table.seen), "\nseen - touched: height ", in_words(table.apart), "\n");
  if (table.problems.empty()) text += "they agree\n";
  for (const std::string& problem : table.problems) text += "FAIL  " + problem + "\n";
  return text;
}

std::string touched_table_json(const TouchedTable& table) {
  nlohmann::json points = nlohmann::json::array();
  for (std::size_t k = 0; k < table.p_W.size(); ++k)
    points.push_back(
        {{"p_W", {table.p_W[k].x(), table.p_W[k].y(), table.p_W[k].z()}}, {"force_N", table.force[k]}});
  return nlohmann::json{{"schema", "stonestack.table/1"},    {"points", points},
                        {"touched", json_of(table.touched)}, {"seen", json_of(table.seen)},
                        {"apart", json_of(table.apart)},     {"agree", table.problems.empty()},
                        {"problems", table.problems},        {"T_W_R", pose_json(table.T_W_R)}}
             .dump(2) +
         "\n";
}

}  // namespace stonestack::stacking
