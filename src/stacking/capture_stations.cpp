#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "stacking/gripper_mass.hpp"
#include "stacking/measuring_motion.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/stacking/check_cell.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kCaptureTime = 900.0;  // s, for all of it
constexpr int kFewestStations = 4;      // that fix a mount with something left over
constexpr int kTriesEach = 4;           // directions tried for each station
constexpr double kSameTarget = 0.10;    // m beside where the first view had it: another thing was found
constexpr double kSameTurn = 0.6;       // rad, likewise
constexpr double kGoldenAngle = 2.39996322972865332;  // rad: successive directions fill the circle evenly
constexpr double kDistances[] = {0.50, 0.60, 0.45};   // m from the camera to the target
constexpr double kTilts[] = {20.0, 40.0, 30.0, 5.0};  // degrees off the vertical
constexpr double kTurnBetween = 100.0;  // degrees about the optical axis, from station to station
constexpr double kShortestSide = 0.020, kLongestSide = 0.50, kSidesDiffer = 0.010;  // m, of a block
constexpr double kBlockDensity = 700.0;                                             // kg/m^3: wood

/// Camera poses of one station, the wanted turn about the optical axis first.
std::vector<Pose> station_poses(int number, const Eigen::Vector3d& p_W_target) {
  const auto k = static_cast<std::size_t>(number);
  const double tilt = kTilts[k % std::size(kTilts)] * kDegree,
               distance = kDistances[k % std::size(kDistances)];
  const double azimuth = kGoldenAngle * number;
  const Eigen::Vector3d direction(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                                  std::cos(tilt));
  std::vector<Pose> poses;
  for (const double more : {0.0, 90.0, 180.0, 270.0})
    poses.push_back(camera_looking_at(p_W_target + distance * direction, p_W_target,
                                      (kTurnBetween * number + more) * kDegree));
  return poses;
}

class StationCapture {
 public:
  StationCapture(Cell& cell, const RobotModel& robot, const Catalogue& targets, const CaptureOptions& options)
      : cell_(cell), robot_(robot), targets_(targets), options_(options), models_(targets.stones) {
    require(options.stations >= kFewestStations, "a calibration takes at least ", kFewestStations,
            " stations, asked for ", options.stations);
  }

  [[nodiscard]] HandEyeFile run() {
    if (!options_.target.empty()) target_ = targets_.index(options_.target);
    const GripperModel gripper = gripper_of(cell_.layout);
    set_payload(cell_.arm, carried_gripper_mass(gripper, cell_.layout));
    const PlanningScene scene = unknown_scene(cell_, robot_);
    find_target(scene);
    HandEyeFile file{CameraMount::kOnHand, {}};
    const int tries = kTriesEach * options_.stations;
    for (int k = 0; k < tries && std::ssize(file.pairs) < options_.stations; ++k) {
      check_time();
      const auto route = plan_route_to_view(cell_, scene, station_poses(k, T_W_B_.translation()), motion_);
      if (!route) continue;
      ++views_;
      const CameraView view = view_after(cell_, robot_, *route);
      const auto T_C_B = target_in(view);
      if (!T_C_B) continue;
      file.pairs.push_back({flange_of(view), *T_C_B});
      log_info(concat("station ", file.pairs.size(), " of ", options_.stations));
    }
    if (std::ssize(file.pairs) < std::max(kFewestStations, options_.stations / 2))
      throw DeviceError(
          "camera",
          concat("showed ", targets_[target_].name, " in ", file.pairs.size(), " of ", views_, " views, and ",
                 options_.stations, " are wanted"),
          "lay the target into the middle of the field, where the arm can view it from all sides, "
          "and see `stonestack view CELL` about reach and limits");
    if (std::ssize(file.pairs) < options_.stations)
      log_warning(concat("only ", file.pairs.size(), " of ", options_.stations, " stations in ", tries,
                         " directions: the others cannot be reached, or do not show the target"));
    return file;
  }

 private:
  void check_time() const {
    throw_if_interrupted();
    if (cell_.clock.now() - start_ > kCaptureTime)
      throw DeviceError("arm", concat("has not taken the stations within ", kCaptureTime, " s"),
                        "raise the speed slider, or ask for fewer stations, and start again");
  }

  /// T_R_F of a view, which has the camera's pose by the present mount.
  [[nodiscard]] Pose flange_of(const CameraView& view) const {
    return cell_.layout.T_W_R.inverse() * view.T_W_C * (cell_.layout.T_F_T * cell_.layout.T_T_C).inverse();
  }

  void find_target(const PlanningScene& scene) {
    const Eigen::Vector2d& field = cell_.layout.field_centre;
    const CameraView view = view_unknown_field(cell_, robot_, scene, motion_);
    std::vector<StoneIndex> wanted;
    if (target_ != kNoStone) wanted.push_back(target_);
    const DetectionResult seen = detect_stones(view.image, models_, wanted);
    double nearest = 1e9;
    for (const Detection& found : seen.detections) {
      const Pose T_W_B = view.T_W_C * found.T_C_O;
      const double off = (T_W_B.translation().head<2>() - field).norm();
      if (off >= nearest) continue;
      nearest = off;
      target_ = found.stone;
      T_W_B_ = T_W_B;
    }
    if (nearest < 1e9) {
      log_info(concat(targets_[target_].name, " is the target"));
      return;
    }
    const std::string name = options_.target.empty() ? "none of the targets" : "no " + options_.target;
    throw DeviceError(
        "camera", concat("sees ", name, " in the field", seen.note.empty() ? "" : ": ", seen.note),
        "lay the target into the middle of the field, and see `stonestack record` and `stonestack "
        "detect` about what the camera sees");
  }

  /// Of poses that fit alike, as those of a block, the one that goes with the first view.
  [[nodiscard]] std::optional<Pose> target_in(const CameraView& view) const {
    const StoneIndex wanted[] = {target_};
    const DetectionResult seen = detect_stones(view.image, models_, wanted);
    if (seen.detections.empty()) return std::nullopt;
    const Detection& found = seen.detections.front();
    Pose T_C_B = found.T_C_O;
    const auto turn = [&](const Pose& T) { return difference(view.T_W_C * T, T_W_B_).angle; };
    for (const AlternativePose& other : found.alternatives)
      if (other.stone == target_ && turn(other.T_C_O) < turn(T_C_B)) T_C_B = other.T_C_O;
    const PoseDifference off = difference(view.T_W_C * T_C_B, T_W_B_);
    if (off.translation > kSameTarget || off.angle > kSameTurn) return std::nullopt;
    return T_C_B;
  }

  Cell& cell_;
  const RobotModel& robot_;
  const Catalogue& targets_;
  CaptureOptions options_;
  DetectionModels models_;
  MotionOptions motion_ = measuring_motion();
  double start_ = cell_.clock.now();
  StoneIndex target_ = kNoStone;
  Pose T_W_B_ = Pose::Identity();  // by the present mount, in the first view
  int views_ = 0;
};

}  // namespace

HandEyeFile capture_stations(Cell& cell, const RobotModel& robot, const Catalogue& targets,
                             const CaptureOptions& options) {
  StationCapture capture(cell, robot, targets, options);
  return stopping_on_failure(cell, [&] { return capture.run(); });
}

Catalogue block_target(const Eigen::Vector3d& sides) {
  require(sides.allFinite() && sides.minCoeff() >= kShortestSide && sides.maxCoeff() <= kLongestSide,
          "sides of a block are ", kShortestSide, " to ", kLongestSide, " m long, got ", sides.transpose(),
          " m");
  Eigen::Vector3d sorted = sides;
  std::sort(sorted.begin(), sorted.end());
  require(sorted[1] - sorted[0] >= kSidesDiffer && sorted[2] - sorted[1] >= kSidesDiffer,
          "the sides of a block differ by ", kSidesDiffer, " m at least, so that its pose can be told; got ",
          sides.transpose(), " m");
  Stone block;
  block.name = "block";
  block.mesh = block.scan = make_box(sides);
  block.pieces = {block.mesh};
  block.density = kBlockDensity;
  block.mass = mass_properties(block.scan, block.density);
  block.source = "a block";
  return {"", {block}};
}

}  // namespace stonestack::stacking
