#include <cmath>
#include <iostream>

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
  double friction = 0.1;
  double seconds = 10.0;
};

void check(CheckCommand& command) {
  command.common.settings.apply({});
  require(std::isfinite(command.friction) && command.friction > 0.0, "friction must be positive, got ",
          command.friction);
  require_readable(command.input);
  if (!command.picture.empty()) require_writable(command.picture);
  const Catalogue catalogue = command.common.read();
  const TowerCheck found = check_tower(command.input, catalogue, command.friction, command.seconds);
  std::cout << (command.common.json ? tower_json(found, catalogue) : tower_text(found, catalogue));
  if (!command.picture.empty()) {
    const auto& stones = found.stack.stones;
    draw_tower(command.picture, catalogue, stones, stones.front().T_W_O.translation().head<2>());
    log_info("wrote " + command.picture);
  }
  const StandVerdict& verdict = found.verdict;
  if (!verdict.stands) throw Error("the stack does not stand: " + verdict.reason, ExitCode::kNoStablePose);
  if (!verdict.clean)
    throw Error("the stack stands, but not cleanly: " + verdict.reason, ExitCode::kNoStablePose);
}

}  // namespace

void add_check(CLI::App& app) {
  const auto [sub, command] =
      add_subcommand<CheckCommand>(app, "check", "Does a stack stand, and how firmly?", check);
  sub.add_option("TOWER", command.input, "Scene file with a stack, from the table up")->required();
  sub.add_option("--friction", command.friction, "Friction coefficient, stone on stone and on the table")
      ->check(CLI::Range(1e-3, 2.0))
      ->capture_default_str();
  sub.add_option("--seconds", command.seconds, "How long it must stand, simulated")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  sub.add_option("--picture", command.picture, "Draw the stack (PNG)");
  command.common.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack search --stones limestone_1,limestone_2 --levels 2 --out tower.yaml\n"
      "  stonestack check tower.yaml --friction 0.3\n"
      "A stack stands if within the time no stone shifts by 1 mm or turns by 1 deg, and is clean if stone i\n"
      "touches stones i-1 and i+1 only (counted from 0, which lies on the table). Exit code 5: it is not "
      "both.\n"
      "TOWER: {schema: stonestack.scene/1, stack: [{stone: limestone_1, T_W_O: {x, y, z, qx, qy, qz, qw}}, "
      "...]}");
}

}  // namespace stonestack::apps
