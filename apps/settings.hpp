#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "rooms.hpp"
#include "stonestack/core/options.hpp"
#include "stonestack/detection/track_stones.hpp"
#include "stonestack/simulation/render_scene.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

namespace stonestack::apps {

/// The options of all commands, as a file may hold them.
struct EveryOption {
  BuildOptions build;
  TrackOptions tracking;
  SimulationOptions simulation;
  SceneOptions scene;
};
[[nodiscard]] FieldList every_field(EveryOption& every);

/// Where the options of a command come from. Precedence: flag, environment (STONESTACK_*), project file
/// (./stonestack.yaml), user file (~/.config/stonestack/config.yaml), default. A file may hold options of
/// other commands as well: they are checked, and have no effect.
class Settings {
 public:
  /// Adds --set and --config to a subcommand.
  void register_on(CLI::App& command);
  /// A flag of its own for the option `name`, e.g. --method for search.method: when given, it beats files and
  /// environment like any flag. "*.seed" means the seed of every part.
  void bind(CLI::Option* flag, const std::string& name);
  /// Applies files, environment, bound flags and --set to `list`, in that order; remembers the origin of each
  /// value. Where that makes detection.method one that stands for a set of options, these take the place of
  /// the defaults.
  /// Throws FileError or InvalidArgument naming file, value and range.
  void apply(const FieldList& list);
  /// "default", "detection.method", "user file PATH", "project file PATH", "environment NAME", "flag --set".
  [[nodiscard]] std::string origin(const std::string& name) const;

 private:
  std::vector<std::string> assignments_;
  std::string config_;
  std::vector<std::pair<CLI::Option*, std::string>> bound_;
  std::map<std::string, std::string> origins_;

  void apply_bound(const FieldList& list);
  void apply_file(const FieldList& list, const std::string& path, const std::string& kind);
};

/// Sets "NAME=VALUE" one after the other, as --set does, also what a detection.method among them stands for.
/// Throws InvalidArgument.
void set_fields(const FieldList& list, const std::vector<std::string>& assignments);

}  // namespace stonestack::apps
