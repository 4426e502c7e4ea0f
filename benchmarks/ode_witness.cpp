#include "ode_witness.hpp"

#include <algorithm>

#include "physics/rigid_world.hpp"
#include "physics/shape.hpp"

namespace stonestack::bench {

void Judges::register_on(CLI::App& command) {
  command.add_flag("--ode", ode, "Let each stand in another engine too (ODE, concave meshes, 5 s)");
  command.add_option("--ode-step", in_ode.step, "Of that engine, s")
      ->check(CLI::Range(1e-5, 0.02))
      ->capture_default_str();
  command.add_option("--stand", stand_seconds, "How long each must stand, s")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
}

OdeVerdict stand_in_ode(const ShapeList& shapes, const Stack& stack, const OdeOptions& options) {
  WorldOptions in_ode;
  in_ode.friction = options.friction;
  const auto world = make_rigid_world(EngineKind::kOde, in_ode);
  for (const PlacedStone& placed : stack.stones)
    world->add_stone(at(shapes, placed.stone), placed.T_W_O, false);
  OdeVerdict verdict;
  verdict.standing = static_cast<int>(stack.stones.size());
  for (double t = 0.0; t < options.seconds; t += options.step) {
    world->step(options.step);
    for (int k = 0; k < static_cast<int>(stack.stones.size()); ++k) {
      const PlacedStone& placed = stack.stones[static_cast<std::size_t>(k)];
      const Eigen::Vector3d& p_O_M = at(shapes, placed.stone)->mass.p_O_M;
      const Pose now = world->pose(k);
      const double shift = (now * p_O_M - placed.T_W_O * p_O_M).norm();
      const double turn = difference(placed.T_W_O, now).angle;
      verdict.shift = std::max(verdict.shift, shift);
      verdict.turn = std::max(verdict.turn, turn);
      if (shift > options.max_shift || turn > options.max_turn)
        verdict.standing = std::min(verdict.standing, k);
    }
    if (verdict.standing == 0) break;
  }
  return verdict;
}

}  // namespace stonestack::bench
