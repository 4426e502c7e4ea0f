#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <utility>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::apps {
namespace {

struct ScanCommand {
  std::vector<std::string> files;
  std::string catalogue;
  std::string name;
  int generate = 0;
  std::uint64_t seed = 1;
  bool force = false, json = false;
  Loudness loudness;
  ModelOptions options;
};

/// One stone to be made: from a file, or generated when `number` is positive.
struct Task {
  std::string name;
  std::string file;
  int number = 0;
};

std::vector<Task> tasks(const ScanCommand& command) {
  std::vector<Task> list;
  for (const auto& file : command.files)
    list.push_back({command.name.empty() ? stone_name_of(file) : command.name, file, 0});
  for (int n = 1; n <= command.generate; ++n) list.push_back({concat("limestone_", n), "", n});
  require(!list.empty(), "nothing to do; give scanned FILEs or --generate N");
  require(command.name.empty() || list.size() == 1, "--name is for one stone, got ", list.size());
  require(command.options.mass == 0.0 || list.size() == 1, "--mass is for one stone, got ", list.size(),
          "; give --density");
  return list;
}

/// Two stones of one name, or one that is there already: refused before any work is done.
void check_names(const std::vector<Task>& list, const ScanCommand& command) {
  std::vector<std::string> names;
  for (const Task& task : list) {
    require(is_stone_name(task.name), "'", task.name,
            "' cannot be a stone's name (letters, digits, '_', '-', '.'); give --name");
    require(std::find(names.begin(), names.end(), task.name) == names.end(), "two stones would be named '",
            task.name, "'; rename a file or scan them one by one with --name");
    names.push_back(task.name);
    require(command.force || !std::filesystem::exists(std::filesystem::path(command.catalogue) / task.name),
            "stone '", task.name, "' is in ", command.catalogue,
            " already; --force replaces it, --name gives another name");
  }
}

/// Makes and stores one stone.
StoneSummary scan_one(const Task& task, const ScanCommand& command) {
  ModelResult result = task.number > 0
                           ? model_limestone(command.seed, task.number, command.options)
                           : model_stone(read_mesh(task.file), task.name, task.file, command.options);
  if (const std::string why = unfit_for_gripper(result.stone, make_robotiq_3f()); !why.empty())
    result.warnings.push_back("the gripper will not pick it up: " + why);
  for (const auto& warning : result.warnings) log_warning(concat(task.name, ": ", warning));
  write_stone(command.catalogue, result.stone);
  return summary_of(std::move(result));
}

void scan(ScanCommand& command) {
  command.loudness.apply();
  const std::vector<Task> list = tasks(command);
  check_names(list, command);
  require_writable(command.catalogue + "/stone.yaml");
  std::vector<StoneSummary> stones;
  std::vector<FailedScan> failed;
  const Stopwatch watch;
  for (const Task& task : list) {
    throw_if_interrupted();
    const auto done = static_cast<double>(stones.size() + failed.size());
    show_progress(
        {"scan", done, static_cast<double>(list.size()), "stones", "now " + task.name, watch.seconds()});
    try {
      stones.push_back(scan_one(task, command));
    } catch (const FileError& problem) {
      if (list.size() == 1) throw;
      log_error(problem.what());
      failed.push_back({task.file, problem.what()});
    }
  }
  log_info(concat(stones.size(), " stones stored in ", command.catalogue, " in ",
                  std::lround(watch.seconds()), " s"));
  if (command.json)
    std::cout << stones_json(stones, command.catalogue, failed);
  else if (!stones.empty())
    std::cout << stones_table(stones);
  if (!failed.empty())
    throw Error(concat(failed.size(), " of ", list.size(), " could not be made a stone, see above; ",
                       stones.empty() ? "none is stored" : "the others are stored"),
                ExitCode::kUnreadable);
}

void add_model(CLI::App& sub, ModelOptions& options) {
  sub.add_option("--units", options.units,
                 "Unit of the files; auto: the one that gives a stone of graspable size")
      ->check(CLI::IsMember({"m", "cm", "mm", "auto"}))
      ->capture_default_str();
  sub.add_option("--scale", options.scale, "Further factor on the size, e.g. 0.12 for boulders")
      ->check(CLI::Range(1e-6, 1e6))
      ->capture_default_str();
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

}  // namespace

void add_scan(CLI::App& app) {
  const auto [sub, command] = add_subcommand<ScanCommand>(
      app, "scan", "Turn scanned meshes into stones of a catalogue, or make limestones", scan);
  sub.add_option("FILE", command.files,
                 "Scanned meshes (PLY, OBJ, STL, glTF, Collada, 3DS, OFF, FBX), closed or with holes");
  add_path(sub, "--catalogue", command.catalogue, "Folder to store the stones in; made if missing", "DIR")
      ->required();
  sub.add_option("--generate", command.generate, "Make N limestones, limestone_1 and so on")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  sub.add_option("--seed", command.seed, "Seed of --generate: same seed, same stones")->capture_default_str();
  sub.add_option("--name", command.name, "Name of the stone, for a single one (default: the file's name)");
  add_model(sub, command.options);
  sub.add_flag("--force", command.force, "Replace stones that are in the catalogue already");
  sub.add_flag("--json", command.json, "Result as JSON on stdout");
  command.loudness.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack scan rock.ply --catalogue rocks --mass 1.3\n"
      "  stonestack scan scans/*.obj --catalogue rocks --units auto\n"
      "  stonestack scan boulder.obj --catalogue rocks --scale 0.12 --name small_boulder\n"
      "  stonestack scan --generate 6 --seed 1 --catalogue limestones");
}

}  // namespace stonestack::apps
