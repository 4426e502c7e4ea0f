#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/hardware/cell_file.hpp"

namespace stonestack::apps {
namespace {

struct SetupCommand {
  Loudness loudness;
  CellSetup order;
  bool json = false;
};

/// Asks a person for what was not given; empty where nobody is there.
void ask_for(std::string& value, const std::string& question) {
  if (value.empty()) value = ask_person(question).value_or("");
}

void setup(SetupCommand& command) {
  command.loudness.apply();
  ask_for(command.order.arm, "Address or name of the robot's controller: ");
  if (command.order.gripper == CellSetup{}.gripper)
    ask_for(command.order.gripper_address, "Address or name of the 3-finger gripper: ");
  require_sound(command.order);
  const ControllerDescription controller = describe_controller(command.order.arm);
  const NewCell made = write_new_cell(command.order, controller);
  std::ostream& out = command.json ? std::cerr : std::cout;
  out << made.robot << " with PolyScope " << controller.polyscope << ", " << to_text(controller.state)
      << '\n';
  if (!made.robot_file.empty())
    out << made.robot_file << ": the arm's calibration, " << 1e3 * made.calibration
        << " mm at full stretch\n";
  for (const std::string& note : made.notes) out << "note: " << note << '\n';
  out << made.path << " is written. Next: check its lines, then\n  stonestack doctor --cell " << made.path
      << "\n  stonestack calibrate --capture " << made.path << " --execute --write " << made.path
      << "\n  stonestack calibrate --table " << made.path << " --execute --write " << made.path
      << "\n  stonestack run --cell " << made.path << " --dry-run\n";
  if (command.json) std::cout << new_cell_json(made, controller);
}

}  // namespace

void add_setup(CLI::App& app) {
  const auto [sub, command] = add_subcommand<SetupCommand>(
      app, "setup", "Write the cell file of an arm, as its controller describes it", setup);
  add_path(sub, "CELL", command.order.path, "Cell file to write")->required();
  sub.add_option("--address", command.order.arm,
                 "Address or name of the robot's controller (default: it asks)");
  sub.add_option("--gripper", command.order.gripper,
                 "robotiq-3f, robotiq-2f-85, robotiq-2f-140 or robotiq-hand-e")
      ->capture_default_str();
  sub.add_option("--gripper-address", command.order.gripper_address,
                 "Address or name of a 3-finger gripper (default: it asks)");
  sub.add_option("--robot", command.order.robot, "ur3 to ur16e (default: as the controller says)");
  sub.add_flag("--force", command.order.replace, "Replace a cell file that is there");
  sub.add_flag("--json", command.json, "Result as JSON on stdout");
  command.loudness.register_on(sub);
  sub.footer(
      "Reads model, version, state, payload and factory calibration from the controller; moves and changes\n"
      "nothing there. What a controller cannot know is marked with \"check\" in the file.\n"
      "Examples:\n"
      "  stonestack setup my_lab.yaml\n"
      "  stonestack setup my_lab.yaml --address 192.168.1.10 --gripper-address 192.168.1.11\n"
      "  stonestack setup my_lab.yaml --address ur10e.local --gripper robotiq-2f-85");
}

}  // namespace stonestack::apps
