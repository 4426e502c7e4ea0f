#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "rooms.hpp"
#include "stonestack/experiment/option_sources.hpp"

namespace stonestack::apps {

/// Options of a command by its flags, --set and --config, the environment and files (`OptionSources`).
class Settings {
 public:
  /// Adds --set and --config to a subcommand.
  void register_on(CLI::App& command);
  /// Makes a flag of its own set the option `name`, e.g. --method for search.method. "*.seed" means the seed
  /// of every part.
  void bind(CLI::Option* flag, const std::string& name) { bound_.emplace_back(flag, name); }
  /// Sets the options in `list`.
  /// @throws FileError or InvalidArgument with file, value and range
  void apply(const FieldList& list);
  /// Sources of what `apply` set.
  [[nodiscard]] const OptionOrigins& origins() const { return origins_; }

 private:
  OptionSources sources_;
  std::vector<std::pair<CLI::Option*, std::string>> bound_;
  OptionOrigins origins_;
};

}  // namespace stonestack::apps
