#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/record_run.hpp"
#include "version.hpp"

namespace stonestack::apps {
namespace {

struct RecordCommand {
  CommonOptions common;
  std::string robot;  ///< empty: the cell's, or a UR10
  std::string cell;
  PerRun per_run;
  ViewsOrder order;
};

void set_options(RecordCommand& command) {
  ViewsOrder& order = command.order;
  order.simulation.seed = command.common.seed;
  const FieldList simulation = nest("simulation", fields(order.simulation));
  order.per_run = command.per_run.count;
  order.version = program_version();
  if (command.cell.empty()) {
    command.common.settings.apply(simulation);
    order.robot = read_robot(command.robot.empty() ? "ur10" : command.robot);
    return;
  }
  order.cell = read_cell(command.cell);
  set_cell(*order.cell, [&](const FieldList& list) {
    command.common.settings.apply(join({list, simulation}));
  });
  require(command.robot.empty() || command.robot == order.cell->robot(), "--robot ", command.robot,
          " is not the robot of ", command.cell, ", ", order.cell->robot());
}

void record(RecordCommand& command) {
  set_options(command);
  Catalogue catalogue;
  if (!command.order.cell || command.order.cell->simulate) {
    catalogue = command.common.read();
    command.per_run.check(catalogue);
  }
  const RecordedViews done = record_views(command.order, catalogue);
  clear_progress();
  std::cout << (command.common.json ? views_json(done) : views_table(done));
  if (done.ended != "done") throw Interrupted();
}

}  // namespace

void add_record(CLI::App& app) {
  const auto [sub, command] = add_subcommand<RecordCommand>(
      app, "record", "Record what a cell's camera sees, with the arm's poses; moves nothing", record);
  ViewsOrder& order = command.order;
  add_path(sub, "--cell", command.cell,
           "Cell file, or the name of one that comes with stonestack; without: simulated in process");
  sub.add_option("--robot", command.robot, "Robot of the simulated cell (default: the cell's, or ur10)");
  add_path(sub, "--out", order.out, "Folder to write to; made if missing", "DIR")->required();
  sub.add_option("--frames", order.frames, "Number of depth frames to take")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub.add_option("--every", order.every, "Seconds from the start of one frame to the next, at least")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  sub.add_flag("--force", order.replace, "Write into a folder that is not empty; replace its recording");
  command.per_run.register_on(sub);
  command.common.register_on(sub);
  sub.footer(
      "Writes depth/NNNNNN.png, scene_camera.json (BOP's layout) and record.json, frame by frame: what was\n"
      "recorded before Ctrl-C or an error can be read. detect, segment, track and search take the folder.\n"
      "Without arm.address (--set arm.address=) it records the camera alone, without poses.\n"
      "Examples:\n"
      "  stonestack record --cell my_lab.yaml --out report     # to go with a bug report\n"
      "  stonestack record --cell my_lab.yaml --out views --frames 20 --every 5    # move the arm by hand\n"
      "  stonestack record --robot ur10 --seed 3 --out views && stonestack detect views\n"
      "  stonestack record --cell loopback-ur10 --out views --force --json\n"
      "  stonestack record --out views --set simulation.cell=lab --set simulation.sensor=d435");
}

}  // namespace stonestack::apps
