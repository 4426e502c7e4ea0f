#include "stonestack/simulation/simulated_servers.hpp"

#include "stonestack/core/error.hpp"

namespace stonestack {

SimulatedServersOptions::SimulatedServersOptions() {
  force_torque.serial = false;
  force_torque.cap = true;
  force_torque.streaming = true;
}

FieldList fields(SimulatedServersOptions& o) {
  return join({nest("arm", fields(o.arm)), nest("gripper", fields(o.gripper)),
               nest("gripper.faults", fields(o.gripper_faults)),
               nest("gripper.wire_faults", fields(o.modbus_faults)),
               nest("force_torque", fields(o.force_torque)),
               nest("force_torque.faults", fields(o.force_torque_faults)), nest("camera", fields(o.camera)),
               nest("camera.faults", fields(o.camera_faults))});
}

struct SimulatedServers::Parts {
  SimulatedServersOptions options;
  std::unique_ptr<Plant> arm_plant;
  std::unique_ptr<GripperPlant> gripper_plant;
  std::unique_ptr<WrenchPlant> wrench_plant;
  std::unique_ptr<DepthPlant> depth_plant;
  UrControllerServer arm;
  GripperSimulator gripper;
  FtSimulator force_torque;
  CameraSimulator camera;

  Parts(SimulatedCell& cell, const RobotModel& robot, const SimulatedServersOptions& o)
      : options(o),
        arm_plant(make_world_plant(cell.shared(), cell.cell().arm.state().q)),
        gripper_plant(make_world_gripper(cell.shared())),
        wrench_plant(make_world_wrench(cell.shared())),
        depth_plant(make_world_depth(cell.shared())),
        arm(o.arm, robot, *arm_plant),
        gripper(*gripper_plant, o.gripper),
        force_torque(*wrench_plant, o.force_torque),
        camera(*depth_plant, o.camera) {
    gripper.set_faults(o.gripper_faults);
    gripper.set_faults(o.modbus_faults);
    force_torque.set_faults(o.force_torque_faults);
    camera.set_faults(o.camera_faults);
    arm.start();
  }
};

SimulatedServers::SimulatedServers(SimulatedCell& cell, const RobotModel& robot,
                                   const SimulatedServersOptions& options)
    : parts_(std::make_unique<Parts>(cell, robot, options)) {}

SimulatedServers::~SimulatedServers() {
  parts_->arm.stop();
}

const UrPorts& SimulatedServers::arm_ports() const {
  return parts_->arm.ports();
}
std::string SimulatedServers::arm_address() const {
  return parts_->options.arm.address;
}
Endpoint SimulatedServers::gripper() const {
  return parts_->gripper.endpoint();
}
Endpoint SimulatedServers::force_torque() const {
  return parts_->force_torque.stream_endpoint();
}
Endpoint SimulatedServers::camera() const {
  return parts_->camera.endpoint();
}
UrControllerServer& SimulatedServers::arm() {
  return parts_->arm;
}

std::string SimulatedServers::text() const {
  const UrPorts& p = arm_ports();
  const auto& o = parts_->options;
  std::string text =
      concat("UR controller  ", arm_address(), "  RTDE ", p.rtde, ", primary ", p.primary, ", secondary ",
             p.secondary, ", realtime ", p.realtime, ", read-only ", p.primary_read_only, " ",
             p.secondary_read_only, " ", p.realtime_read_only, ", Dashboard ", p.dashboard, "\n");
  if (o.gripper.tcp) text += concat("gripper        ", to_text(gripper()), "  Modbus/TCP\n");
  const auto line = [](const std::string& link, const std::string& path) {
    return link.empty() ? path : concat(link, " (", path, ")");
  };
  if (o.gripper.rtu)
    text += concat("gripper        ", line(o.gripper.link, parts_->gripper.serial_path()), "  Modbus/RTU\n");
  if (o.force_torque.cap)
    text += concat("force sensor   ", to_text(force_torque()), "  stream of the UR cap, commands on ",
                   parts_->force_torque.command_endpoint().port, "\n");
  if (o.force_torque.serial)
    text += concat("force sensor   ", line(o.force_torque.link, parts_->force_torque.serial_path()),
                   "  Modbus/RTU and stream\n");
  return text + concat("depth camera   ", to_text(camera()), "  frames\n");
}

}  // namespace stonestack
