#include <cmath>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "cell_input.hpp"
#include "commands.hpp"
#include "settings.hpp"

namespace stonestack::apps {
namespace {

constexpr double kUnlimited = 1e300;  // of FieldRange: no bound

struct ConfigCommand {
  Settings settings;
  bool origin = false;
  bool expert = false;
  bool json = false;
};

/// All, or those for users and what somebody set.
FieldList chosen(const FieldList& list, const ConfigCommand& command) {
  FieldList shown;
  for (const Field& field : list)
    if (command.expert || field.tier == Tier::kUser || command.settings.origin(field.name) != "default")
      shown.push_back(field);
  return shown;
}

nlohmann::json bound_json(double bound) {
  return std::abs(bound) < kUnlimited ? nlohmann::json(bound) : nlohmann::json(nullptr);
}

nlohmann::json option_json(const Field& field) {
  nlohmann::json option = {{"name", field.name}, {"description", field.description}};
  std::visit([&](const auto* value) { option["value"] = *value; }, field.value);
  if (option["value"].is_number()) {
    option["range"] = {bound_json(field.range.low), bound_json(field.range.high)};
    option["unit"] = field.unit;
  }
  return option;
}

/// `origin`: of an option by its name; empty: there is none.
void print_json(const FieldList& list, const std::function<std::string(const std::string&)>& origin) {
  nlohmann::json options = nlohmann::json::array();
  for (const auto& field : list) {
    options.push_back(option_json(field));
    if (origin) options.back()["origin"] = origin(field.name);
  }
  std::cout << nlohmann::json{{"schema", "stonestack.config/1"}, {"options", options}}.dump(2) << '\n';
}

void show(ConfigCommand& command) {
  EveryOption every;
  const FieldList list = every_field(every);
  command.settings.apply(list);
  const auto origin = [&](const std::string& name) { return command.settings.origin(name); };
  if (command.json) return print_json(chosen(list, command), origin);
  if (!command.origin) {
    std::cout << write_fields(chosen(list, command));
    return;
  }
  for (const auto& field : chosen(list, command))
    std::cout << field.name << ": " << field_text(field) << "  # " << origin(field.name) << '\n';
}

/// A cell file with defaults, to copy lines from.
void show_cell(const ConfigCommand& command) {
  CellFile file;
  const FieldList list = join({cell_fields(file), fields(file.cell)});
  const FieldList shown = command.expert ? list : user_fields(list);
  if (command.json) return print_json(shown, {});
  std::cout << write_fields(shown);
}

}  // namespace

void add_config(CLI::App& app) {
  auto command = std::make_shared<ConfigCommand>();
  CLI::App* sub = app.add_subcommand("config", "Options and where their values come from");
  sub->require_subcommand(1);
  CLI::App* show_command =
      sub->add_subcommand("show", "The options for users: value, range, unit and effect");
  show_command->add_flag("--origin", command->origin, "Say which of default, file, environment or flag won");
  show_command->add_flag("--expert", command->expert, "Every option, those for experts too");
  show_command->add_flag("--json", command->json, "As JSON, with the origin of each value");
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
  cell_command->add_flag("--json", command->json, "As JSON");
  cell_command->footer(
      "Example:\n  stonestack config cell --expert | grep faults    every fault of the simulators");
  cell_command->callback([command] { show_cell(*command); });
}

}  // namespace stonestack::apps
