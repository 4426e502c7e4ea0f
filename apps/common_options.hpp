#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "settings.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::apps {

/// Options of nearly every subcommand.
struct CommonOptions {
  std::string catalogue;  ///< empty: the stones that come with the project
  int seed = 1;
  bool json = false;
  bool quiet = false;
  Settings settings;

  /// --catalogue, --seed, --json, --quiet, --set, --config.
  void register_on(CLI::App& command);
  /// Registers catalogue, seed and settings alone, for a benchmark: no --json, no --quiet.
  void register_draw(CLI::App& command);
  /// Applies --quiet; call first in a callback.
  void begin() const;
  [[nodiscard]] Catalogue read() const;
};

/// Throws InvalidArgument if the user asked by the flag `asked` for more stones than the catalogue has.
void require_stones(const Catalogue& catalogue, int count, const CLI::Option* asked);

/// `count` stones of a catalogue, drawn by the seed, sorted (paper §4.2: an alternating set of four of six).
/// What the hand of that cell or the arm cannot carry (`unfit_for_gripper`) is not drawn but named in the
/// log; fewer than `count` may be left. Throws Error (planning failed) if none is.
[[nodiscard]] std::vector<int> draw_stones(const Catalogue& catalogue, int count, int seed,
                                           const GripperModel& gripper, const RobotModel& robot);

}  // namespace stonestack::apps
