#include "stonestack/simulation/simulated_cell.hpp"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "hardware/ready_joints.hpp"
#include "motion/collision/mounted_gripper.hpp"
#include "simulation/foreign_object.hpp"
#include "simulation/scatter.hpp"
#include "simulation/shared_world.hpp"
#include "simulation/simulated_devices.hpp"
#include "simulation/true_shape.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::simulation {
namespace {

using nlohmann::json;

constexpr const char* kKeptFile = "/simulated-cell/world.json";
constexpr const char* kKeptSchema = "stonestack.simulated_cell/1";
constexpr std::size_t kMaxKept = std::size_t{1} << 26;

/// Everything that lies in the cell: the stones as they are, then what no catalogue has.
std::vector<Stone> real_stones(const std::vector<Stone>& scanned, const SimulationOptions& options) {
  std::vector<Stone> real = as_they_are(scanned, options);
  for (const Stone& object : make_foreign_objects(options)) real.push_back(object);
  return real;
}

/// The stones that are there and the foreign objects behind the catalogue.
std::vector<StoneIndex> with_foreign(std::vector<StoneIndex> present, std::size_t catalogue,
                                     const SimulationOptions& options) {
  for (int k = 0; k < options.foreign_objects; ++k) present.emplace_back(static_cast<int>(catalogue) + k);
  return present;
}

/// The gripper as it is mounted, on a force sensor of the layout's mass.
GripperModel true_gripper(const CellLayout& layout) {
  GripperModel gripper = mounted_at(with_camera_at(read_gripper(layout.gripper), layout.T_T_C), layout.T_F_T);
  gripper.sensor_mass = layout.sensor_mass;
  return gripper;
}

/// Replaces the file in one step. Not synced: a simulated cell need not outlive a power cut.
void replace_kept(const std::string& path, const json& kept) {
  const std::string part = path + ".part";
  std::ofstream file(part, std::ios::trunc);
  file << kept.dump() << '\n';
  file.close();
  std::error_code failed;
  if (file) std::filesystem::rename(part, path, failed);
  if (!file || failed)
    throw FileError(path, "cannot be written", "check the folder, its rights and the disk");
}

template <class Restore>
void restore_cell(const std::string& path, const Restore& restore) {
  const std::string remedy = "start the run anew: where the stones of its simulated cell lay is not known";
  std::string problem;
  try {
    return restore(json::parse(read_file(path, kMaxKept)));
  } catch (const json::exception& wrong) {
    problem = wrong.what();
  } catch (const InvalidArgument& wrong) {
    problem = wrong.what();
  }
  throw FileError(path, "is no simulated cell that can go on: " + problem, remedy);
}

}  // namespace

struct SimulatedCell::Parts {
  std::vector<Stone> stones;
  CellLayout assumed;
  TrueMounting mounting;
  TrueWorld world;
  SimulatedClock clock;
  CellKeeper keeper;
  SimulatedForceTorque force_torque;
  SimulatedArm arm;
  SimulatedGripper gripper;
  SimulatedCamera camera;
  SharedWorld shared;

  Parts(const std::vector<Stone>& all, const std::vector<StoneIndex>& present, const RobotModel& robot,
        const CellLayout& layout, const SimulationOptions& options)
      : stones(real_stones(all, options)),
        assumed(layout),
        mounting(draw_mounting(layout, options, robot, ready_joints(robot, layout))),
        world(stones, with_foreign(present, all.size(), options), true_gripper(layout), options,
              {TrueTable(options, 0.5 * (layout.site + layout.field_centre)), options.foreign_objects}),
        clock(world),
        force_torque(world, mounting, options),
        arm(world, robot, mounting, force_torque, keeper, options, ready_joints(robot, layout), layout),
        gripper(world, keeper),
        camera(world, stones, mounting, options),
        shared(world, mounting, robot, stones, options) {
    arm.set_gripper([this] { return gripper.state(); });
  }

  /// Names of what lies in the cell.
  [[nodiscard]] json names() const {
    json list = json::array();
    for (const StoneIndex i : world.present()) list.push_back(at(stones, i).name);
    return list;
  }
  [[nodiscard]] json kept() const {
    return {{"schema", kKeptSchema},  {"stones", names()},         {"world", world.kept()},
            {"arm", arm.kept()},      {"gripper", gripper.kept()}, {"force_torque", force_torque.kept()},
            {"camera", camera.kept()}};
  }
  void restore(const json& kept) {
    require(kept.at("schema") == kKeptSchema, "its schema is not ", kKeptSchema);
    require(kept.at("stones") == names(), "other stones lie in it than in this cell: ", kept.at("stones"));
    world.restore(kept.at("world"));
    force_torque.restore(kept.at("force_torque"));
    arm.restore(kept.at("arm"));
    gripper.restore(kept.at("gripper"));
    camera.restore(kept.at("camera"));
  }
};

SimulatedCell::SimulatedCell(const std::vector<Stone>& stones, const std::vector<StoneIndex>& present,
                             const RobotModel& robot, const CellLayout& assumed,
                             const SimulationOptions& options, const std::string& kept) {
  parts_ = std::make_unique<Parts>(stones, present, robot, assumed, options);
  if (!kept.empty()) {
    restore_cell(kept + kKeptFile, [&](const json& state) { parts_->restore(state); });
    return;
  }
  auto& world = parts_->world;
  GripperPose gripper_pose;
  gripper_pose.T_W_T = parts_->arm.true_T_W_T(parts_->arm.state().q);
  gripper_pose.finger.fill(0.5 * world.gripper_body().gripper.max_opening);
  world.set_gripper_pose(gripper_pose);
  scatter_stones(world, {assumed.field_centre, assumed.field_size, options.clearance},
                 static_cast<std::uint64_t>(options.seed));
}

SimulatedCell::~SimulatedCell() = default;

Cell SimulatedCell::cell() {
  return {parts_->arm, parts_->gripper, parts_->force_torque, parts_->camera, parts_->clock, parts_->assumed};
}

Truth SimulatedCell::truth() const {
  const auto& world = parts_->world;
  Truth truth{world.time(), std::vector<Pose>(parts_->stones.size(), Pose::Identity()), world.contacts()};
  for (const StoneIndex i : world.present()) at(truth.T_W_O, i) = world.pose(i);
  return truth;
}

void SimulatedCell::wait(double seconds) {
  constexpr double kTurn = 1.0;
  for (double left = seconds; left > 0; left -= kTurn) {
    throw_if_interrupted();
    const Progress progress = parts_->world.wait(std::min(kTurn, left));
    if (!progress.stopped.empty())
      throw DeviceError("simulated cell", progress.stopped, "move the arm away from what it touches");
  }
}

SharedWorld& SimulatedCell::shared() {
  return parts_->shared;
}

void SimulatedCell::place(StoneIndex stone, const Pose& T_W_O) {
  parts_->world.place(stone, T_W_O);
}

void SimulatedCell::keep_in(const std::string& folder) {
  const std::string path = folder + kKeptFile;
  std::error_code ignored;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);
  parts_->keeper.keep = [parts = parts_.get(), path] { replace_kept(path, parts->kept()); };
  parts_->keeper.changed(parts_->world.time());
}

void SimulatedCell::unlock() {
  parts_->arm.unlock();
}

const TrueWorld& SimulatedCell::world() const {
  return parts_->world;
}

const Eigen::Vector2d& SimulatedCell::site() const {
  return parts_->assumed.site;
}

}  // namespace stonestack::simulation
