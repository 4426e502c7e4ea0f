#include "commands.hpp"
#include "program.hpp"

namespace {

void set_up(CLI::App& app) {
  app.name("stonestack");
  app.description("stonestack: finds scanned stones, plans stable towers, builds them with a robot arm.");
  app.footer(
      "Examples:\n"
      "  stonestack run --robot ur10                build a tower in the simulated cell\n"
      "  stonestack search --stones limestone_1,limestone_2 --levels 2\n"
      "  stonestack help COMMAND                    what a command takes, with examples\n"
      "Exit codes: 0 done, 2 usage, 3 unreadable input, 4 nothing detected, 5 no stable pose,\n"
      "            6 planning or execution failed, 7 safety stop, 130 interrupted");
  const std::initializer_list<void (*)(CLI::App&)> commands{
      // in the order of the help
      stonestack::apps::add_scan,      stonestack::apps::add_render, stonestack::apps::add_detect,
      stonestack::apps::add_segment,   stonestack::apps::add_model,  stonestack::apps::add_track,
      stonestack::apps::add_search,    stonestack::apps::add_check,  stonestack::apps::add_plan,
      stonestack::apps::add_run,       stonestack::apps::add_decide, stonestack::apps::add_inspect,
      stonestack::apps::add_replay,    stonestack::apps::add_export, stonestack::apps::add_experiment,
      stonestack::apps::add_simulate,  stonestack::apps::add_doctor, stonestack::apps::add_record,
      stonestack::apps::add_calibrate, stonestack::apps::add_rearm,  stonestack::apps::add_setup,
      stonestack::apps::add_view,      stonestack::apps::add_config, stonestack::apps::add_completion,
  };
  for (const auto add : commands) add(app);
}

}  // namespace

int main(int argc, char** argv) {
  return stonestack::apps::run_program(argc, argv, set_up);
}
