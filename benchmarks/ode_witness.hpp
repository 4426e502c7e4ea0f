#pragma once
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "rooms.hpp"
#include "stonestack/physics/stack.hpp"

namespace stonestack::bench {

/// Verdict of the Open Dynamics Engine, which shares only the scans with this library's engine.
struct OdeOptions {
  double friction = 0.1;
  double seconds = 5.0;        ///< simulated
  double step = 0.0005;        ///< time step, s
  double max_shift = 0.002;    ///< of a centre of mass, m
  double max_turn = 0.034907;  ///< of a stone, rad (2 deg)
};
struct OdeVerdict {
  int standing = 0;    ///< stones from the bottom that stayed
  double shift = 0.0;  ///< largest of any stone, m
  double turn = 0.0;   ///< largest of any stone, rad
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(OdeVerdict, standing, shift, turn)
/// How planned stacks are judged.
struct Judges {
  bool ode = false;             ///< in the other engine too
  OdeOptions in_ode;            ///< its options
  double stand_seconds = 60.0;  ///< in this library's engine, simulated

  /// --ode, --ode-step, --stand.
  void register_on(CLI::App& command);
};
/// Lets a stack stand with every stone dynamic (physics: OdeWorld).
[[nodiscard]] OdeVerdict stand_in_ode(const ShapeList& shapes, const Stack& stack,
                                      const OdeOptions& options = {});

}  // namespace stonestack::bench
