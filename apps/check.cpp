#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "common_options.hpp"
#include "geometry/pose_json.hpp"
#include "physics/shape.hpp"
#include "scene_input.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/report/run_report.hpp"

namespace stonestack::apps {
namespace {

constexpr double kOverlap =
    0.002;                      // m: stones that stand touch; what is deeper says nothing of how they stand
constexpr int kConeEdges = 64;  // of a friction cone; the search makes do with 8, 8 % on the safe side

struct CheckCommand {
  CommonOptions common;
  std::string input;
  std::string picture;
  double friction = 0.1;
  double seconds = 10.0;
};

/// All that is told of a stack.
struct Report {
  StandVerdict verdict;
  Equilibrium equilibrium;
  StackStatics statics;
};

Stack read_stack(const std::string& path, const Catalogue& catalogue) {
  if (!is_scene_file(path))
    throw FileError(path, "is not a scene file", "give a .yaml file with a stack, as `search --out` writes");
  const SceneFile scene = read_scene_file(path);
  if (scene.stack.empty()) throw FileError(path, "has no stack", "list its stones from the table up");
  Stack stack;
  for (const NamedPose& item : scene.stack) stack.stones.push_back({catalogue.index(item.stone), item.T_W_O});
  return stack;
}

void refuse_impossible(const std::string& path, const ShapeList& shapes, const Stack& stack) {
  for (const PlacedStone& placed : stack.stones) {
    const ContactShape& shape = *shapes[static_cast<std::size_t>(placed.stone)];
    const std::string wrong = impossible(shape);
    if (!wrong.empty()) throw FileError(path, concat("stone ", shape.name, ": ", wrong), "mend the stone");
  }
  const std::string overlap = overlap_of(shapes, stack, kOverlap);
  if (!overlap.empty()) throw FileError(path, overlap, "give poses at which the stones touch");
}

Report examine(const CheckCommand& command, const ShapeList& shapes, const Stack& stack) {
  Report report;
  StandOptions stand;
  stand.friction = command.friction;
  stand.seconds = command.seconds;
  report.verdict = judge_stack(shapes, stack, stand);
  report.statics = stack_statics(shapes, stack, command.friction);
  EquilibriumOptions options;
  options.friction = command.friction;
  options.directions = 16;
  options.cone_edges = kConeEdges;
  report.equilibrium = solve_equilibrium(report.statics.bodies, report.statics.contacts, options);
  return report;
}

class Names {
 public:
  Names(const Catalogue& catalogue, const Stack& stack) : catalogue_(catalogue), stack_(stack) {}
  [[nodiscard]] std::string of(int level) const {
    if (level == kTable) return "the table";
    return catalogue_.stones[static_cast<std::size_t>(stack_.stones[static_cast<std::size_t>(level)].stone)]
        .name;
  }

 private:
  const Catalogue& catalogue_;
  const Stack& stack_;
};

double degrees(const Eigen::Vector2d& direction) {
  return std::atan2(direction.y(), direction.x()) * 180.0 / M_PI;
}

void print_json(const CheckCommand& command, const Report& report, const Names& names) {
  const Equilibrium& e = report.equilibrium;
  nlohmann::json out = {{"schema", "stonestack.check/1"},
                        {"friction", command.friction},
                        {"seconds", command.seconds},
                        {"stands", report.verdict.stands},
                        {"clean", report.verdict.clean},
                        {"standing", report.verdict.standing},
                        {"shift_m", report.verdict.shift},
                        {"turn_rad", report.verdict.turn},
                        {"reason", report.verdict.reason},
                        {"in_equilibrium", e.stands},
                        {"margin_g", e.margin},
                        {"margin_direction", {e.direction.x(), e.direction.y()}},
                        {"least_friction", nullptr},
                        {"weakest_contact", nullptr}};
  if (std::isfinite(e.min_friction)) out["least_friction"] = e.min_friction;
  if (e.weakest_contact >= 0) {
    const Contact& c = report.statics.contacts[static_cast<std::size_t>(e.weakest_contact)];
    out["weakest_contact"] = {{"above", names.of(c.above)},
                              {"below", names.of(c.below)},
                              {"p_W", {c.p_W.x(), c.p_W.y(), c.p_W.z()}},
                              {"n_W", {c.n_W.x(), c.n_W.y(), c.n_W.z()}}};
  }
  std::cout << out.dump(2) << '\n';
}

void print_text(const CheckCommand& command, const Report& report, const Names& names) {
  const Equilibrium& e = report.equilibrium;
  std::printf("simulation   %s, %s; moved %.3f mm and turned %.3f deg in %g s at friction %g\n",
              report.verdict.stands ? "stands" : "falls", report.verdict.clean ? "clean" : "not clean",
              1e3 * report.verdict.shift, report.verdict.turn * 180 / M_PI, command.seconds,
              command.friction);
  if (!report.verdict.reason.empty()) std::printf("             %s\n", report.verdict.reason.c_str());
  if (e.stands) {
    std::printf(
        "equilibrium  holds; bears %.3f g sideways, least when pushed towards %.0f deg (x is 0, y is 90)\n",
        e.margin, degrees(e.direction));
  } else {
    std::printf("equilibrium  no contact forces hold it\n");
  }
  if (std::isfinite(e.min_friction))
    std::printf("friction     holds down to %.3f\n", e.min_friction);
  else
    std::printf("friction     none up to 2 holds it\n");
  if (e.weakest_contact < 0) return;
  const Contact& c = report.statics.contacts[static_cast<std::size_t>(e.weakest_contact)];
  std::printf("weakest      %s on %s at (%.3f, %.3f, %.3f) m\n", names.of(c.above).c_str(),
              names.of(c.below).c_str(), c.p_W.x(), c.p_W.y(), c.p_W.z());
}

void draw_stack(const std::string& path, const Catalogue& catalogue, const Stack& stack) {
  const auto meshes = drawn_stones(catalogue, stack.stones);
  double top = 0.0;
  for (const auto& item : meshes) top = std::max(top, bounds(transformed(item.mesh, item.T_W_A)).max().z());
  write_png(path, draw(meshes, view_of_site(stack.stones.front().T_W_O.translation().head<2>(), top)));
  log_info("wrote " + path);
}

void check_tower(CheckCommand& command) {
  command.common.begin();
  command.common.settings.apply({});
  require(std::isfinite(command.friction) && command.friction > 0.0, "friction must be positive, got ",
          command.friction);
  require_readable(command.input);
  if (!command.picture.empty()) require_writable(command.picture);
  const Catalogue catalogue = command.common.read();
  const Stack stack = read_stack(command.input, catalogue);
  ShapeList shapes(catalogue.stones.size());
  for (const PlacedStone& placed : stack.stones) {
    const auto k = static_cast<std::size_t>(placed.stone);
    if (!shapes[k]) shapes[k] = make_contact_shapes({catalogue.stones[k]}).front();
  }
  refuse_impossible(command.input, shapes, stack);
  const Report report = examine(command, shapes, stack);
  const Names names(catalogue, stack);
  if (command.common.json)
    print_json(command, report, names);
  else
    print_text(command, report, names);
  if (!command.picture.empty()) draw_stack(command.picture, catalogue, stack);
  if (!report.verdict.stands)
    throw Error("the stack does not stand: " + report.verdict.reason, ExitCode::kNoStablePose);
  if (!report.verdict.clean)
    throw Error("the stack stands, but not cleanly: " + report.verdict.reason, ExitCode::kNoStablePose);
}

}  // namespace

void add_check(CLI::App& app) {
  auto command = std::make_shared<CheckCommand>();
  CLI::App* sub = app.add_subcommand("check", "Does a stack stand, and how firmly?");
  sub->add_option("TOWER", command->input, "Scene file with a stack, from the table up")->required();
  sub->add_option("--friction", command->friction, "Stone on stone and on the table")
      ->check(CLI::Range(1e-3, 2.0))
      ->capture_default_str();
  sub->add_option("--seconds", command->seconds, "How long it must stand, simulated")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  sub->add_option("--picture", command->picture, "Draw it (PNG)");
  command->common.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack search --stones limestone_1,limestone_2 --levels 2 --out tower.yaml\n"
      "  stonestack check tower.yaml --friction 0.3\n"
      "A stack stands if within the time no stone shifts by 1 mm or turns by 1 deg, and is clean if stone i\n"
      "touches stones i-1 and i+1 only (counted from 0, which lies on the table). Exit code 5: it is not "
      "both.\n"
      "TOWER: {schema: stonestack.scene/1, stack: [{stone: limestone_1, T_W_O: {x, y, z, qx, qy, qz, qw}}, "
      "...]}");
  sub->callback([command] { check_tower(*command); });
}

}  // namespace stonestack::apps
