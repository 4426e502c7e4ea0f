#include "stonestack/emulators/simulated_servers.hpp"

#include "emulators/robotiq/two_finger_simulator.hpp"
#include "emulators/servers_options.hpp"
#include "kinematics/gripper_file.hpp"
#include "simulation/shared_world.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/hardware/cell_file.hpp"

namespace stonestack::emulators {

SimulatedServersOptions::SimulatedServersOptions() {
  force_torque.serial = false;
  force_torque.cap = true;
  force_torque.streaming = true;
  T_T_C = CellConfig{}.T_T_C;
}

CellLayout true_layout(CellLayout layout, const SimulatedServersOptions& options) {
  // Where no mount is given the camera sits at the same place on the flange, whatever the gripper.
  const bool usual = options.T_T_C == CellConfig{}.T_T_C && layout.gripper != CellLayout{}.gripper;
  layout.T_T_C =
      usual ? with_gripper({}, layout.gripper).T_T_C : to_pose(options.T_T_C, "simulators.camera.T_T_C");
  return layout;
}

FieldList fields(SimulatedServersOptions& o) {
  return join({nest("arm", fields(o.arm)), nest("gripper", fields(o.gripper)),
               nest("gripper.faults", fields(o.gripper_faults)),
               nest("gripper.wire_faults", fields(o.modbus_faults)),
               nest("force_torque", fields(o.force_torque)),
               nest("force_torque.faults", fields(o.force_torque_faults)), nest("camera", fields(o.camera)),
               nest("camera", pose_fields("T_T_C", o.T_T_C, "camera in the tool, as it really sits")),
               nest("camera.faults", fields(o.camera_faults))});
}

// A device that is served, and what it does to the world.
struct SimulatedServers::Parts {
  SimulatedServersOptions options;
  SharedWorld* world;
  std::unique_ptr<Plant> arm_plant;
  std::unique_ptr<GripperPlant> gripper_plant;
  std::unique_ptr<WrenchPlant> wrench_plant;
  std::unique_ptr<DepthPlant> depth_plant;
  std::unique_ptr<UrControllerServer> arm;
  std::unique_ptr<GripperServer> gripper;
  std::unique_ptr<FtSimulator> force_torque;
  std::unique_ptr<CameraSimulator> camera;
  bool two_fingers = false;

  Parts(SimulatedCell& cell, const RobotModel& robot, const SimulatedServersOptions& o)
      : options(o), world(&cell.shared()) {
    if (o.devices.gripper) serve_gripper(read_gripper_file(cell.cell().layout.gripper));
    if (o.devices.force_torque) serve_force_torque();
    if (o.devices.camera) serve_camera();
    if (o.devices.arm) {
      arm_plant = make_world_plant(*world, cell.cell().arm.state().q, has_own_sensor(o.arm));
      arm = std::make_unique<UrControllerServer>(installed(), robot, *arm_plant);
      arm->start();
    } else {
      world->start(o.arm.speed);  // else the arm's controller lets time pass
    }
  }
  ~Parts() {
    if (arm)
      arm->stop();
    else
      world->stop();
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;

  // A gripper that is missing in the installation would appear as a force in the controller's data.
  [[nodiscard]] UrServerOptions installed() const {
    UrServerOptions o = options.arm;
    const GripperModel model = world->lock().world.gripper_body().gripper;
    o.payload = carried_mass(model);
    o.payload_cog = world->mounting().T_F_T * gripper_centre(model);
    return o;
  }

  void serve_gripper(const GripperFile& file) {
    if (file.against == 1) {
      two_fingers = true;
      gripper_plant = make_world_gripper(*world, {file.open_count, file.closed_count, file.open_count});
      gripper = std::make_unique<TwoFingerSimulator>(*gripper_plant, file, options.gripper);
    } else {
      gripper_plant = make_world_gripper(*world);
      gripper = std::make_unique<GripperSimulator>(*gripper_plant, options.gripper);
    }
    gripper->set_faults(options.gripper_faults);
    gripper->set_faults(options.modbus_faults);
  }
  void serve_force_torque() {
    wrench_plant = make_world_wrench(*world);
    force_torque = std::make_unique<FtSimulator>(*wrench_plant, options.force_torque);
    force_torque->set_faults(options.force_torque_faults);
  }
  void serve_camera() {
    depth_plant = make_world_depth(*world);
    camera = std::make_unique<CameraSimulator>(*depth_plant, options.camera);
    camera->set_faults(options.camera_faults);
  }
};

SimulatedServers::SimulatedServers(SimulatedCell& cell, const RobotModel& robot,
                                   const SimulatedServersOptions& options)
    : parts_(std::make_unique<Parts>(cell, robot, options)) {}

SimulatedServers::~SimulatedServers() = default;

const SimulatedServersOptions& SimulatedServers::options() const {
  return parts_->options;
}
UrPorts SimulatedServers::arm_ports() const {
  return parts_->arm ? parts_->arm->ports() : UrPorts{};
}
std::string SimulatedServers::arm_address() const {
  return parts_->options.arm.address;
}
std::optional<Endpoint> SimulatedServers::gripper() const {
  if (!parts_->gripper || !options().gripper.tcp) return std::nullopt;
  return parts_->gripper->endpoint();
}
std::optional<Endpoint> SimulatedServers::force_torque() const {
  if (!parts_->force_torque || !options().force_torque.cap) return std::nullopt;
  return parts_->force_torque->stream_endpoint();
}
std::optional<Endpoint> SimulatedServers::camera() const {
  if (!parts_->camera) return std::nullopt;
  return parts_->camera->endpoint();
}
std::string SimulatedServers::gripper_line() const {
  return parts_->gripper && options().gripper.rtu ? parts_->gripper->serial_path() : "";
}
std::string SimulatedServers::force_torque_line() const {
  return parts_->force_torque && options().force_torque.serial ? parts_->force_torque->serial_path() : "";
}

std::string SimulatedServers::text() const {
  const UrPorts p = arm_ports();
  const auto& o = parts_->options;
  std::string text;
  if (o.devices.arm)
    text +=
        concat("UR controller  ", arm_address(), "  RTDE ", p.rtde, ", primary ", p.primary, ", secondary ",
               p.secondary, ", realtime ", p.realtime, ", read-only ", p.primary_read_only, " ",
               p.secondary_read_only, " ", p.realtime_read_only, ", Dashboard ", p.dashboard, "\n");
  if (const auto at = gripper())
    text += concat("gripper        ", to_text(*at),
                   parts_->two_fingers ? "  text of the URCap\n" : "  Modbus/TCP\n");
  const auto line = [](const std::string& link, const std::string& path) {
    return link.empty() ? path : concat(link, " (", path, ")");
  };
  if (const auto path = gripper_line(); !path.empty())
    text += concat("gripper        ", line(o.gripper.link, path), "  Modbus/RTU\n");
  if (const auto at = force_torque())
    text += concat("force sensor   ", to_text(*at), "  stream of the UR cap, commands on ",
                   parts_->force_torque->command_endpoint().port, "\n");
  if (const auto path = force_torque_line(); !path.empty())
    text += concat("force sensor   ", line(o.force_torque.link, path), "  Modbus/RTU and stream\n");
  if (const auto at = camera()) text += concat("depth camera   ", to_text(*at), "  frames\n");
  return text;
}

}  // namespace stonestack::emulators
