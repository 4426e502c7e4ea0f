#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

namespace stonestack::apps {

/// The options of all commands, as a file may hold them.
struct EveryOption {
  BuildOptions build;
  SimulationOptions simulation;
};
[[nodiscard]] FieldList every_field(EveryOption& every);

/// Where the options of a command come from. Precedence: flag, environment (STONESTACK_*), project file
/// (./stonestack.yaml), user file (~/.config/stonestack/config.yaml), default. A file may hold options of
/// other commands as well: they are checked, and have no effect.
class Settings {
 public:
  /// Adds --set and --config to a subcommand.
  void register_on(CLI::App& command);
  /// Applies files, environment and --set to `list`, in that order; remembers the origin of each value.
  /// Throws FileError or InvalidArgument naming file, value and range.
  void apply(const FieldList& list);
  /// "default", "user file PATH", "project file PATH", "environment NAME", "flag --set".
  [[nodiscard]] std::string origin(const std::string& name) const;

 private:
  std::vector<std::string> assignments_;
  std::string config_;
  std::map<std::string, std::string> origins_;

  void apply_file(const FieldList& list, const std::string& path, const std::string& kind);
};

}  // namespace stonestack::apps
