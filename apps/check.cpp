#include <cmath>
#include <iostream>
#include <optional>

#include "commands.hpp"
#include "common_options.hpp"
#include "scene_input.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::apps {
namespace {

struct CheckCommand {
  CommonOptions common;
  std::string input;
  std::string picture;
  std::string supports;
  std::string densities;
  std::optional<double> friction;  ///< 0.1 for stones, 0.84 (compas_cra's) for an assembly
  double tilt_deg = 0.0;
  double seconds = 10.0;
};

void check_blocks(const CheckCommand& command) {
  AssemblyTask task;
  task.path = command.input;
  task.supports = command.supports;
  task.densities = command.densities;
  task.friction = command.friction.value_or(task.friction);
  task.tilt = command.tilt_deg * M_PI / 180.0;
  const AssemblyCheck found = check_assembly(task);
  std::cout << (command.common.json ? assembly_json(found) : assembly_text(found));
  if (!command.picture.empty()) {
    draw_assembly(command.picture, found);
    log_info("wrote " + command.picture);
  }
  if (!found.balance.stands) throw Error("the assembly does not stand", ExitCode::kNoStablePose);
}

void check(CheckCommand& command) {
  command.common.settings.apply({});
  const double friction = command.friction.value_or(0.1);
  require(std::isfinite(friction) && friction > 0.0, "friction must be positive, got ", friction);
  require_readable(command.input);
  if (!command.picture.empty()) require_writable(command.picture);
  if (is_assembly(command.input)) return check_blocks(command);
  require(command.supports.empty() && command.densities.empty() && command.tilt_deg == 0.0,
          "--supports, --density and --tilt are for assemblies; ", command.input, " is a scene");
  const Catalogue catalogue = command.common.read();
  const TowerCheck found = check_tower(command.input, catalogue, friction, command.seconds);
  std::cout << (command.common.json ? tower_json(found, catalogue) : tower_text(found, catalogue));
  if (!command.picture.empty()) {
    const auto& stones = found.stack.stones;
    draw_tower(command.picture, catalogue, stones, stones.front().T_W_O.translation().head<2>());
    log_info("wrote " + command.picture);
  }
  const StandVerdict& verdict = found.verdict;
  if (!verdict.stands) throw Error("the stack does not stand: " + verdict.reason, ExitCode::kNoStablePose);
  if (!verdict.clean && !found.wall)
    throw Error("the stack stands, but not cleanly: " + verdict.reason, ExitCode::kNoStablePose);
  if (!found.balance.stands)
    throw Error("the stack stands in simulation, but no motion of its stones produces forces that hold it",
                ExitCode::kNoStablePose);
}

}  // namespace

void add_check(CLI::App& app) {
  const auto [sub, command] =
      add_subcommand<CheckCommand>(app, "check", "Does a stack or an assembly stand, and how firmly?", check);
  sub.add_option("TOWER", command.input,
                 "Scene file with a stack, from the table up, or a wall; or an assembly of COMPAS (JSON)")
      ->required();
  sub.add_option("--friction", command.friction,
                 "Friction coefficient of all contacts [0.1 for stones, 0.84 for an assembly]")
      ->check(CLI::Range(1e-3, 2.0));
  sub.add_option("--supports", command.supports, "Blocks of an assembly that do not move: 0,1");
  sub.add_option("--density", command.densities, "Densities of blocks of an assembly: 11=3.51,12=3.51 [1]");
  sub.add_option("--tilt", command.tilt_deg, "Turn an assembly about y by so many degrees")
      ->check(CLI::Range(-180.0, 180.0));
  sub.add_option("--seconds", command.seconds, "How long it must stand, simulated")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  sub.add_option("--picture", command.picture,
                 "Draw the stack, or the assembly with contacts and forces (PNG, or HTML in 3-D)");
  command.common.register_on(sub, false);
  sub.footer(
      "Examples:\n"
      "  stonestack search --stones limestone_1,limestone_2 --levels 2 --out tower.yaml\n"
      "  stonestack check tower.yaml --friction 0.3\n"
      "  stonestack check shelf.json --supports 0 --friction 0.9 --picture shelf.png\n"
      "A stack stands if within the time no stone shifts by 1 mm or turns by 1 deg, and is clean if stone i\n"
      "touches stones i-1 and i+1 only (counted from 0, which lies on the table); in a wall stones may "
      "touch\n"
      "any others. An assembly stands if "
      "coupled\n"
      "rigid-block analysis finds forces that small motions of the blocks produce. Exit code 5: it does "
      "not.\n"
      "TOWER: {schema: stonestack.scene/1, stack: [{stone: limestone_1, T_W_O: {x, y, z, qx, qy, qz, qw}}, "
      "...]}");
}

}  // namespace stonestack::apps
