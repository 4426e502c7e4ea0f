#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/geometry/convex_pieces.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/model_stone.hpp"

namespace stonestack::apps {
namespace {

struct ScanCommand {
  std::vector<std::string> files;
  std::string catalogue;
  std::string name;
  int generate = 0;
  std::uint64_t seed = 1;
  bool force = false, json = false, quiet = false;
  ModelOptions options;
};

/// One stone to be made: from a file, or generated when `number` is positive.
struct Task {
  std::string name;
  std::string file;
  int number = 0;
};

/// The file's stem with everything that a stone's name may not hold as '_'.
std::string name_of(const std::string& file) {
  std::string name = std::filesystem::path(file).stem().string().substr(0, 64);
  for (char& c : name)
    if (!is_stone_name(std::string("x") + c)) c = '_';
  if (!name.empty() && name.front() == '.') name.front() = '_';
  return name;
}

std::vector<Task> tasks(const ScanCommand& command) {
  std::vector<Task> list;
  for (const auto& file : command.files)
    list.push_back({command.name.empty() ? name_of(file) : command.name, file, 0});
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
            "' cannot be a stone's name (letters, digits, '_', '-',"
            " '.'); give --name");
    require(std::find(names.begin(), names.end(), task.name) == names.end(), "two stones would be named '",
            task.name, "'; rename a file or scan them one by one with --name");
    names.push_back(task.name);
    require(command.force || !std::filesystem::exists(std::filesystem::path(command.catalogue) / task.name),
            "stone '", task.name, "' is in ", command.catalogue,
            " already; --force replaces it, --name gives"
            " another name");
  }
}

ModelResult make(const Task& task, const ScanCommand& command) {
  if (task.number == 0) return model_stone(read_mesh(task.file), task.name, task.file, command.options);
  ModelOptions options = command.options;
  options.units = "m";
  options.scale = 1.0;
  const std::string source = concat("generated: limestone, seed ", command.seed, ", number ", task.number);
  const auto number = static_cast<std::uint64_t>(task.number);
  return model_stone(make_limestone(Random::stream(command.seed, number).bits()), task.name, source, options);
}

nlohmann::json to_json(const ModelResult& result, const std::string& folder) {
  const Stone& s = result.stone;
  const Eigen::Vector3d extents = bounds(s.scan).sizes();
  const auto deviation = [](const Deviation& d) {
    return nlohmann::json{{"median", d.median}, {"worst", d.worst}};
  };
  const Eigen::Vector3d p = s.T_O_file.translation();
  const Eigen::Quaterniond q(s.T_O_file.linear());
  return {{"name", s.name},
          {"folder", folder},
          {"source", s.source},
          {"mass", s.mass.mass},
          {"density", s.density},
          {"friction", s.friction},
          {"volume", volume(s.scan)},
          {"volume_over_hull", volume(s.scan) / volume(convex_hull(s.scan))},
          {"extents", {extents.x(), extents.y(), extents.z()}},
          {"scale", s.scale},
          {"T_O_file",
           {{"x", p.x()},
            {"y", p.y()},
            {"z", p.z()},
            {"qx", q.x()},
            {"qy", q.y()},
            {"qz", q.z()},
            {"qw", q.w()}}},
          {"scan_faces", s.scan.faces.size()},
          {"faces", s.mesh.faces.size()},
          {"pieces", s.pieces.size()},
          {"mesh_deviation", deviation(s.mesh_deviation)},
          {"contact_deviation", deviation(s.contact_deviation)},
          {"warnings", result.warnings}};
}

/// A line a stone on stderr, lengths in cm, deviations in mm.
void print_table(const nlohmann::json& stones) {
  std::cerr << "stone                 size (cm)           mass (kg)  vol/hull  faces  pieces"
               "  mesh off scan (mm)  contact off scan (mm): median / worst\n"
            << std::fixed;
  const auto mm = [](const nlohmann::json& metres) { return metres.get<double>() * 1000.0; };
  for (const auto& s : stones) {
    std::cerr << std::left << std::setw(20) << s["name"].get<std::string>() << std::right
              << std::setprecision(1);
    for (const auto& extent : s["extents"]) std::cerr << std::setw(6) << extent.get<double>() * 100.0;
    std::cerr << std::setprecision(2) << std::setw(13) << s["mass"].get<double>() << std::setprecision(3)
              << std::setw(10) << s["volume_over_hull"].get<double>() << std::setw(7) << s["faces"].get<int>()
              << std::setw(8) << s["pieces"].get<int>();
    for (const char* kind : {"mesh_deviation", "contact_deviation"})
      std::cerr << std::setw(kind[0] == 'm' ? 11 : 15) << mm(s[kind]["median"]) << " /" << std::setw(6)
                << mm(s[kind]["worst"]);
    std::cerr << '\n';
  }
}

/// Makes and stores one stone; the JSON about it.
nlohmann::json scan_one(const Task& task, const ScanCommand& command) {
  ModelResult result = make(task, command);
  if (const std::string why = unfit_for_gripper(result.stone, make_robotiq_3f()); !why.empty())
    result.warnings.push_back("the hand will not pick it up: " + why);
  for (const auto& warning : result.warnings) log_warning(concat(task.name, ": ", warning));
  write_stone(command.catalogue, result.stone);
  return to_json(result, (std::filesystem::path(command.catalogue) / task.name).string());
}

void scan(const ScanCommand& command) {
  if (command.quiet) set_log_level(LogLevel::kWarning);
  const std::vector<Task> list = tasks(command);
  check_names(list, command);
  require_writable(command.catalogue + "/stone.yaml");
  nlohmann::json stones = nlohmann::json::array(), failed = nlohmann::json::array();
  const Stopwatch watch;
  for (std::size_t n = 0; n < list.size(); ++n) {
    throw_if_interrupted();
    log_progress(concat("stone ", n + 1, " of ", list.size(), ": ", list[n].name));
    try {
      stones.push_back(scan_one(list[n], command));
    } catch (const FileError& problem) {
      if (list.size() == 1) throw;
      log_error(problem.what());
      failed.push_back({{"file", list[n].file}, {"error", problem.what()}});
    }
  }
  log_info(concat(stones.size(), " stones stored in ", command.catalogue, " in ",
                  static_cast<int>(watch.seconds() + 0.5), " s"));
  if (!command.quiet && !stones.empty()) print_table(stones);
  if (command.json)
    std::cout << nlohmann::json{{"schema", "stonestack.scan/1"}, {"stones", stones}, {"failed", failed}}.dump(
                     2)
              << '\n';
  if (!failed.empty())
    throw Error(concat(failed.size(), " of ", list.size(), " could not be made a stone, see above; ",
                       stones.empty() ? "none is stored" : "the others are stored"),
                ExitCode::kUnreadable);
}

void add_input(CLI::App& sub, ScanCommand& command) {
  sub.add_option("FILE", command.files,
                 "Scanned meshes (PLY, OBJ, STL, glTF, Collada, 3DS, OFF, FBX), closed or with holes");
  sub.add_option("--catalogue", command.catalogue, "Folder to store the stones in; made if missing")
      ->required()
      ->type_name("DIR");
  sub.add_option("--generate", command.generate, "Make N limestones, limestone_1 and so on")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  sub.add_option("--seed", command.seed, "Of --generate: same seed, same stones")->capture_default_str();
  sub.add_option("--name", command.name, "Name of the stone, for a single one (default: the file's name)");
}

void add_model(CLI::App& sub, ModelOptions& options) {
  sub.add_option("--units", options.units, "Unit of the files; auto: the one that makes a hand-size stone")
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
  auto command = std::make_shared<ScanCommand>();
  CLI::App* sub =
      app.add_subcommand("scan", "Turn scanned meshes into stones of a catalogue, or make limestones");
  add_input(*sub, *command);
  add_model(*sub, command->options);
  sub->add_flag("--force", command->force, "Replace stones that are in the catalogue already");
  sub->add_flag("--json", command->json, "Result as JSON on stdout");
  sub->add_flag("--quiet,-q", command->quiet, "Warnings and errors only on stderr");
  sub->footer(
      "Examples:\n"
      "  stonestack scan rock.ply --catalogue rocks --mass 1.3\n"
      "  stonestack scan scans/*.obj --catalogue rocks --units auto\n"
      "  stonestack scan boulder.obj --catalogue rocks --scale 0.12 --name small_boulder\n"
      "  stonestack scan --generate 6 --seed 1 --catalogue limestones");
  sub->callback([command] { scan(*command); });
}

}  // namespace stonestack::apps
