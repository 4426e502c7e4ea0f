#include "stonestack/simulation/simulated_cell.hpp"

#include "hardware/ready_joints.hpp"
#include "motion/collision/mounted_gripper.hpp"
#include "simulation/foreign_object.hpp"
#include "simulation/scatter.hpp"
#include "simulation/shared_world.hpp"
#include "simulation/simulated_devices.hpp"
#include "simulation/true_shape.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

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

}  // namespace

struct SimulatedCell::Parts {
  std::vector<Stone> stones;
  CellLayout assumed;
  TrueMounting mounting;
  TrueWorld world;
  SimulatedClock clock;
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
        arm(world, robot, mounting, force_torque, options, ready_joints(robot, layout), layout.T_W_R),
        gripper(world),
        camera(world, stones, mounting, options),
        shared(world, mounting, robot, stones, options) {}
};

SimulatedCell::SimulatedCell(const std::vector<Stone>& stones, const std::vector<StoneIndex>& present,
                             const RobotModel& robot, const CellLayout& assumed,
                             const SimulationOptions& options) {
  parts_ = std::make_unique<Parts>(stones, present, robot, assumed, options);
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
