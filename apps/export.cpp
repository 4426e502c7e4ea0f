#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::apps {
namespace {

struct ExportCommand {
  std::string run, format, out;
  bool json = false;
  Loudness loudness;
};

void export_files(ExportCommand& command) {
  command.loudness.apply();
  const auto files = export_run(command.run, command.format, command.out);
  if (command.json) std::cout << export_json(command.format, files);
  for (const std::string& path : files) (command.json ? std::cerr : std::cout) << path << '\n';
}

}  // namespace

void add_export(CLI::App& app) {
  const auto [sub, command] = add_subcommand<ExportCommand>(
      app, "export", "Write a recorded run in another program's format", export_files);
  add_path(sub, "RUN", command.run, "Folder of a run that ended", "DIR")->required();
  sub.add_option("--to", command.format,
                 "glb (stones with an animation of the run), ply (the tower as one mesh), urdf (stones as "
                 "links), csv "
                 "(placements, trajectory), mcap (joints, gripper, stones, log), png (picture), compas "
                 "(assembly with "
                 "sequence and trajectories)")
      ->required()
      ->type_name("FORMAT")
      ->check(CLI::IsMember(export_formats()));
  add_path(sub, "--out", command.out, "Folder to write to; made if missing (default: RUN/export)", "DIR");
  sub.add_flag("--json", command.json, "Result as JSON on stdout");
  command.loudness.register_on(sub);
  sub.footer(
      "Prints the paths of the files. Stones are where they were measured last.\n"
      "Examples:\n"
      "  stonestack export runs/20250101-143000-seed1 --to glb\n"
      "  stonestack export runs/20250101-143000-seed1 --to compas --out assembly\n"
      "  stonestack export runs/20250101-143000-seed1 --to mcap --out /tmp/run");
}

}  // namespace stonestack::apps
