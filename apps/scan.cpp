#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/report/results.hpp"
#include "version.hpp"

namespace stonestack::apps {
namespace {

struct ScanCommand {
  ScanOrder order;
  std::string cell;
  bool execute = false, json = false;
  Loudness loudness;
};

void print(const ScanCommand& command, const ScannedStones& made) {
  if (command.json)
    std::cout << stones_json(made.stones, command.order.catalogue, made.failed);
  else if (!made.stones.empty())
    std::cout << stones_table(made.stones);
}

/// The arm looks at what lies in its field; nothing is built.
void scan_in_cell(const ScanCommand& command) {
  RunOrder order;
  order.cell = read_cell(command.cell);
  require(order.cell->simulate || command.execute, "--cell ", command.cell, " moves the robot at ",
          order.cell->arm_address(), ": clear its cell of people and add --execute");
  order.run.build.unseen = order.only_model = true;
  order.save_catalogue = command.order.catalogue;
  order.replace_stones = command.order.force;
  order.version = program_version();
  const RecordedRun done = record_run(order, read_catalogue(data_path("stones")));
  print(command, modelled_stones(done.report));
  if (const ExitCode code = exit_code(done.report.result); code != ExitCode::kDone)
    throw Error(done.report.result.ended, code);
}

void scan(ScanCommand& command) {
  command.loudness.apply();
  if (!command.cell.empty()) return scan_in_cell(command);
  const ScannedStones made = scan_stones(command.order);
  print(command, made);
  if (!made.failed.empty())
    throw Error(concat(made.failed.size(), " of ", made.stones.size() + made.failed.size(),
                       " could not be made a stone, see above; ",
                       made.stones.empty() ? "none is stored" : "the others are stored"),
                ExitCode::kUnreadable);
}

void add_scan_options(CLI::App& sub, ModelOptions& options) {
  sub.add_option("--units", options.units,
                 "Unit of the files; auto: the one that gives a stone of graspable size")
      ->check(CLI::IsMember({"m", "cm", "mm", "auto"}))
      ->capture_default_str();
  sub.add_option("--scale", options.scale, "Further factor on the size, e.g. 0.12 for boulders")
      ->check(CLI::Range(1e-6, 1e6))
      ->capture_default_str();
  register_stone_options(sub, options);
}

}  // namespace

void add_scan(CLI::App& app) {
  const auto [sub, command] = add_subcommand<ScanCommand>(
      app, "scan",
      "Turn scanned meshes into stones of a catalogue, let the arm scan its field, or make limestones", scan);
  sub.add_option("FILE", command.order.files,
                 "Scanned meshes (PLY, OBJ, STL, glTF, Collada, 3DS, OFF, FBX), closed or with holes");
  add_path(sub, "--catalogue", command.order.catalogue, "Folder to store the stones in; made if missing",
           "DIR")
      ->required();
  sub.add_option("--generate", command.order.generate, "Make N limestones, limestone_1 and so on")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  sub.add_option("--seed", command.order.seed, "Seed of --generate: same seed, same stones")
      ->capture_default_str();
  sub.add_option("--name", command.order.name,
                 "Name of the stone, for a single one (default: the file's name)");
  add_scan_options(sub, command.order.options);
  sub.add_flag("--force", command.order.force, "Replace stones that are in the catalogue already");
  auto* cell = add_path(
      sub, "--cell", command.cell,
      "Let the arm of this cell look at the stones in its field and model them; no FILE then", "FILE");
  for (const char* other :
       {"FILE", "--generate", "--name", "--units", "--scale", "--density", "--mass", "--friction"})
    cell->excludes(sub.get_option(other));
  sub.add_flag("--execute", command.execute, "With --cell: move a real arm");
  sub.add_flag("--json", command.json, "Result as JSON on stdout");
  command.loudness.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack scan rock.ply --catalogue rocks --mass 1.3\n"
      "  stonestack scan scans/*.obj --catalogue rocks --units auto\n"
      "  stonestack scan boulder.obj --catalogue rocks --scale 0.12 --name small_boulder\n"
      "  stonestack scan --cell my-cell.yaml --catalogue rocks --execute\n"
      "  stonestack scan --generate 6 --seed 1 --catalogue limestones");
}

}  // namespace stonestack::apps
