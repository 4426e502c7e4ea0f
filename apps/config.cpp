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
  bool json = false;
};

nlohmann::json bound_json(double bound) {
  return std::abs(bound) < kUnlimited ? nlohmann::json(bound) : nlohmann::json(nullptr);
}

nlohmann::json option_json(const Field& field) {
  nlohmann::json option = {{"name", field.name}, {"source", field.source}};
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
  if (command.json) return print_json(list, origin);
  if (!command.origin) {
    std::cout << write_fields(list);
    return;
  }
  for (const auto& field : list)
    std::cout << field.name << ": " << field_text(field) << "  # " << origin(field.name) << '\n';
}

/// A cell file with every default, to copy lines from.
void show_cell(const ConfigCommand& command) {
  CellFile file;
  const FieldList list = join({cell_fields(file), fields(file.cell)});
  if (command.json) return print_json(list, {});
  std::cout << write_fields(list);
}

}  // namespace

void add_config(CLI::App& app) {
  auto command = std::make_shared<ConfigCommand>();
  CLI::App* sub = app.add_subcommand("config", "Options and where their values come from");
  sub->require_subcommand(1);
  CLI::App* show_command = sub->add_subcommand("show", "Every option with its value, range, unit and source");
  show_command->add_flag("--origin", command->origin, "Say which of default, file, environment or flag won");
  show_command->add_flag("--json", command->json, "As JSON, with the origin of each value");
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
  cell_command->add_flag("--json", command->json, "As JSON");
  cell_command->footer("Example:\n  stonestack config cell | grep faults    every fault of the simulators");
  cell_command->callback([command] { show_cell(*command); });
}

}  // namespace stonestack::apps
