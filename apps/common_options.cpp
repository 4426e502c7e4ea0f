#include "common_options.hpp"

#include <iostream>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::apps {

void add_structure(CLI::App& command, std::string& wall, Settings* settings) {
  CLI::Option* of_wall = command.add_option("--wall,--target", wall,
                                            "Build a wall: stones a course (4+3+2+1), metres x courses "
                                            "(0.8x3), or a target file (.yaml): a wall or "
                                            "spans");
  CLI::Option* of_bridge = command.add_option(
      "--bridge", wall, "Build a bridge: stones over a gap of so many metres in which nothing stands");
  of_bridge->transform(CLI::Validator(
      [](std::string& span) {
        span.insert(0, "bridge:");
        return std::string();
      },
      ""));
  of_bridge->excludes(of_wall)->type_name("METRES");
  if (settings == nullptr) return;
  settings->bind(of_wall, "run.wall");
  settings->bind(of_bridge, "run.wall");
}

void add_objective(CLI::App& command, std::string& objective, Settings& settings) {
  settings.bind(command
                    .add_option("--objective", objective,
                                "Of the highest towers: height, the one likeliest to stand; firm, the one "
                                "likeliest to outlast a shake of the table")
                    ->check(CLI::IsMember({"height", "firm"}))
                    ->capture_default_str(),
                "search.objective");
}

CLI::Option* add_path(CLI::App& command, const std::string& name, std::string& value,
                      const std::string& description, const std::string& type) {
  return command.add_option(name, value, description)->type_name(type);
}

void Loudness::register_on(CLI::App& command) {
  CLI::Option* const less = command.add_flag("--quiet,-q", quiet, "Warnings and errors only on stderr");
  command.add_flag("--verbose,-v", verbose, "Also every event with its figures on stderr")->excludes(less);
}

void Loudness::apply() const {
  if (quiet) set_log_level(LogLevel::kWarning);
  if (verbose) set_log_level(LogLevel::kDebug);
}

void CommonOptions::register_stones(CLI::App& command) {
  add_path(command, "--catalogue", catalogue, "Folder of stones (default: the six that come with stonestack)",
           "DIR");
  settings.bind(command.add_option("--seed", seed, "Same seed, same result")
                    ->capture_default_str()
                    ->check(CLI::Range(0, 2147483647)),
                "*.seed");
}

void CommonOptions::register_draw(CLI::App& command) {
  register_stones(command);
  settings.register_on(command);
}

void CommonOptions::register_on(CLI::App& command, bool has_options) {
  register_stones(command);
  if (has_options) settings.register_on(command);
  command.add_flag("--json", json, "Result as JSON on stdout");
  loudness.register_on(command);
}

void CommonOptions::begin() const {
  loudness.apply();
}

void register_stone_options(CLI::App& sub, ModelOptions& options) {
  auto* density = sub.add_option("--density", options.density, "kg/m^3")
                      ->check(CLI::Range(100.0, 25000.0))
                      ->capture_default_str();
  sub.add_option("--mass", options.mass, "kg, weighed; instead of a density")
      ->check(CLI::Range(0.001, 10000.0))
      ->excludes(density);
  sub.add_option("--friction", options.friction, "Stone on stone, what the planner assumes")
      ->check(CLI::Range(0.001, 2.0))
      ->capture_default_str();
}

std::ostream& CommonOptions::text() const {
  return json ? std::cerr : std::cout;
}

Catalogue CommonOptions::read() const {
  return read_catalogue(catalogue.empty() ? data_path("stones") : catalogue);
}

void add_live_view(CLI::App& command, LiveView& view) {
  CLI::Option* const wanted = command.add_flag(
      "--view", view.wanted,
      "Serve the report while it grows, on 127.0.0.1; its stop button needs the printed token");
  command.add_option("--view-port", view.port, "Port of --view (0: any that is free)")
      ->check(CLI::Range(0, 65535))
      ->needs(wanted);
  view.announce = [](const std::string& address, const std::string& token) {
    clear_progress();
    std::cerr << "live view: " << address << "\nstop token: " << token << std::endl;
  };
}

void PerRun::register_on(CLI::App& command) {
  asked = command.add_option("--per-run", count, "How many stones of the catalogue lie in the field")
              ->check(CLI::Range(1, 100))
              ->capture_default_str();
}

void PerRun::check(const Catalogue& catalogue) const {
  const auto all = static_cast<int>(catalogue.stones.size());
  require(count <= all || asked->count() == 0, "--per-run ", count, ": ", catalogue.path, " has ", all,
          " stones; give --per-run ", all, " at most, or make more with `stonestack scan --generate`");
}

}  // namespace stonestack::apps
