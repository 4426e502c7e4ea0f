#include <iostream>
#include <memory>

#include "cell_input.hpp"
#include "commands.hpp"
#include "settings.hpp"

namespace stonestack::apps {
namespace {

struct ConfigCommand {
  Settings settings;
  bool origin = false;
  bool expert = false;
};

/// All, or those for users and what somebody set.
FieldList chosen(const FieldList& list, const ConfigCommand& command) {
  FieldList shown;
  for (const Field& field : list)
    if (command.expert || field.tier == Tier::kUser || command.settings.origin(field.name) != "default")
      shown.push_back(field);
  return shown;
}

void show(ConfigCommand& command) {
  EveryOption every;
  const FieldList list = every_field(every);
  command.settings.apply(list);
  if (!command.origin) {
    std::cout << write_fields(chosen(list, command));
    return;
  }
  for (const auto& field : chosen(list, command))
    std::cout << field.name << ": " << field_text(field) << "  # " << command.settings.origin(field.name)
              << '\n';
}

/// A cell file with defaults, to copy lines from.
void show_cell(bool expert) {
  CellFile file;
  const FieldList list = join({cell_fields(file), fields(file.cell)});
  std::cout << write_fields(expert ? list : user_fields(list));
}

}  // namespace

void add_config(CLI::App& app) {
  auto command = std::make_shared<ConfigCommand>();
  CLI::App* sub = app.add_subcommand("config", "Options and where their values come from");
  sub->require_subcommand(1);
  CLI::App* show_command = sub->add_subcommand("show", "The options for users: value, range, unit and effect");
  show_command->add_flag("--origin", command->origin, "Say which of default, file, environment or flag won");
  show_command->add_flag("--expert", command->expert, "Every option, those for experts too");
  command->settings.register_on(*show_command);
  show_command->footer(
      "Precedence: flag, environment (STONESTACK_SEARCH_FRICTION=0.3), ./stonestack.yaml, "
      "~/.config/stonestack/config.yaml, default.\n"
      "Examples:\n"
      "  stonestack config show > stonestack.yaml      an option file to edit\n"
      "  stonestack config show --expert | grep simulation    how hard the simulated cell is\n"
      "  stonestack config show --origin");
  show_command->callback([command] { show(*command); });
  CLI::App* cell_command =
      sub->add_subcommand("cell", "What a cell file may hold: value, range, unit and effect");
  cell_command->add_flag("--expert", command->expert, "All that it may hold, settings for experts too");
  cell_command->footer(
      "Example:\n  stonestack config cell --expert | grep faults    every fault of the simulators");
  cell_command->callback([command] { show_cell(command->expert); });
}

}  // namespace stonestack::apps
