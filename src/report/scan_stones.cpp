#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "modelling/no_model.hpp"
#include "modelling/surface_known.hpp"
#include "report/text.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

constexpr double kCertain = 0.0005, kUncertain = 0.01;  // m: ends of the colours of an error map

/// One stone to be made: from a file, or generated when `number` is positive.
struct Task {
  std::string name;
  std::string file;
  int number = 0;
};

std::vector<Task> tasks(const ScanOrder& order) {
  std::vector<Task> list;
  for (const auto& file : order.files)
    list.push_back({order.name.empty() ? stone_name_of(file) : order.name, file, 0});
  for (int n = 1; n <= order.generate; ++n) list.push_back({concat("limestone_", n), "", n});
  require(!list.empty(), "nothing to do; give scanned FILEs, --cell FILE or --generate N");
  require(order.name.empty() || list.size() == 1, "--name is for one stone, got ", list.size());
  require(order.options.mass == 0.0 || list.size() == 1, "--mass is for one stone, got ", list.size(),
          "; give --density");
  return list;
}

void require_free(const std::string& catalogue, const std::string& name, bool force) {
  require(force || !std::filesystem::exists(std::filesystem::path(catalogue) / name), "stone '", name,
          "' is in ", catalogue, " already; --force replaces it, another name keeps both");
}

/// Two stones of one name, or one that is there already: refused before any work is done.
void check_names(const std::vector<Task>& list, const ScanOrder& order) {
  std::vector<std::string> names;
  for (const Task& task : list) {
    require(is_stone_name(task.name), "'", task.name,
            "' cannot be a stone's name (letters, digits, '_', '-', '.'); give --name");
    require(std::find(names.begin(), names.end(), task.name) == names.end(), "two stones would be named '",
            task.name, "'; rename a file or scan them one by one with --name");
    names.push_back(task.name);
    require_free(order.catalogue, task.name, order.force);
  }
}

StoneSummary store(ModelResult result, const std::string& catalogue) {
  if (const std::string why = unfit_for_gripper(result.stone, make_robotiq_3f()); !why.empty())
    result.warnings.push_back("the gripper will not pick it up: " + why);
  for (const auto& warning : result.warnings) log_warning(concat(result.stone.name, ": ", warning));
  write_stone(catalogue, result.stone);
  return summary_of(std::move(result));
}

/// Share of red of a standard deviation: 0 known, 1 not known.
double redness(double sigma) {
  const double share = std::log(std::max(sigma, 1e-6) / kCertain) / std::log(kUncertain / kCertain);
  return std::clamp(share, 0.0, 1.0);
}

/// ASCII PLY: the surface in O with what is known of each vertex.
void write_uncertainty(const std::string& path, const ObjectModel& model, const Pose& T_O_model) {
  std::string text = concat(
      "ply\nformat ascii 1.0\ncomment sigma: standard deviation of the surface [m]; seen: 1 where a view "
      "showed it\n",
      "element vertex ", model.mesh.vertices.size(),
      "\nproperty float x\nproperty float y\nproperty float z\nproperty float sigma\nproperty uchar seen\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face ",
      model.mesh.faces.size(), "\nproperty list uchar int vertex_indices\nend_header\n");
  for (std::size_t v = 0; v < model.mesh.vertices.size(); ++v) {
    const Eigen::Vector3d p = T_O_model * model.mesh.vertices[v];
    const double red = redness(model.sigma[v]);
    text += format("%.6f %.6f %.6f %.6f %d %d %d %d\n", p.x(), p.y(), p.z(), model.sigma[v], model.seen[v],
                   static_cast<int>(255 * red), 90, static_cast<int>(255 * (1 - red)));
  }
  for (const auto& face : model.mesh.faces) text += format("3 %d %d %d\n", face[0], face[1], face[2]);
  write_file(path, text);
}

}  // namespace

ScannedStones scan_stones(const ScanOrder& order) {
  const std::vector<Task> list = tasks(order);
  check_names(list, order);
  require_writable(order.catalogue + "/stone.yaml");
  ScannedStones made;
  const Stopwatch watch;
  for (const Task& task : list) {
    throw_if_interrupted();
    const auto done = static_cast<double>(made.stones.size() + made.failed.size());
    show_progress(
        {"scan", done, static_cast<double>(list.size()), "stones", "now " + task.name, watch.seconds()});
    try {
      made.stones.push_back(
          store(task.number > 0 ? model_limestone(order.seed, task.number, order.options)
                                : model_stone(read_mesh(task.file), task.name, task.file, order.options),
                order.catalogue));
    } catch (const FileError& problem) {
      if (list.size() == 1) throw;
      log_error(problem.what());
      made.failed.push_back({task.file, problem.what()});
    }
  }
  log_info(concat(made.stones.size(), " stones stored in ", order.catalogue, " in ",
                  std::lround(watch.seconds()), " s"));
  return made;
}

ScannedStones modelled_stones(const RunReport& report) {
  ScannedStones made;
  if (!report.modelling) return made;
  for (const std::string& left : report.modelling->left_out) made.failed.push_back({"", left});
  if (report.modelling->stones.empty()) return made;
  const Catalogue catalogue = read_catalogue(report.modelling->folder);
  for (const StoneModelReport& stone : report.modelling->stones) {
    ModelResult result{catalogue[catalogue.index(stone.name)], {}};
    if (!stone.note.empty()) result.warnings.push_back(stone.note);
    made.stones.push_back(summary_of(std::move(result)));
  }
  return made;
}

ModelledViews model_views(const ModelOrder& order) {
  require(is_stone_name(order.prefix + "_1"), "'", order.prefix,
          "' cannot begin a stone's name (letters, digits, '_', '-', '.')");
  ModelledViews made;
  const Stopwatch watch;
  made.scene = align_scene(order.views, order.modelling);
  const auto& objects = made.scene.segmentation.objects;
  require(order.stone.mass == 0.0 || objects.size() == 1, "--mass is for one stone, the views show ",
          objects.size(), "; give --density");
  for (std::size_t k = 0; k < objects.size(); ++k)
    require_free(order.catalogue, concat(order.prefix, "_", k + 1), order.force);
  require_writable(order.catalogue + "/stone.yaml");
  for (std::size_t k = 0; k < objects.size(); ++k) {
    throw_if_interrupted();
    const std::string name = concat(order.prefix, "_", k + 1);
    show_progress({"model", static_cast<double>(k), static_cast<double>(objects.size()), "stones",
                   "now " + name, watch.seconds()});
    const LyingObject lying{&made.scene, static_cast<int>(k)};
    try {
      std::optional<ObjectModel> model = model_object({&lying, 1}, order.modelling);
      if (!model) {
        log_error(concat(name, ": ", modelling::kNoModel));
        made.failed.push_back({name, modelling::kNoModel});
        continue;
      }
      ModelResult result =
          model_stone(model->mesh, name, concat("modelled from ", model->views, " views"), order.stone);
      result.stone.surface = modelling::surface_known(result.stone, *model, {Eigen::Vector3d::UnitZ()});
      const Pose T_O_model = result.stone.T_O_file;
      if (objects[k].cut_off) result.warnings.push_back("it reaches out of an image: a part may be missing");
      made.stones.push_back(store(std::move(result), order.catalogue));
      write_uncertainty(concat(order.catalogue, "/", name, "/uncertainty.ply"), *model, T_O_model);
      made.models.push_back(std::move(*model));
    } catch (const Interrupted&) {
      throw;
    } catch (const Error& problem) {
      log_error(problem.what());
      made.failed.push_back({name, problem.what()});
    }
  }
  clear_progress();
  log_info(concat(made.stones.size(), " stones stored in ", order.catalogue, " in ",
                  std::lround(watch.seconds()), " s; views agree within ", 1e3 * made.scene.apart_after,
                  " mm"));
  return made;
}

}  // namespace stonestack::report
