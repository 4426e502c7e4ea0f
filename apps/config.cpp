#include <filesystem>
#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/emulators/simulated_servers.hpp"

namespace stonestack::apps {
namespace {

struct ConfigCommand {
  Settings settings;
  bool origin = false;
  bool expert = false;
  bool json = false;
};

void show(ConfigCommand& command) {
  EveryOption every;
  const FieldList list = fields(every);
  command.settings.apply(list);
  const OptionOrigins& origins = command.settings.origins();
  FieldList shown;  // all, or those for users and what somebody set
  for (const Field& field : list)
    if (command.expert || field.tier == Tier::kUser || origins.contains(field.name)) shown.push_back(field);
  if (command.json) {
    std::cout << fields_json(shown, &origins);
  } else if (!command.origin) {
    std::cout << write_fields(shown);
  } else {
    for (const Field& field : shown)
      std::cout << field.name << ": " << field_text(field) << "  # " << origin_of(field.name, origins)
                << '\n';
  }
}

struct InitCommand {
  std::string path = "stonestack.yaml";
  bool expert = false;
  bool force = false;
};

void init(InitCommand& command) {
  require(command.force || !std::filesystem::exists(command.path), command.path,
          " is there already; --force writes over it, or name another file");
  EveryOption every;
  const FieldList list = fields(every);
  write_file(command.path, option_file_template(command.expert ? list : user_fields(list)));
  std::cout << "wrote " << command.path << '\n';
}

/// A cell file with defaults, to copy lines from.
void show_cell(ConfigCommand& command) {
  CellFile file;
  const FieldList list = join({cell_fields(file), fields(file.cell())});
  const FieldList shown = command.expert ? list : user_fields(list);
  std::cout << (command.json ? fields_json(shown) : write_fields(shown));
}

}  // namespace

void add_config(CLI::App& app) {
  CLI::App* config = app.add_subcommand("config", "Options and where their values come from");
  config->require_subcommand(1);
  config->footer(
      "Examples:\n  stonestack config show\n  stonestack config init\n  stonestack config cell --expert");
  const auto [options, shown] = add_subcommand<ConfigCommand>(
      *config, "show", "The options for users: value, range, unit and effect", show);
  options.add_flag("--origin", shown.origin,
                   "Show which of default, file, environment or flag set each value");
  options.add_flag("--expert", shown.expert, "Every option, those for experts too");
  options.add_flag("--json", shown.json, "As JSON, with the origin of each value");
  shown.settings.register_on(options);
  options.footer(
      "Precedence: flag, environment (STONESTACK_SEARCH_FRICTION=0.3), ./stonestack.yaml, "
      "~/.config/stonestack/config.yaml, default.\n"
      "Examples:\n"
      "  stonestack config init                        an option file to edit\n"
      "  stonestack config show --expert | grep simulation    how hard the simulated cell is\n"
      "  stonestack config show --origin");
  const auto [begin, file] = add_subcommand<InitCommand>(
      *config, "init", "Write an option file in which every line is a comment, to edit", init);
  add_path(begin, "FILE", file.path, "File to write: the project file, or ~/.config/stonestack/config.yaml")
      ->capture_default_str();
  begin.add_flag("--expert", file.expert, "Every option, those for experts too");
  begin.add_flag("--force", file.force, "Write over a file that is there");
  begin.footer("Example:\n  stonestack config init && stonestack config show --origin");
  const auto [cell, entries] = add_subcommand<ConfigCommand>(
      *config, "cell", "What a cell file may hold: value, range, unit and effect", show_cell);
  cell.add_flag("--expert", entries.expert, "All that it may hold, settings for experts too");
  cell.add_flag("--json", entries.json, "As JSON");
  cell.footer("Example:\n  stonestack config cell --expert | grep faults    every fault of the simulators");
}

}  // namespace stonestack::apps
