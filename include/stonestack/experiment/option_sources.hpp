#pragma once
#include <map>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/experiment/simulated_run.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

#pragma GCC visibility push(default)

/// Where the options of a program come from. Precedence: flag, environment (STONESTACK_*), project file
/// (./stonestack.yaml), user file (~/.config/stonestack/config.yaml), default.
namespace stonestack::experiment {

/// The options of all commands, as a file may hold them.
struct EveryOption {
  BuildOptions build;            ///< options of the loop
  TrackOptions tracking;         ///< options of tracking
  SimulationOptions simulation;  ///< options of the simulated world
  SceneOptions scene;            ///< options of a rendered scene
};
/// Names the options of all commands.
[[nodiscard]] FieldList fields(EveryOption& every);

/// Value that a flag of its own gives to an option: --method for search.method.
struct FlagValue {
  std::string flag;    ///< flag on the command line
  std::string option;  ///< "*.seed": the seed of every part
  std::string value;   ///< text that the user gave
};

/// Options as a command line gives them.
struct OptionSources {
  std::string config;                    ///< option file in place of ./stonestack.yaml; empty: none
  std::vector<FlagValue> flags;          ///< values from flags of their own
  std::vector<std::string> assignments;  ///< "NAME=VALUE", one after the other
};

/// Sources of the values of options, by name; an option that is not in it has its default.
using OptionOrigins = std::map<std::string, std::string>;
/// @return "default" for an option that is not in it
[[nodiscard]] std::string origin_of(const std::string& option, const OptionOrigins& origins);

/// Applies files, environment, flags and assignments to `list`, in that order. A file may hold options of
/// other commands as well: they are checked, and have no effect. Where detection.method or simulation.cell
/// becomes one that stands for a set of options, these take the place of the defaults.
/// @return "detection.method", "simulation.cell", "user file PATH", "project file PATH", "file PATH",
/// "environment NAME", "flag --set" or the name of a flag for each option that is not at its default.
/// @throws FileError or InvalidArgument with file, value and range
[[nodiscard]] OptionOrigins apply_options(const FieldList& list, const OptionSources& sources);

/// Sets "NAME=VALUE" one after the other, as --set does, also the options that a detection.method or
/// simulation.cell among them stands for.
/// @throws InvalidArgument
void set_fields(const FieldList& list, const std::vector<std::string>& assignments);

/// Text of an option file in which every option stands with its meaning, range and value, each commented out.
[[nodiscard]] std::string option_file_template(const FieldList& list);

/// JSON text of schema stonestack.config/1: name, description and value of each field, range and unit of a
/// number, its origin where `origins` is given.
[[nodiscard]] std::string fields_json(const FieldList& list, const OptionOrigins* origins = nullptr);

}  // namespace stonestack::experiment

#pragma GCC visibility pop
