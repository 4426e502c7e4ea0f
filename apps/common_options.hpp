#pragma once
#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>
#include <string>

#include "rooms.hpp"
#include "settings.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/model_stone.hpp"

namespace stonestack::apps {

/// --quiet and --verbose.
struct Loudness {
  bool quiet = false;
  bool verbose = false;

  void register_on(CLI::App& command);
  /// Sets what is logged; call first in a callback.
  void apply() const;
};

/// Options of nearly every subcommand.
struct CommonOptions {
  std::string catalogue;  ///< empty: the stones that come with the project
  int seed = 1;
  bool json = false;
  Loudness loudness;
  Settings settings;

  /// Adds --catalogue, --seed, --json, --quiet, --verbose, and if the command has options by name --set and
  /// --config.
  void register_on(CLI::App& command, bool has_options = true);
  /// Registers catalogue, seed and settings alone, for a benchmark: no --json, no --quiet, no --verbose.
  void register_draw(CLI::App& command);
  /// Stream of a result for a person: stdout, or stderr where stdout holds JSON.
  [[nodiscard]] std::ostream& text() const;
  /// Applies --quiet and --verbose; call first in a callback.
  void begin() const;
  [[nodiscard]] Catalogue read() const;

 private:
  void register_stones(CLI::App& command);
};

/// --density or --mass, and --friction.
void register_stone_options(CLI::App& command, ModelOptions& options);

/// --view and --view-port: a page of the work under way.
void add_live_view(CLI::App& command, LiveView& view);

/// --per-run: how many stones of the catalogue lie in the field.
struct PerRun {
  int count = 4;
  const CLI::Option* asked = nullptr;

  void register_on(CLI::App& command);
  /// @throws InvalidArgument if the user asked for more stones than the catalogue has
  void check(const Catalogue& catalogue) const;
};

/// Subcommand, and the values of its options until the program ends.
template <class Values>
struct Subcommand {
  CLI::App& app;
  Values& values;
};
/// Adds a subcommand that calls `run` with the values of its options; --quiet of a member `common` is applied
/// before. The caller registers the options.
template <class Values>
Subcommand<Values> add_subcommand(CLI::App& app, const std::string& name, const std::string& description,
                                  void (*run)(Values&)) {
  const auto values = std::make_shared<Values>();
  CLI::App* sub = app.add_subcommand(name, description);
  sub->callback([values, run] {
    if constexpr (requires { values->common.begin(); }) values->common.begin();
    run(*values);
  });
  return {*sub, *values};
}
/// Adds --wall and --bridge, which name what is built instead of a tower.
/// @param settings binds them to the option `run.wall`; may be null
void add_structure(CLI::App& command, std::string& wall, Settings* settings);
/// Adds --objective of the pose search.
void add_objective(CLI::App& command, std::string& objective, Settings& settings);
/// Adds an option that takes a path, or whatever else `type` names in the help.
CLI::Option* add_path(CLI::App& command, const std::string& name, std::string& value,
                      const std::string& description, const std::string& type = "FILE");

}  // namespace stonestack::apps
