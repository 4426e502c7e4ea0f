#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/emulators/simulated_servers.hpp"

namespace stonestack::apps {
namespace {

struct RearmCommand {
  Loudness loudness;
  std::string cell;
  bool yes = false;
  bool json = false;
};

void rearm(RearmCommand& command) {
  command.loudness.apply();
  const CellFile file = read_cell(command.cell);
  const auto confirm = [&](const ControllerState& state, const std::string& meaning, const auto& steps) {
    std::cerr << to_text(state) << '\n' << meaning << ".\nWould be done:";
    for (const std::string& step : steps) std::cerr << (&step == &steps.front() ? " " : ", ") << step;
    std::cerr << ".\n";
    return command.yes ||
           ask_person("Have you looked at the arm, and is nobody near it? Type yes: ") == "yes";
  };
  const Rearming done = rearm_arm(file.cell(), confirm);
  std::ostream& out = command.json ? std::cerr : std::cout;
  for (const std::string& step : done.steps) out << "done: " << step << '\n';
  out << to_text(done.after) << "; motions are allowed\n";
  if (command.json) std::cout << rearming_json(done);
}

}  // namespace

void add_rearm(CLI::App& app) {
  const auto [sub, command] = add_subcommand<RearmCommand>(
      app, "rearm", "Make a cell's arm ready again after a stop, once somebody has looked", rearm);
  add_path(sub, "CELL", command.cell, "Cell file")->required();
  sub.add_flag("--yes", command.yes, "Somebody has looked: do not ask");
  sub.add_flag("--json", command.json, "Result as JSON on stdout");
  command.loudness.register_on(sub);
  sub.footer(
      "Unlocks a protective stop, switches the arm on, releases its brakes: what its state needs. Nothing\n"
      "else in stonestack does. An emergency stop, a safeguard or a fault ends with what to do by hand and\n"
      "exit code 7, and so does an answer other than yes.\n"
      "Examples:\n"
      "  stonestack rearm my_lab.yaml\n"
      "  stonestack rearm my_lab.yaml --yes --json");
}

}  // namespace stonestack::apps
