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
};

void show(ConfigCommand& command) {
  EveryOption every;
  const FieldList list = every_field(every);
  command.settings.apply(list);
  if (!command.origin) {
    std::cout << write_fields(list);
    return;
  }
  for (const auto& field : list)
    std::cout << field.name << ": " << field_text(field) << "  # " << command.settings.origin(field.name)
              << '\n';
}

/// A cell file with every default, to copy lines from.
void show_cell() {
  CellFile file;
  std::cout << write_fields(cell_fields(file)) << write_fields(fields(file.cell));
}

}  // namespace

void add_config(CLI::App& app) {
  auto command = std::make_shared<ConfigCommand>();
  CLI::App* sub = app.add_subcommand("config", "Options and where their values come from");
  sub->require_subcommand(1);
  CLI::App* show_command = sub->add_subcommand("show", "Every option with its value, range, unit and source");
  show_command->add_flag("--origin", command->origin, "Say which of default, file, environment or flag won");
  command->settings.register_on(*show_command);
  show_command->footer(
      "Precedence: flag, environment (STONESTACK_SEARCH_FRICTION=0.3), ./stonestack.yaml, "
      "~/.config/stonestack/config.yaml, default.\n"
      "Defaults are those of `run`; of their own, `search` and `bench` plan for exact centres of mass "
      "(search.com_sigma 0), "
      "placements within\n1 mm and 0.5 deg (search.placement_sigma_translation 0.001, _rotation 0.0087) and "
      "any tilt "
      "(search.largest_tilt 3.14).\n"
      "Examples:\n"
      "  stonestack config show > stonestack.yaml      an option file to edit\n"
      "  stonestack config show --origin");
  show_command->callback([command] { show(*command); });
  CLI::App* cell_command =
      sub->add_subcommand("cell", "All that a cell file may hold: value, range, unit, source");
  cell_command->footer("Example:\n  stonestack config cell | grep faults    every fault of the simulators");
  cell_command->callback([] { show_cell(); });
}

}  // namespace stonestack::apps
